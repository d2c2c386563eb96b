"""The grasp can be seen: close-up, cameras, what hides the fingers fades, and colours that everyone can tell apart."""

from __future__ import annotations

import numpy as np
import pytest

from pilegrasp_ctrl.analysis.carried import carried_in
from pilegrasp_ctrl.episode import run
from pilegrasp_ctrl.viewer import write_html
from pilegrasp_ctrl.viewer.scene.commands import node_path
from seen_colours import seen_colours, smallest_differences
from synthetic_recording import WALL_X, synthetic

pytestmark = [pytest.mark.browser, pytest.mark.slow]

LEAST_DIFFERENCE = 10.0
"""Least CIEDE2000 between hand, table, wall, held object and outline."""

CAMERAS = "pilegrasp.panels[0].cameras"

ONLY = """document.querySelectorAll("[data-overlay]").forEach((box) =>
  NAMES.includes(box.dataset.overlay) === box.checked || box.click())"""


def projected(browser, points, near=False):
    """Places (n, 2) of points of the scene in a picture, -1 to 1."""
    camera = f"{CAMERAS}.near" if near else "pilegrasp.viewer.camera"
    browser.evaluate("pilegrasp.viewer.render()")
    return np.array(
        browser.evaluate(f"""{np.asarray(points).tolist()}.map(([x, y, z]) => {{
          {camera}.updateMatrixWorld();
          const place = new meshcat.THREE.Vector3(x, z, -y).project({camera});
          return [place.x, place.y];
        }})""")
    )


def faded(browser, near):
    """Roles of the meshes that are drawn almost as glass in a picture."""
    return browser.evaluate(f"""(() => {{
      const seen = new Set();
      const {{ renderer }} = pilegrasp.viewer;
      const draw = renderer.render.bind(renderer);
      const {{ bodies }} = pilegrasp.panels[0].data;
      const roles = bodies.map(({{ path, role }}) => [role, meshcat.node(pilegrasp.viewer, path)]);
      renderer.render = (drawn, camera) => {{
        draw(drawn, camera);
        if ((camera === {CAMERAS}.near) !== {str(near).lower()}) return;
        for (const [role, node] of roles) node.traverse((mesh) => mesh.material?.opacity < 0.2 && seen.add(role));
      }};
      pilegrasp.viewer.render();
      renderer.render = draw;
      return [...seen].sort();
    }})()""")


@pytest.fixture
def wide(opened):
    opened.resize(1400, 900)
    opened.evaluate("pilegrasp.pause(); pilegrasp.seek(7); document.getElementById('reframe').click()")
    return opened


def test_the_whole_view_holds_the_arms_base(wide, attempt):
    base = attempt.body_position[0, [body.name for body in attempt.bodies].index("base")]
    places = projected(wide, [base, [0.09, 0.0, 0.0], [WALL_X, 0.0, 0.1], *attempt.body_position[210]])
    assert np.abs(places).max() < 1.0


def test_the_close_up_shows_the_hand_larger_and_in_the_middle(wide, attempt):
    hand = attempt.body_position[210, [body.role == "hand" for body in attempt.bodies]]
    far, near = projected(wide, hand), projected(wide, hand, near=True)
    assert np.abs(near).max() < 1.0
    assert np.ptp(near, axis=0).max() > 2.5 * np.ptp(far, axis=0).max()
    places = wide.evaluate(f"{CAMERAS}.places()")
    # Side by side on a screen; on a phone the close-up lies in a corner.
    assert places[0][2] == places[1][0]
    wide.resize(390, 844)
    wide.evaluate("window.dispatchEvent(new Event('resize'))")
    far, near = wide.evaluate(f"{CAMERAS}.places()")
    assert near[2] < 0.5 * far[2]
    assert near[0] == 0


def test_the_close_up_can_be_switched_off(wide):
    wide.evaluate("document.getElementById('closeup').click()")
    assert wide.evaluate(f"{CAMERAS}.places()[1]") is None
    wide.evaluate("document.getElementById('closeup').click()")
    assert wide.evaluate(f"{CAMERAS}.places()[1]") is not None


