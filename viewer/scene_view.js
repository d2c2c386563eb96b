"use strict";
// Shared by every page with a scene: meshcat's viewer in a pane, its commands, its camera and its light.
const sceneView = (() => {
  // Each command follows its length (32 bits, little-endian).
  function* messages(bytes) {
    const numbers = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    for (let at = 0; at < bytes.length; ) {
      const length = numbers.getUint32(at, true);
      yield bytes.slice(at + 4, at + 4 + length);
      at += 4 + length;
    }
  }

  function runCommands(viewer, bytes) {
    for (const message of messages(bytes)) viewer.handle_command_bytearray(message);
  }

  // The scene is z-up and the viewer's world y-up.
  const world = ([x, y, z]) => new MeshCat.THREE.Vector3(x, z, -y);

  // The camera is at the nearest point of the line of sight that shows every corner of the action's box, and a
  // sixth nearer, because the corners are empty.
  function frame(viewer, { low, high, direction }) {
    const target = world(low).add(world(high)).multiplyScalar(0.5);
    const toward = world(direction).normalize();
    const right = new MeshCat.THREE.Vector3(0, 1, 0).cross(toward).normalize();
    const up = toward.clone().cross(right);
    const height = Math.tan((viewer.camera.fov * Math.PI) / 360);
    const width = height * viewer.camera.aspect;
    let distance = 0;
    for (let corner = 0; corner < 8; corner++) {
      const point = world([0, 1, 2].map((axis) => (corner & (1 << axis) ? high : low)[axis])).sub(target);
      const across = Math.abs(point.dot(right)) / width;
      const along = Math.abs(point.dot(up)) / height;
      distance = Math.max(distance, point.dot(toward) + Math.max(across, along));
    }
    viewer.camera.position.copy(target).addScaledVector(toward, 0.84 * distance);
    viewer.controls.target.copy(target);
    viewer.controls.update();
    viewer.set_dirty();
  }

  function light(viewer, { low, high, direction }) {
    const spot = viewer.scene_tree.find(["Lights", "SpotLight", "<object>"]).object;
    const middle = [0, 1, 2].map((axis) => (low[axis] + high[axis]) / 2);
    spot.position.set(middle[0] - 0.5, middle[1] + (direction[1] > 0 ? 0.9 : -0.9), middle[2] + 1.8);
    spot.target.position.copy(world(middle));
    spot.target.updateMatrixWorld();
    spot.shadow.normalBias = 0.004;
    if (viewer.renderer.shadowMap.type === MeshCat.THREE.BasicShadowMap) spot.shadow.mapSize.set(512, 512);
  }

  // Whether the browser draws without a graphics card; each pixel then costs time.
  function slow() {
    const context = document.createElement("canvas").getContext("webgl");
    const names = context?.getExtension("WEBGL_debug_renderer_info");
    const name = names ? context.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
    context?.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
  }

  // One sample for each pixel and hard shadows: a third of the work.
  function plainRenderer(pane) {
    const { WebGLRenderer, BasicShadowMap } = MeshCat.THREE;
    const renderer = new WebGLRenderer({ antialias: false, alpha: true });
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = BasicShadowMap;
    pane.appendChild(renderer.domElement);
    return renderer;
  }

  // meshcat takes the size of the window; here it fills its pane, and calls `resized` after each new size.
  function open(pane, resized) {
    const viewer = new MeshCat.Viewer(pane, true, slow() ? plainRenderer(pane) : undefined);
    const resize = viewer.set_3d_pane_size.bind(viewer);
    viewer.set_3d_pane_size = () => {
      resize(pane.clientWidth, pane.clientHeight);
      resized();
    };
    return viewer;
  }

  return { runCommands, frame, light, open };
})();
