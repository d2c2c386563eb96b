"""The colours of a rendered scene by what is seen: the page tells for each pixel what it shows, and its colour."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from browser import Browser
from colours import SIGHTS, difference, lab

_PIXELS = """((camera, place, held) => {
  const { viewer } = pilegrasp;
  const { THREE } = meshcat;
  const bodies = pilegrasp.panels[0].data.bodies.map((body) => [body, meshcat.node(viewer, body.path)]);
  const shown = [];
  for (const [body, node] of bodies) {
    node.traverse((mesh) => {
      let visible = true;
      for (let up = mesh; up; up = up.parent) visible &&= up.visible;
      if (!mesh.isMesh || !visible) return;
      let kind = body.role;
      if (kind === "support") kind = mesh.geometry.type === "PlaneGeometry" ? "table" : "wall";
      if (kind === "object") kind = held.includes(body.path) ? `held ${body.name}` : "other";
      if (kind === "hand" && !body.finger && mesh.name !== "tube") kind = "palm";
      if (mesh.material.side === 1) kind = "outline";
      shown.push([mesh, kind]);
    });
  }
  viewer.scene.traverse((mesh) => {
    if (mesh.name !== "tube") return;
    mesh.geometry.computeBoundingSphere();
    shown.push([mesh, "hand"]);
  });
  const kinds = new Map(shown);
  // What the page fades in this picture is meant to look like what is behind it.
  const draw = viewer.renderer.render.bind(viewer.renderer);
  viewer.renderer.render = (scene, drawn) => {
    draw(scene, drawn);
    if (drawn === camera) for (const [mesh] of shown) if (mesh.material.opacity < 0.2) kinds.set(mesh, "faded");
  };
  viewer.render();
  viewer.renderer.render = draw;
  const canvas = document.querySelector(".pane canvas");
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext("2d");
  pen.drawImage(canvas, 0, 0);
  const scale = canvas.width / canvas.clientWidth;
  const bytes = pen.getImageData(0, 0, copy.width, copy.height).data;
  const ray = new THREE.Raycaster();
  const meshes = shown.map(([mesh]) => mesh);
  const found = {};
  const [left, bottom, width, height] = place;
  for (let y = 2; y < height; y += 4) {
    for (let x = 2; x < width; x += 4) {
      ray.setFromCamera({ x: (2 * x) / width - 1, y: (2 * y) / height - 1 }, camera);
      const [hit] = ray.intersectObjects(meshes, false);
      if (!hit) continue;
      const row = copy.height - 1 - Math.round(scale * (bottom + y));
      const at = 4 * (row * copy.width + Math.round(scale * (left + x)));
      (found[kinds.get(hit.object)] ??= []).push([bytes[at], bytes[at + 1], bytes[at + 2]]);
    }
  }
  return found;
})"""

KINDS = ("hand", "table", "wall", "outline")
"""What must be told apart, beside each held object."""

FEWEST = 7
"""Fewest pixels of a kind that are judged."""


def seen_colours(browser: Browser, near: bool, held: list[str]) -> dict[str, np.ndarray]:
    """Return the median colour (3,) in 0..255 of each kind of pixel in the whole picture or in the near one.

    Args:
        browser: Browser with an open page that is paused.
        near: Whether to look at the near picture.
        held: Paths of the objects in the hand.
    """
    cameras = "pilegrasp.panels[0].cameras"
    which = f"{cameras}.near, {cameras}.places()[1]" if near else f"pilegrasp.viewer.camera, {cameras}.places()[0]"
    found: dict[str, Any] = browser.evaluate(f"{_PIXELS}({which}, {held})")
    return {kind: np.median(np.array(colors), axis=0) for kind, colors in found.items() if len(colors) >= FEWEST}


def smallest_differences(colors: dict[str, np.ndarray]) -> dict[str, tuple[float, str, str]]:
    """Return the smallest CIEDE2000 between two kinds, and the two, for each kind of sight."""
    judged = [kind for kind in colors if kind in KINDS or kind.startswith("held")]
    # Two held objects may look alike.
    pairs = [pair for pair in combinations(judged, 2) if not all(kind.startswith("held") for kind in pair)]
    return {
        sight: min((float(difference(lab(colors[a], sight), lab(colors[b], sight))), a, b) for a, b in pairs)
        for sight in SIGHTS
    }