def test_the_cameras_follow_the_hand_and_look_from_above_and_from_below(wide, attempt):
    up = "pilegrasp.viewer.camera.position.clone().sub(pilegrasp.viewer.controls.target).normalize().y"
    wide.evaluate("pilegrasp.setCamera('follow'); pilegrasp.seek(3)")
    target = "pilegrasp.viewer.controls.target.toArray()"
    before = np.array(wide.evaluate(target))
    wide.evaluate("pilegrasp.seek(6)")
    tool = attempt.signals["tool_position"][[300, 600]].astype(float)
    moved = np.array(wide.evaluate(target)) - before
    np.testing.assert_allclose([moved[0], -moved[2], moved[1]], tool[1] - tool[0], atol=0.01)
    wide.evaluate("pilegrasp.setCamera('above')")
    assert wide.evaluate(up) > 0.99
    wide.evaluate("pilegrasp.setCamera('under')")
    assert wide.evaluate(up) < -0.8
    wide.evaluate("document.getElementById('reframe').click()")
    assert wide.evaluate("document.getElementById('camera').value") == "whole"


def test_a_wall_between_the_camera_and_the_fingers_fades(browser, tmp_path):
    write_html(synthetic(), tmp_path / "a.html")
    browser.open(tmp_path / "a.html", 1400, 900)
    browser.evaluate("pilegrasp.ready.then(() => pilegrasp.seek(6.4))")
    assert "support" not in faded(browser, near=True)
    # From the other side of the wall.
    browser.evaluate("""pilegrasp.viewer.controls.target.set(0.78, 0.03, 0);
      pilegrasp.viewer.camera.position.set(2.2, 0.35, 0); pilegrasp.viewer.controls.update()""")
    assert "support" in faded(browser, near=True)
    # After the picture, everything is as it was.
    left = """pilegrasp.panels[0].data.bodies.filter(({ path }) => {
      let faded = false;
      meshcat.node(pilegrasp.viewer, path).traverse((mesh) => (faded ||= mesh.material?.opacity < 0.2));
      return faded;
    }).length"""
    assert browser.evaluate(left) == 0


def test_the_palm_is_round_and_keeps_its_extent(wide, attempt):
    index = [body.name for body in attempt.bodies].index("palm")
    path = node_path(index, attempt.bodies[index])
    low, high, corners = wide.evaluate(f"""(() => {{
      let found = null;
      meshcat.node(pilegrasp.viewer, "{path}/<object>").traverse((mesh) => (found ??= mesh.isMesh ? mesh : null));
      found.geometry.computeBoundingBox();
      const {{ min, max }} = found.geometry.boundingBox;
      const position = found.geometry.attributes.position;
      let corners = 0;
      for (let k = 0; k < position.count; k++) {{
        const [x, y, z] = [position.getX(k), position.getY(k), position.getZ(k)].map(Math.abs);
        corners += x > 0.0115 && y > 0.0495 && z > 0.0445;
      }}
      return [min.toArray(), max.toArray(), corners];
    }})()""")
    np.testing.assert_allclose(high, attempt.bodies[index].shapes[0].size, atol=1e-6)
    np.testing.assert_allclose(low, np.negative(high), atol=1e-6)
    assert corners == 0


def test_a_body_is_hidden_by_its_switch_and_named_by_a_click(wide, attempt):
    index = [body.name for body in attempt.bodies].index("light_sphere_00")
    path = node_path(index, attempt.bodies[index])
    wide.evaluate("pilegrasp.seek(5)")
    wide.evaluate("document.querySelectorAll('details.tree, details.tree details').forEach((one) => (one.open = true))")
    shown = f"meshcat.node(pilegrasp.viewer, '{path}').visible"
    box = "document.querySelector('[aria-label=\"show light sphere 00\"]')"
    wide.evaluate(f"{box}.click()")
    assert wide.evaluate(shown) is False
    wide.evaluate(f"{box}.click()")
    assert wide.evaluate(shown) is True
    [[x, y]] = projected(wide, [attempt.body_position[150, index]])
    width, height = wide.evaluate(f"{CAMERAS}.places()[0].slice(2)")
    pane = wide.evaluate("document.querySelector('.pane').getBoundingClientRect().toJSON()")
    place = {"x": pane["left"] + 0.5 * (1 + x) * width, "y": pane["top"] + 0.5 * (1 - y) * height}
    for kind in ("mousePressed", "mouseReleased"):
        wide.call("Input.dispatchMouseEvent", type=kind, **place, button="left", clickCount=1)
    card = wide.evaluate("document.querySelector('.card').innerText").split("\n")
    assert card[0].startswith("light sphere")
    assert card[1].startswith("at ")
    assert card[2].startswith("speed ")
    assert card[3].startswith("touches ")
    assert card[4].startswith(("in the hand", "never in the hand"))
    wide.evaluate("document.querySelector('.tree button[aria-pressed=true]').click()")
    assert wide.evaluate("document.querySelector('.card').hidden") is True


