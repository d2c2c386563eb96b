"use strict";
// The overlays of a scene: each has `show(on)` and `update(moment)`; overlays without a recorded signal are absent.
const makeOverlays = (() => {
  const LARGEST = 0.3; // largest length of an arrow [m]
  const WINDOW = 0.25; // half the time whose motion an arrow shows [s]

  const steps = (path) => path.split("/").filter(Boolean);

  // Arrows of one colour, drawn over everything; their number changes with the moment, up to a capacity.
  function arrows(parent, capacity, color, radius) {
    const { InstancedMesh, CylinderGeometry, ConeGeometry, MeshBasicMaterial, Object3D, Vector3 } = MeshCat.THREE;
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
        const length = Math.min(vector.length(), LARGEST);
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

  // A group of the scene tree that is only drawn while the overlay is on.
  function layer(viewer, name) {
    const group = new MeshCat.THREE.Group();
    viewer.scene_tree.find(["Overlays", name]).object.add(group);
    return group;
  }

  function node(viewer, name) {
    const { object } = viewer.scene_tree.find(["Overlays", name]);
    return { show: (on) => (object.visible = on), update() {} };
  }

  // The block is described in overlays.py.
  function readContacts(bytes) {
    const numbers = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const frames = numbers.getUint32(0, true);
    const start = [0];
    for (let k = 0; k < frames; k++) start.push(start[k] + numbers.getUint16(4 + 2 * k, true));
    const total = start[frames];
    const points = 4 + 2 * frames;
    const vector = (at, k, unit) =>
      new MeshCat.THREE.Vector3(...[0, 1, 2].map((axis) => unit * numbers.getInt16(at + 6 * k + 2 * axis, true)));
    return {
      range: (frame) => [start[frame], start[frame + 1]],
      point: (k) => vector(points, k, 1e-4),
      force: (k) => vector(points + 6 * total, k, 1e-2),
      kind: (k) => bytes[points + 12 * total + k],
      most: Math.max(0, ...start.slice(1).map((end, k) => end - start[k])),
    };
  }

  function contacts(viewer, data, bytes) {
    if (bytes.length < 5) return null;
    const found = readContacts(bytes);
    const group = layer(viewer, "contacts");
    const sets = [0xff7f0e, 0x6b7480, 0x1a2a6c].map((color) => arrows(group, 2 * found.most + 1, color, 0.0028));
    return {
      show: (on) => (group.visible = on),
      update(moment) {
        for (const set of sets) set.clear();
        const [first, end] = found.range(lastFrame(data.frameTime, moment));
        for (let k = first; k < end; k++) {
          const kind = found.kind(k);
          const force = found.force(k).multiplyScalar(0.01);
          sets[kind].add(found.point(k), force);
          if (kind === 2) sets[kind].add(found.point(k), force.negate());
        }
        for (const set of sets) set.finish();
      },
    };
  }

  // The position of each object over time: the keys of its animation, or its position if it never moves.
  function motions(viewer, paths) {
    const tracks = new Map();
    for (const action of viewer.animator.actions) {
      const track = action.getClip().tracks.find(({ name }) => name === ".position");
      if (track) tracks.set(action.getRoot(), track);
    }
    return paths.map((path) => {
      const { object } = viewer.scene_tree.find(steps(path));
      const track = tracks.get(object);
      return { path, object, times: track?.times ?? [0], values: track?.values ?? object.position.toArray(), moves: Boolean(track) };
    });
  }

  const key = ({ values }, k) => new MeshCat.THREE.Vector3(values[3 * k], values[3 * k + 1], values[3 * k + 2]);

  function positionAt(motion, elapsed) {
    const k = lastFrame(motion.times, elapsed);
    if (k + 1 >= motion.times.length) return key(motion, k);
    const share = (elapsed - motion.times[k]) / (motion.times[k + 1] - motion.times[k]);
    return key(motion, k).lerp(key(motion, k + 1), Math.max(0, Math.min(1, share)));
  }

  const paint = (object) => {
    let color = null;
    object.traverse((child) => (color ??= child.material?.color ?? null));
    return color ?? new MeshCat.THREE.Color(0x888888);
  };

  function trails(viewer, data, moving) {
    const { Line, BufferGeometry, BufferAttribute, LineBasicMaterial } = MeshCat.THREE;
    const group = layer(viewer, "trails");
    const lines = moving.filter(({ moves }) => moves).map((motion) => {
      const points = new BufferAttribute(new Float32Array(motion.values.length + 3), 3);
      points.array.set(motion.values);
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", points);
      const line = new Line(geometry, new LineBasicMaterial({ color: paint(motion.object).clone().multiplyScalar(0.75), depthTest: false, transparent: true }));
      line.frustumCulled = false;
      line.renderOrder = 9;
      group.add(line);
      return { motion, points, geometry };
    });
    if (!lines.length) return null;
    return {
      show: (on) => (group.visible = on),
      update(moment) {
        const elapsed = moment - data.start;
        for (const { motion, points, geometry } of lines) {
          const k = lastFrame(motion.times, elapsed);
          points.array.set(motion.values);
          positionAt(motion, elapsed).toArray(points.array, 3 * (k + 1));
          points.needsUpdate = true;
          geometry.setDrawRange(0, k + 2);
        }
      },
    };
  }

  function toolAt(data, moment) {
    const k = Math.min(lastFrame(data.frameTime, moment), data.frameTime.length - 2);
    const [a, b] = [data.tool[Math.max(k, 0)], data.tool[k + 1]];
    const share = (moment - data.frameTime[k]) / (data.frameTime[k + 1] - data.frameTime[k]);
    return new MeshCat.THREE.Vector3(...a).lerp(new MeshCat.THREE.Vector3(...b), Math.max(0, Math.min(1, share)));
  }

  // Left and right side of the measured funnel at a distance ahead of the hand's leading edge; beyond its end null.
  function sidesAt({ funnel, half, length }, x) {
    if (x < 0) return x > -length ? [-half, half] : null;
    const k = funnel.findIndex(([distance]) => distance >= x);
    if (k < 0) return null;
    if (k === 0) return funnel[0].slice(1);
    const share = (x - funnel[k - 1][0]) / (funnel[k][0] - funnel[k - 1][0]);
    return [1, 2].map((side) => funnel[k - 1][side] + share * (funnel[k][side] - funnel[k - 1][side]));
  }

  // The funnel between the two stream lines that end at the hand's leading edge.
  function funnelOutline({ funnel }) {
    const { Vector3, LineLoop, BufferGeometry, LineBasicMaterial, Mesh, MeshBasicMaterial, ShapeGeometry, Shape, Vector2, Group } = MeshCat.THREE;
    const group = new Group();
    group.name = "funnel";
    if (funnel.length < 2) return group;
    const outline = [...funnel.map(([x, right]) => [x, right]), ...funnel.toReversed().map(([x, , left]) => [x, left])];
    const look = { color: 0xd62728, depthTest: false, transparent: true };
    const area = new Mesh(new ShapeGeometry(new Shape(outline.map((p) => new Vector2(...p)))), new MeshBasicMaterial({ ...look, opacity: 0.12, side: 2 }));
    const edge = new LineLoop(new BufferGeometry().setFromPoints(outline.map(([x, y]) => new Vector3(x, y, 0))), new LineBasicMaterial(look));
    area.renderOrder = edge.renderOrder = 8;
    group.add(area, edge);
    return group;
  }

  // Figure 2 of the paper: relative motion in the funnel before the hand, absolute motion outside.
  function field(viewer, data, moving) {
    const { push } = data;
    if (!push || !data.tool || data.frameTime.length < 2 || !moving.length) return null;
    const group = layer(viewer, "field");
    const inside = arrows(group, moving.length, 0xd62728, 0.003);
    const outside = arrows(group, moving.length, 0x1565c0, 0.003);
    const funnel = funnelOutline(push);
    group.add(funnel);
    const along = new MeshCat.THREE.Vector3(...data.forward, 0);
    const left = new MeshCat.THREE.Vector3(-along.y, along.x, 0);
    let on = false;
    return {
      show: (visible) => (on = visible),
      update(moment) {
        group.visible = on && moment >= push.start && moment <= push.end;
        if (!group.visible) return;
        const mouth = toolAt(data, moment).addScaledVector(along, push.edge[0]).addScaledVector(left, push.edge[1]);
        funnel.position.set(mouth.x, mouth.y, 0.002);
        funnel.rotation.z = Math.atan2(along.y, along.x);
        const [before, after] = [Math.max(push.start, moment - WINDOW), Math.min(push.end, moment + WINDOW)];
        const scale = (2 * WINDOW) / Math.max(after - before, 1e-3);
        const hand = toolAt(data, after).sub(toolAt(data, before)).setZ(0);
        inside.clear();
        outside.clear();
        for (const motion of moving) {
          const place = positionAt(motion, moment - data.start);
          const step = positionAt(motion, after - data.start).sub(positionAt(motion, before - data.start)).setZ(0);
          const offset = place.clone().sub(mouth);
          const sides = sidesAt(push, offset.dot(along));
          const within = sides !== null && offset.dot(left) > sides[0] && offset.dot(left) < sides[1];
          if (within) step.sub(hand);
          if (step.length() * scale > 0.003) (within ? inside : outside).add(place, step.multiplyScalar(scale));
        }
        inside.finish();
        outside.finish();
      },
    };
  }

  // A second, larger skin of which only the inside is drawn makes an outline.
  function separated(viewer, data) {
    if (!data.separated) return null;
    const { MeshBasicMaterial } = MeshCat.THREE;
    const { object } = viewer.scene_tree.find([...steps(data.separated.path), "<object>"]);
    const look = new MeshBasicMaterial({ color: 0xff00c8, side: 1 });
    const skins = [];
    object.traverse((child) => child.isMesh && skins.push(child));
    const outlines = skins.map((skin) => {
      const outline = skin.clone();
      outline.material = look;
      outline.castShadow = false;
      outline.scale.multiplyScalar(1.13);
      outline.updateMatrix();
      skin.parent.add(outline);
      return outline;
    });
    let on = false;
    return {
      show: (visible) => (on = visible),
      update(moment) {
        for (const outline of outlines) outline.visible = on && moment >= data.separated.time;
      },
    };
  }

  return (viewer, data, contactBytes) => {
    const recorded = Object.keys(viewer.scene_tree.find(["Overlays"]).children);
    const moving = motions(viewer, data.objects);
    const all = {
      wrench: recorded.includes("wrench") ? node(viewer, "wrench") : null,
      contacts: contacts(viewer, data, contactBytes),
      paths: recorded.includes("paths") ? node(viewer, "paths") : null,
      trails: trails(viewer, data, moving),
      field: field(viewer, data, moving),
      separated: separated(viewer, data),
    };
    return Object.fromEntries(Object.entries(all).filter(([, overlay]) => overlay));
  };
})();
