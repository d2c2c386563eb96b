// @ts-check
// Shared by every page with a scene: meshcat's viewer in a pane, its commands, its camera and its light.
const sceneView = (() => {
  const { THREE } = meshcat;

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
    for (const message of messages(bytes)) meshcat.run(viewer, message);
  }

  // The scene is z-up and the viewer's world y-up.
  /** @param {number[]} place */
  const world = ([x, y, z]) => new THREE.Vector3(x, z, -y);

  // The camera is at the nearest point of the line of sight that shows every corner of the box, and a little nearer,
  // because the corners are empty.
  function frame(viewer, low, high, direction, aspect) {
    const target = world(low).add(world(high)).multiplyScalar(0.5);
    const toward = world(direction).normalize();
    const right = new THREE.Vector3(0, 1, 0).cross(toward).normalize();
    const up = toward.clone().cross(right);
    const height = Math.tan((viewer.camera.fov * Math.PI) / 360);
    const width = height * aspect;
    let distance = 0;
    for (let corner = 0; corner < 8; corner++) {
      const point = world([0, 1, 2].map((axis) => (corner & (1 << axis) ? high : low)[axis])).sub(target);
      const across = Math.abs(point.dot(right)) / width;
      const along = Math.abs(point.dot(up)) / height;
      distance = Math.max(distance, point.dot(toward) + Math.max(across, along));
    }
    viewer.camera.position.copy(target).addScaledVector(toward, 0.94 * distance);
    viewer.controls.target.copy(target);
    viewer.controls.update();
    meshcat.redraw(viewer);
  }

  // The light covers the action and no more, so that the edges of shadows are fine.
  function light(viewer, { low, high, direction }) {
    const spot = meshcat.node(viewer, ["Lights", "SpotLight", "<object>"]);
    const middle = [0, 1, 2].map((axis) => (low[axis] + high[axis]) / 2);
    spot.position.set(middle[0] - 0.5, middle[1] + (direction[1] > 0 ? 0.9 : -0.9), middle[2] + 1.8);
    spot.target.position.copy(world(middle));
    spot.target.updateMatrixWorld();
    spot.shadow.normalBias = 0.004;
    spot.shadow.mapSize.set(1024, 1024);
    const radius = Math.hypot(...[0, 1, 2].map((axis) => (high[axis] - low[axis]) / 2)) + 0.3;
    spot.angle = Math.max(0.25, Math.min(0.6, Math.atan(radius / 2.07)));
  }

  // Whether the browser draws without a graphics card; each pixel then costs time.
  function slow() {
    const context = document.createElement("canvas").getContext("webgl");
    const names = context?.getExtension("WEBGL_debug_renderer_info");
    const name = names ? context.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
    context?.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
  }

  // One sample for each pixel and simpler shadows: less than half of the work.
  function plainRenderer(pane) {
    const renderer = new THREE.WebGLRenderer({ antialias: false, alpha: true });
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = THREE.PCFShadowMap;
    pane.appendChild(renderer.domElement);
    return renderer;
  }

  // The viewer fills its pane, and calls `resized` after each new size.
  function open(pane, resized) {
    const viewer = meshcat.open(pane, slow() ? plainRenderer(pane) : undefined);
    meshcat.onResize(viewer, () => {
      meshcat.resize(viewer, Math.max(pane.clientWidth, 1), Math.max(pane.clientHeight, 1));
      resized();
    });
    return viewer;
  }

  return { runCommands, frame, light, open, world };
})();
