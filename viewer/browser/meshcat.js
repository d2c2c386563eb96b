// @ts-check
"use strict";
// All that we use of meshcat's viewer beyond its commands. These names are private: a release may change them, and a test
// compares them with the package that is installed.
const meshcat = (() => {
  const { THREE } = MeshCat;

  // A viewer in a pane, without its menu: the page has a tree of its own.
  function open(pane, renderer) {
    const viewer = new MeshCat.Viewer(pane, true, renderer);
    viewer.gui.domElement.remove();
    return viewer;
  }

  const steps = (path) => (typeof path === "string" ? path.split("/").filter(Boolean) : path);

  // The three.js object at a path of the scene tree, which is made where it is missing.
  const node = (viewer, path) => viewer.scene_tree.find(steps(path)).object;
  const names = (viewer, path) => Object.keys(viewer.scene_tree.find(steps(path)).children);
  const run = (viewer, message) => viewer.handle_command_bytearray(message);
  const redraw = (viewer) => viewer.set_dirty();

  function resize(viewer, width, height) {
    viewer.camera.aspect = width / height;
    viewer.renderer.setSize(width, height);
    viewer.set_dirty();
  }

  // meshcat sizes its canvas by the window; here `resized` decides, now and whenever the window changes.
  function onResize(viewer, resized) {
    viewer.set_3d_pane_size = resized;
  }

  // Draws by a function of ours instead of meshcat's.
  function onRender(viewer, draw) {
    viewer.render = () => {
      viewer.controls.update();
      draw();
      viewer.needs_render = false;
    };
  }

  // The animation's clock is ours: the actions are started once and only ever sought.
  const start = (viewer) => viewer.animator.actions.forEach((action) => action.play());

  function seek(viewer, elapsed) {
    viewer.animator.seek(elapsed);
    viewer.animator.time = elapsed;
  }

  // The tracks of a property: pairs of a scene node and its keys.
  function tracks(viewer, property) {
    const found = new Map();
    for (const action of viewer.animator.actions) {
      const track = action.getClip().tracks.find(({ name }) => name === `.${property}`);
      if (track) found.set(action.getRoot(), track);
    }
    return found;
  }

  return { THREE, open, node, names, run, redraw, resize, onResize, onRender, start, seek, tracks };
})();
