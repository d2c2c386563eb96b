// @ts-check
// The cameras of a scene: one that the reader moves, and one that shows the hand from near beside it. What hides the
// fingers fades.
const makeCameras = (() => {
  const { THREE } = meshcat;
  const NEAR = 0.62; // distance of the near camera from the hand [m]
  const FADED = 0.14; // opacity of what hides the fingers
  const WIDE = 620; // width of a pane from which on the two pictures stand side by side [px]
  const SHARE = 0.42; // share of the near picture

  // Meshes that may hide the fingers, each with a material of its own.
  function blockers(viewer, data) {
    const found = [];
    const fingers = new Set(data.bodies.filter(({ finger }) => finger).map(({ path }) => path));
    for (const { path, role } of data.bodies) {
      if (role === "object" || fingers.has(path)) continue;
      meshcat.node(viewer, `${path}/<object>`).traverse((mesh) => {
        if (!mesh.isMesh) return;
        mesh.material = mesh.material.clone();
        const { opacity, transparent, depthWrite } = mesh.material;
        const table = role === "support" && mesh.geometry.type === "PlaneGeometry";
        found.push({ mesh, role, table, usual: { opacity, transparent, depthWrite } });
      });
    }
    return found;
  }

  return (viewer, pane, data, changed) => {
    const near = new THREE.PerspectiveCamera(35, 1, 0.01, 20);
    const ray = new THREE.Raycaster();
    const hiding = blockers(viewer, data);
    let [mode, moved, closeup, alone] = ["whole", false, true, ""];
    let hand = null;
    let forward = [1, 0];

    const vector = ([x, y, z]) => sceneView.world([x, y, z]);
    const ahead = () => vector([forward[0], forward[1], 0]);

    // Left, bottom, width and height of the two pictures.
    function places() {
      const [width, height] = [Math.max(pane.clientWidth, 1), Math.max(pane.clientHeight, 1)];
      if (alone === "near" && hand) return [null, [0, 0, width, height]];
      if (!closeup || !hand || alone) return [[0, 0, width, height], null];
      if (width >= WIDE) {
        const left = Math.round((1 - SHARE) * width);
        return [[0, 0, left, height], [left, 0, width - left, height]];
      }
      const [w, h] = [Math.round(0.44 * width), Math.round(0.5 * height)];
      // The near picture is in the corner from which the push leads away, so that it does not lie on the hand.
      const left = data.view.direction[1] < 0 ? 0 : width - w;
      return [[0, 0, width, height], [left, height - h, w, h]];
    }

    const aspect = () => {
      const [far, beside] = places();
      const [, , width, height] = far ?? beside;
      return width / height;
    };

    // Shows what the mode asks for; `whole` holds the arm's base, too.
    function frame() {
      const { view } = data;
      moved = false;
      if (mode === "action") return sceneView.frame(viewer, view.low, view.high, view.direction, aspect());
      if (mode === "whole" || !hand) return sceneView.frame(viewer, view.outer_low, view.outer_high, view.direction, aspect());
      if (mode === "above") return sceneView.frame(viewer, view.low, view.high, [0.03 * forward[1], -0.03 * forward[0], 1], aspect());
      const target = vector(hand).add(new THREE.Vector3(0, 0.03, 0));
      // From below, the table is glass.
      const offset = mode === "follow" ? vector(view.direction).normalize().multiplyScalar(0.85) : ahead().multiplyScalar(0.22).setY(-0.5);
      viewer.controls.target.copy(target);
      viewer.camera.position.copy(target).add(offset);
      return viewer.controls.update();
    }

    function choose(name) {
      mode = name;
      frame();
      meshcat.redraw(viewer);
    }

    // The place of the hand at the moment that the scene shows; the following cameras move with it.
    function follow(place, direction) {
      if (place && hand && ["follow", "under"].includes(mode)) {
        const step = vector(place).sub(vector(hand));
        viewer.camera.position.add(step);
        viewer.controls.target.add(step);
      }
      [hand, forward] = [place, direction];
    }

    // What lies between a camera and the fingers.
    function fade(camera, all) {
      if (!hand) return [];
      const points = [[0, 0, 0.015], [0.03 * forward[0], 0.03 * forward[1], 0.03], [0, 0, 0.06]].map((step) => vector(hand.map((value, axis) => value + step[axis])));
      const faded = [];
      for (const one of hiding) {
        if (!all && one.role !== "support") continue;
        if (one.table && camera.position.y > 0) continue;
        const hides = points.some((point) => {
          const direction = point.clone().sub(camera.position);
          const distance = direction.length();
          ray.set(camera.position, direction.normalize());
          ray.far = distance - 0.012;
          return ray.intersectObject(one.mesh, false).length > 0;
        });
        if (hides) {
          Object.assign(one.mesh.material, { opacity: Math.min(FADED, one.usual.opacity), transparent: true, depthWrite: false });
          faded.push(one);
        }
      }
      return faded;
    }

    /** @param {number[]} place */
    function draw(camera, place, all) {
      const [left, bottom, width, height] = place;
      const { renderer } = viewer;
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      camera.updateMatrixWorld();
      renderer.setViewport(left, bottom, width, height);
      renderer.setScissor(left, bottom, width, height);
      const faded = fade(camera, all);
      renderer.render(viewer.scene, camera);
      for (const { mesh, usual } of faded) Object.assign(mesh.material, usual);
    }

    // The near camera looks along with the other one, never from below.
    function aimNear() {
      const toward = viewer.camera.position.clone().sub(viewer.controls.target).normalize();
      toward.y = Math.max(toward.y, 0.2);
      const target = vector(hand).add(new THREE.Vector3(0, 0.045, 0));
      near.position.copy(target).addScaledVector(toward.normalize(), NEAR);
      near.lookAt(target);
    }

    function render() {
      const { renderer } = viewer;
      const [far, beside] = places();
      renderer.setScissorTest(true);
      renderer.shadowMap.autoUpdate = true;
      viewer.scene.updateMatrixWorld();
      if (far) draw(viewer.camera, far, mode === "follow" || mode === "under");
      if (beside) {
        // The shadows are those of the first picture.
        renderer.shadowMap.autoUpdate = !far;
        aimNear();
        draw(near, beside, true);
      }
      renderer.setScissorTest(false);
      changed(beside);
    }

    viewer.controls.addEventListener("start", () => (moved = true));
    return {
      near,
      render,
      frame,
      choose,
      follow,
      places,
      mode: () => mode,
      moved: () => moved,
      showCloseup: (on) => (closeup = on),
      // One picture instead of two: "near", or "far".
      showOnly: (name) => (alone = name),
    };
  };
})();
