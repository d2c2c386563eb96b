// @ts-check
// What several overlays draw with: arrows, bars, layers of the scene tree, contacts, and the motion of objects.
const drawing = (() => {
  const LARGEST = 0.3; // largest length of an arrow [m]

  // Arrows of one colour, drawn over everything; their number changes with the moment, up to a capacity.
  function arrows(parent, capacity, color, radius, largest = LARGEST) {
    const { InstancedMesh, CylinderGeometry, ConeGeometry, MeshBasicMaterial, Object3D, Vector3 } = meshcat.THREE;
    const look = new MeshBasicMaterial({ color, depthTest: false, transparent: true, opacity: 0.9 });
    const shaft = new InstancedMesh(new CylinderGeometry(1, 1, 1, 8).translate(0, 0.5, 0), look, capacity);
    const head = new InstancedMesh(new ConeGeometry(1, 1, 12).translate(0, 0.5, 0), look, capacity);
    const up = new Vector3(0, 1, 0);
    const pose = new Object3D();
    for (const mesh of [shaft, head]) {
      mesh.count = 0;
      mesh.frustumCulled = false;
      mesh.renderOrder = 11;
      parent.add(mesh);
    }
    let used = 0;
    return {
      clear: () => (used = 0),
      add(origin, vector) {
        const length = Math.min(vector.length(), largest);
        if (used >= capacity || !(length > 1e-4)) return;
        const direction = vector.clone().normalize();
        const tip = Math.min(4 * radius, 0.6 * length);
        pose.position.copy(origin);
        pose.quaternion.setFromUnitVectors(up, direction);
        pose.scale.set(radius, length - tip, radius);
        pose.updateMatrix();
        shaft.setMatrixAt(used, pose.matrix);
        pose.position.addScaledVector(direction, length - tip);
        pose.scale.set(2.2 * radius, tip, 2.2 * radius);
        pose.updateMatrix();
        head.setMatrixAt(used, pose.matrix);
        used += 1;
      },
      finish() {
        for (const mesh of [shaft, head]) {
          mesh.count = used;
          mesh.instanceMatrix.needsUpdate = true;
        }
      },
    };
  }

  // Bars between two points, each with a radius of its own.
  function bars(parent, capacity, color) {
    const { InstancedMesh, CylinderGeometry, MeshBasicMaterial, Object3D, Vector3 } = meshcat.THREE;
    const look = new MeshBasicMaterial({ color, depthTest: false, transparent: true, opacity: 0.75 });
    const mesh = new InstancedMesh(new CylinderGeometry(1, 1, 1, 8).translate(0, 0.5, 0), look, capacity);
    mesh.count = 0;
    mesh.frustumCulled = false;
    mesh.renderOrder = 10;
    parent.add(mesh);
    const up = new Vector3(0, 1, 0);
    const pose = new Object3D();
    let used = 0;
    return {
      clear: () => (used = 0),
      add(from, to, radius) {
        const way = to.clone().sub(from);
        const length = way.length();
        if (used >= capacity || !(length > 1e-4)) return;
        pose.position.copy(from);
        pose.quaternion.setFromUnitVectors(up, way.normalize());
        pose.scale.set(radius, length, radius);
        pose.updateMatrix();
        mesh.setMatrixAt(used, pose.matrix);
        used += 1;
      },
      finish() {
        mesh.count = used;
        mesh.instanceMatrix.needsUpdate = true;
      },
    };
  }

  // A group of the scene tree that is only drawn while the overlay is on.
  function layer(viewer, name) {
    const group = new meshcat.THREE.Group();
    meshcat.node(viewer, ["Overlays", name]).add(group);
    return group;
  }

  // The block is described in scene/overlays.py.
  function readContacts(bytes) {
    if (bytes.length < 5) return null;
    const numbers = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const frames = numbers.getUint32(0, true);
    const start = [0];
    for (let k = 0; k < frames; k++) start.push(start[k] + numbers.getUint16(4 + 2 * k, true));
    const total = start[frames];
    const points = 4 + 2 * frames;
    const vector = (at, k, unit) =>
      new meshcat.THREE.Vector3(...[0, 1, 2].map((axis) => unit * numbers.getInt16(at + 6 * k + 2 * axis, true)));
    return {
      range: (frame) => [start[frame], start[frame + 1]],
      point: (k) => vector(points, k, 1e-4),
      force: (k) => vector(points + 6 * total, k, 1e-2),
      bodies: (k) => [0, 2].map((offset) => numbers.getUint16(points + 12 * total + 4 * k + offset, true)),
      kind: (k) => bytes[points + 16 * total + k],
      most: Math.max(0, ...start.slice(1).map((end, k) => end - start[k])),
    };
  }

  // The position of each body over time: the keys of its animation, or its position if it never moves.
  function motions(viewer, paths) {
    const found = meshcat.tracks(viewer, "position");
    return paths.map((path) => {
      const object = meshcat.node(viewer, path);
      const track = found.get(object);
      return { path, object, times: track?.times ?? [0], values: track?.values ?? object.position.toArray(), moves: Boolean(track) };
    });
  }

  const key = ({ values }, k) => new meshcat.THREE.Vector3(values[3 * k], values[3 * k + 1], values[3 * k + 2]);

  function positionAt(motion, elapsed) {
    const k = lastFrame(motion.times, elapsed);
    if (k + 1 >= motion.times.length) return key(motion, k);
    const share = (elapsed - motion.times[k]) / (motion.times[k + 1] - motion.times[k]);
    return key(motion, k).lerp(key(motion, k + 1), Math.max(0, Math.min(1, share)));
  }

  return { arrows, bars, layer, readContacts, motions, positionAt };
})();

// Index of the last time that is not after a moment, at least 0; the times increase.
function lastFrame(times, moment) {
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= moment + 1e-6) low = middle;
    else high = middle - 1;
  }
  return low;
}

// The attempt that runs at a moment, of those that follow one another.
const attemptAt = (attempts, moment) => attempts[Math.max(0, attempts.findLastIndex(({ start }) => start <= moment + 1e-6))];

// A second, larger skin of which only the inside is drawn makes an outline; returns a function that shows it.
function outline(viewer, path, color, scale) {
  const look = new meshcat.THREE.MeshBasicMaterial({ color, side: 1 });
  const skins = [];
  meshcat.node(viewer, `${path}/<object>`).traverse((child) => child.isMesh && child.material.side !== 1 && skins.push(child));
  const edges = skins.map((skin) => {
    const edge = skin.clone();
    edge.material = look;
    edge.castShadow = false;
    edge.scale.multiplyScalar(scale);
    edge.updateMatrix();
    skin.parent.add(edge);
    return edge;
  });
  return (on) => edges.forEach((edge) => (edge.visible = on));
}
