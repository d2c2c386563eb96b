// @ts-check
// The overlays of a scene: each has `show(on)` and `update(moment)`; overlays without a recorded signal are absent.
const makeOverlays = (() => {
  const WINDOW = 0.25; // half the time whose motion an arrow shows [s]
  const METERS_PER_NEWTON = 0.02; // length of the arrow of a contact force

  function node(viewer, name) {
    const object = meshcat.node(viewer, ["Overlays", name]);
    return { show: (on) => (object.visible = on), update() {} };
  }

  // The path of the tool in the present attempt.
  function paths(viewer, data) {
    const all = meshcat.node(viewer, ["Overlays", "paths"]);
    const parts = meshcat.names(viewer, ["Overlays", "paths"]).map((name) => [Number(name), meshcat.node(viewer, ["Overlays", "paths", name])]);
    return {
      show: (on) => (all.visible = on),
      update(moment) {
        const present = data.attempts.indexOf(attemptAt(data.attempts, moment));
        for (const [number, part] of parts) part.visible = number === present;
      },
    };
  }

  function contacts(viewer, data, found) {
    if (!found) return null;
    const group = drawing.layer(viewer, "contacts");
    const sets = [0xff7f0e, 0xaab4c0, 0x4a7dff].map((color) => drawing.arrows(group, 2 * found.most + 1, color, 0.0022));
    return {
      show: (on) => (group.visible = on),
      update(moment) {
        for (const set of sets) set.clear();
        const [first, end] = found.range(lastFrame(data.frameTime, moment));
        for (let k = first; k < end; k++) {
          const kind = found.kind(k);
          const force = found.force(k).multiplyScalar(METERS_PER_NEWTON);
          sets[kind].add(found.point(k), force);
          if (kind === 2) sets[kind].add(found.point(k), force.negate());
        }
        for (const set of sets) set.finish();
      },
    };
  }

  const paint = (object) => {
    let color = null;
    object.traverse((child) => (color ??= child.material?.color ?? null));
    return color ?? new meshcat.THREE.Color(0x888888);
  };

  function trails(viewer, data, moving) {
    const { Line, BufferGeometry, BufferAttribute, LineBasicMaterial } = meshcat.THREE;
    const group = drawing.layer(viewer, "trails");
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
          drawing.positionAt(motion, elapsed).toArray(points.array, 3 * (k + 1));
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
    return new meshcat.THREE.Vector3(...a).lerp(new meshcat.THREE.Vector3(...b), Math.max(0, Math.min(1, share)));
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
    const { Vector3, LineLoop, BufferGeometry, LineBasicMaterial, Mesh, MeshBasicMaterial, ShapeGeometry, Shape, Vector2, Group } = meshcat.THREE;
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
    const pushes = data.attempts.filter(({ push }) => push);
    if (!pushes.length || !data.tool || data.frameTime.length < 2 || !moving.length) return null;
    const { Vector3 } = meshcat.THREE;
    const group = drawing.layer(viewer, "field");
    const inside = drawing.arrows(group, moving.length, 0xd62728, 0.003);
    const outside = drawing.arrows(group, moving.length, 0x3d9bff, 0.003);
    const funnels = pushes.map((attempt) => [attempt, funnelOutline(attempt.push)]);
    for (const [, funnel] of funnels) group.add(funnel);
    let on = false;
    return {
      show: (visible) => (on = visible),
      update(moment) {
        const { push, forward } = attemptAt(data.attempts, moment);
        group.visible = on && Boolean(push) && moment >= push.start && moment <= push.end;
        if (!group.visible) return;
        const along = new Vector3(...forward, 0);
        const left = new Vector3(-along.y, along.x, 0);
        const mouth = toolAt(data, moment).addScaledVector(along, push.edge[0]).addScaledVector(left, push.edge[1]);
        for (const [attempt, funnel] of funnels) {
          funnel.visible = attempt.push === push;
          funnel.position.set(mouth.x, mouth.y, 0.002);
          funnel.rotation.z = Math.atan2(along.y, along.x);
        }
        const [before, after] = [Math.max(push.start, moment - WINDOW), Math.min(push.end, moment + WINDOW)];
        const scale = (2 * WINDOW) / Math.max(after - before, 1e-3);
        const hand = toolAt(data, after).sub(toolAt(data, before)).setZ(0);
        inside.clear();
        outside.clear();
        for (const motion of moving) {
          const at = (time) => drawing.positionAt(motion, time - data.start);
          const place = at(moment);
          const step = at(after).sub(at(before)).setZ(0);
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

  // Black is as far from every colour of the scene as it can be, for the colour-blind, too.
  function separated(viewer, data) {
    const found = data.attempts.filter((attempt) => attempt.separated);
    if (!found.length) return null;
    const outlines = new Map(found.map((attempt) => [attempt, outline(viewer, attempt.separated.path, 0x000000, 1.14)]));
    let on = false;
    return {
      show: (visible) => (on = visible),
      update(moment) {
        const present = attemptAt(data.attempts, moment);
        for (const [attempt, show] of outlines) show(on && attempt === present && moment >= attempt.separated.time);
      },
    };
  }

  return (viewer, data, found) => {
    const recorded = meshcat.names(viewer, ["Overlays"]);
    const moving = drawing.motions(viewer, data.objects);
    const all = {
      wrench: recorded.includes("wrench") ? node(viewer, "wrench") : null,
      contacts: contacts(viewer, data, found),
      paths: recorded.includes("paths") ? paths(viewer, data) : null,
      trails: trails(viewer, data, moving),
      field: field(viewer, data, moving),
      separated: separated(viewer, data),
      chains: makeChains(viewer, data, found),
      ...makeRulers(viewer, data),
    };
    return Object.fromEntries(Object.entries(all).filter(([, overlay]) => overlay));
  };
})();
