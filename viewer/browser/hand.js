// @ts-check
// The look of a hand: a bent tube replaces the capsules of each soft finger, and the boxes of the palm are rounded.
const makeTubes = (() => {
  const SIDES = 14; // corners of a ring
  const PER_SEGMENT = 4; // rings of a segment
  const CAP = 3; // rings of a rounded end

  function tube(viewer, { color, segments }) {
    const { Vector3, CatmullRomCurve3, BufferGeometry, BufferAttribute, MeshPhongMaterial, Mesh } = meshcat.THREE;
    const nodes = segments.map(({ path }) => meshcat.node(viewer, path));
    const count = segments.length * PER_SEGMENT + 1;
    const rings = count + 2 * CAP;
    const positions = new BufferAttribute(new Float32Array(3 * rings * SIDES), 3);
    const normals = new BufferAttribute(new Float32Array(3 * rings * SIDES), 3);
    const indices = [];
    for (let ring = 0; ring + 1 < rings; ring++) {
      for (let side = 0; side < SIDES; side++) {
        const [a, b] = [ring * SIDES + side, ring * SIDES + ((side + 1) % SIDES)];
        indices.push(a, b, a + SIDES, b, b + SIDES, a + SIDES);
      }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", positions);
    geometry.setAttribute("normal", normals);
    geometry.setIndex(indices);
    const mesh = new Mesh(geometry, new MeshPhongMaterial({ color, shininess: 20, side: 2 }));
    mesh.castShadow = mesh.receiveShadow = true;
    mesh.frustumCulled = false;
    mesh.name = "tube";
    mesh.userData.paths = segments.map(({ path }) => path);
    nodes[0].parent.add(mesh);
    for (const { path } of segments) meshcat.node(viewer, `${path}/<object>`).visible = false;

    const place = (index, end) =>
      new Vector3(...segments[index].ends[end]).applyQuaternion(nodes[index].quaternion).add(nodes[index].position);

    // The axis runs through the bases, half-way between the segments' ends at each joint, and the tip.
    function axis() {
      const points = [place(0, 0)];
      for (let k = 0; k + 1 < segments.length; k++) points.push(place(k, 1).add(place(k + 1, 0)).multiplyScalar(0.5));
      points.push(place(segments.length - 1, 1));
      return new CatmullRomCurve3(points, false, "centripetal");
    }

    function radiusAt(t) {
      const at = t * segments.length - 0.5;
      const low = Math.max(0, Math.min(segments.length - 1, Math.floor(at)));
      const high = Math.min(segments.length - 1, low + 1);
      const share = Math.max(0, Math.min(1, at - low));
      return segments[low].radius * (1 - share) + segments[high].radius * share;
    }

    function update() {
      const curve = axis();
      // The frame moves along the axis without a twist, from a direction that turns with the base.
      const across = new Vector3(0, 0, 1).applyQuaternion(nodes[0].quaternion);
      if (Math.abs(across.dot(curve.getTangent(0))) > 0.9) across.set(0, 1, 0).applyQuaternion(nodes[0].quaternion);
      const sideways = new Vector3();
      const normal = new Vector3();
      let ring = 0;
      const put = (center, tangent, radius, lean) => {
        // `lean` is the angle of a cap's ring from the tube's side toward its end; the sign says which end.
        across.addScaledVector(tangent, -across.dot(tangent)).normalize();
        sideways.crossVectors(tangent, across);
        for (let side = 0; side < SIDES; side++) {
          const turn = (2 * Math.PI * side) / SIDES;
          normal.set(0, 0, 0).addScaledVector(across, Math.cos(turn)).addScaledVector(sideways, Math.sin(turn));
          normal.multiplyScalar(Math.cos(lean)).addScaledVector(tangent, Math.sin(lean));
          const index = ring * SIDES + side;
          normals.setXYZ(index, normal.x, normal.y, normal.z);
          positions.setXYZ(index, center.x + radius * normal.x, center.y + radius * normal.y, center.z + radius * normal.z);
        }
        ring += 1;
      };
      for (let k = CAP; k > 0; k--) put(curve.getPoint(0), curve.getTangent(0), radiusAt(0), (-Math.PI / 2) * (k / CAP));
      for (let k = 0; k < count; k++) {
        const t = k / (count - 1);
        put(curve.getPoint(t), curve.getTangent(t), radiusAt(t), 0);
      }
      for (let k = 1; k <= CAP; k++) put(curve.getPoint(1), curve.getTangent(1), radiusAt(1), (Math.PI / 2) * (k / CAP));
      positions.needsUpdate = normals.needsUpdate = true;
    }
    return update;
  }

  // Returns a function that bends the tubes to the present poses of the segments.
  return (viewer, fingers) => {
    const updates = fingers.map((finger) => tube(viewer, finger));
    const update = () => updates.forEach((bend) => bend());
    update();
    return update;
  };
})();

// A box with round edges, of which the flat part keeps its size; three.js r132 has none.
const roundBox = (() => {
  const PARTS = 12; // parts of an edge: a quarter of them for each rounding

  return (width, height, depth, share = 0.45) => {
    const { BoxGeometry, Vector3 } = meshcat.THREE;
    const half = [width / 2, height / 2, depth / 2];
    const radius = share * Math.min(...half) * 2;
    const geometry = new BoxGeometry(2, 2, 2, PARTS, PARTS, PARTS);
    const { position, normal } = geometry.attributes;
    const inner = new Vector3();
    const out = new Vector3();
    const spread = (t, size) => Math.sign(t) * (Math.abs(t) < 0.5 ? 2 * Math.abs(t) * (size - radius) : size - radius + radius * (2 * Math.abs(t) - 1));
    for (let k = 0; k < position.count; k++) {
      const point = [position.getX(k), position.getY(k), position.getZ(k)].map((t, axis) => spread(t, half[axis]));
      inner.set(...point.map((value, axis) => Math.max(radius - half[axis], Math.min(half[axis] - radius, value))));
      out.set(...point).sub(inner).normalize();
      position.setXYZ(k, inner.x + radius * out.x, inner.y + radius * out.y, inner.z + radius * out.z);
      normal.setXYZ(k, out.x, out.y, out.z);
    }
    return geometry;
  };
})();

// Rounds the boxes of the hand.
function roundPalm(viewer, bodies) {
  for (const { path, role } of bodies) {
    if (role !== "hand") continue;
    meshcat.node(viewer, `${path}/<object>`).traverse((mesh) => {
      if (mesh.geometry?.type !== "BoxGeometry") return;
      const { width, height, depth } = mesh.geometry.parameters;
      mesh.geometry = roundBox(width, height, depth);
    });
  }
}