def test_force_chains_lead_from_the_hand_over_strong_contacts(wide, attempt):
    wide.evaluate(ONLY.replace("NAMES", "['chains']"))
    count = """(() => {
      const [mesh] = pilegrasp.viewer.scene_tree.find(["Overlays", "chains"]).object.children[0].children;
      const matrix = new meshcat.THREE.Matrix4();
      return Array.from({ length: mesh.count }, (_, k) => {
        mesh.getMatrixAt(k, matrix);
        return 2 * Math.hypot(...matrix.elements.slice(0, 3));
      });
    })()"""
    wide.evaluate("pilegrasp.seek(5)")
    # The hand presses one ball with 4 N; the only contact of two balls is not above the mean.
    assert wide.evaluate(count) == pytest.approx([0.004])
    wide.evaluate("pilegrasp.seek(1)")
    assert wide.evaluate(count) == []
    wide.evaluate(ONLY.replace("NAMES", "['wrench', 'paths', 'separated']"))


def test_the_ruler_measures_between_two_clicks(wide):
    wide.evaluate(ONLY.replace("NAMES", "['ruler']"))
    ruler = "pilegrasp.panels[0].overlays.ruler"
    wide.evaluate(f"{ruler}.measure(new meshcat.THREE.Vector3(0.5, 0, 0))")
    words = wide.evaluate(f"{ruler}.measure(new meshcat.THREE.Vector3(0.8, 0.4, 0))")
    assert words == "ruler: 500 mm (300, 400, 0)"
    wide.evaluate(ONLY.replace("NAMES", "['wrench', 'paths', 'separated']"))


def test_two_scenes_are_seen_from_one_side(browser, attempt, tmp_path):
    write_html(attempt, tmp_path / "pair.html", synthetic(success=False, objects=7))
    browser.open(tmp_path / "pair.html", 1400, 900)
    browser.evaluate("pilegrasp.ready.then(() => pilegrasp.pause())")
    places = "pilegrasp.panels.map(({ viewer }) => viewer.camera.position.toArray())"
    one, two = browser.evaluate(places)
    np.testing.assert_allclose(one, two, atol=1e-6)
    pane = browser.evaluate("document.querySelectorAll('.pane')[1].getBoundingClientRect().toJSON()")
    x, y = pane["left"] + 60, pane["top"] + 60
    for kind, dx in (("mousePressed", 0), ("mouseMoved", 40), ("mouseMoved", 80), ("mouseReleased", 80)):
        browser.call("Input.dispatchMouseEvent", type=kind, x=x + dx, y=y, button="left", buttons=1, clickCount=1)
    turned = browser.evaluate(places)
    np.testing.assert_allclose(turned[0], turned[1], atol=1e-6)
    assert np.linalg.norm(np.subtract(turned[0], one)) > 0.05


@pytest.fixture(scope="module")
def real():
    return run("spheres_wall", seed=0, record=True).recording


def test_everyone_can_tell_hand_table_wall_and_held_objects_apart(browser, real, tmp_path):
    write_html(real, tmp_path / "real.html")
    browser.open(tmp_path / "real.html", 1400, 900)
    browser.evaluate("pilegrasp.ready.then(() => pilegrasp.pause())")
    browser.evaluate(ONLY.replace("NAMES", "['separated']"))
    held = {one.object: one for one in carried_in(real)}
    paths = [node_path(k, body) for k, body in enumerate(real.bodies) if body.name in held]
    rows = {row["name"]: row for row in real.meta["outcomes"]}
    moments = [rows["push"]["end"], rows["grasp"]["end"], *(0.5 * (one.start + one.end) for one in held.values())]
    kinds = set()
    for moment in moments:
        browser.evaluate(f"pilegrasp.seek({moment})")
        for near in (False, True):
            colors = seen_colours(browser, near, paths)
            kinds |= {kind.split()[0] for kind in colors}
            for sight, (least, one, two) in smallest_differences(colors).items():
                assert least >= LEAST_DIFFERENCE, (moment, near, sight, one, two)
    named = browser.evaluate("pilegrasp.panels[0].data.attempts.some(({ separated }) => separated)")
    assert {"hand", "table", "wall", "held"} | ({"outline"} if named else set()) <= kinds
