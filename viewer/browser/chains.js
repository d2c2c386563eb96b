// @ts-check
// Force chains: the strong contacts that lead from the hand through the pile to a wall, by the rule of
// analysis/contact_network.py, as links whose width is the force.
const makeChains = (() => {
  const WIDTH = 0.001; // width of a link [m/N]
  const THINNEST = 0.001; // least width [m]

  // The contacts of one frame as [first, second, force, number]; `role` is that of a body.
  function chainOf(rows, role) {
    const between = rows.filter(([a, b]) => role(a) === "object" && role(b) === "object");
    const mean = between.reduce((sum, [, , force]) => sum + force.length(), 0) / Math.max(between.length, 1);
    const strong = between.filter(([, , force]) => force.length() > mean);
    const touched = rows.filter(([a, b]) => [role(a), role(b)].includes("hand") && [role(a), role(b)].includes("object"));
    const waiting = touched.flatMap(([a, b]) => [a, b].filter((body) => role(body) === "object"));
    const chain = new Set();
    while (waiting.length) {
      const found = waiting.pop();
      if (chain.has(found)) continue;
      chain.add(found);
      for (const [a, b] of strong) if (a === found || b === found) waiting.push(a === found ? b : a);
    }
    const sideways = ({ x, y, z }) => Math.hypot(x, y) > Math.abs(z);
    const walls = rows.filter(([a, b, force]) => role(b) === "support" && chain.has(a) && sideways(force));
    return [...touched, ...strong.filter(([a, b]) => chain.has(a) && chain.has(b)), ...walls];
  }

  return (viewer, data, found) => {
    if (!found) return null;
    const group = drawing.layer(viewer, "chains");
    const links = drawing.bars(group, 2 * found.most + 1, 0xff2d55);
    const role = (body) => (["arm", "sensor"].includes(data.bodies[body]?.role) ? "hand" : data.bodies[body]?.role);
    const objects = new Map(data.bodies.map(({ path }, body) => [body, meshcat.node(viewer, path)]));
    let on = false;
    return {
      show: (visible) => (group.visible = on = visible),
      update(moment) {
        if (!on) return;
        links.clear();
        const [first, end] = found.range(lastFrame(data.frameTime, moment));
        const rows = [];
        for (let k = first; k < end; k++) rows.push([...found.bodies(k), found.force(k), k]);
        for (const [a, b, force, k] of chainOf(rows, role)) {
          const radius = Math.max(THINNEST, WIDTH * force.length()) / 2;
          const point = found.point(k);
          for (const body of [a, b]) if (role(body) === "object") links.add(objects.get(body).position, point, radius);
        }
        links.finish();
      },
    };
  };
})();

// What measures the scene: a grid of 10 cm, axes, and a ruler between two points that are clicked.
function makeRulers(viewer, data) {
  const { GridHelper, AxesHelper, Line, BufferGeometry, LineBasicMaterial } = meshcat.THREE;
  const { low, high } = data.view;
  const layers = Object.fromEntries(["grid", "triads", "ruler"].map((name) => [name, drawing.layer(viewer, name)]));
  const size = 2 * Math.ceil(5 * Math.max(high[0] - low[0], high[1] - low[1]) + 4) / 10;
  const grid = new GridHelper(size, Math.round(10 * size), 0xffffff, 0xb9c3cd);
  grid.rotateX(Math.PI / 2);
  grid.position.set(...[0, 1].map((axis) => Math.round(5 * (low[axis] + high[axis])) / 10), 0.0015);
  layers.grid.add(grid);
  const sensor = data.bodies.find(({ role }) => role === "sensor");
  layers.triads.add(new AxesHelper(0.1));
  const moving = [];
  function attach(path) {
    const axes = new AxesHelper(0.08);
    axes.material.depthTest = false;
    axes.renderOrder = 12;
    layers.triads.add(axes);
    moving.push({ axes, path });
    return moving[moving.length - 1];
  }
  if (sensor) attach(sensor.path);
  const chosen = attach(null);
  const ends = [];
  const line = new Line(new BufferGeometry(), new LineBasicMaterial({ color: 0xffffff, depthTest: false }));
  line.renderOrder = 13;
  line.visible = line.frustumCulled = false;
  layers.ruler.add(line);
  let measuring = false;
  return {
    grid: { show: (on) => (layers.grid.visible = on), update() {} },
    triads: {
      show: (on) => (layers.triads.visible = on),
      choose: (path) => (chosen.path = path),
      update() {
        for (const { axes, path } of moving) {
          axes.visible = Boolean(path);
          if (!path) continue;
          const body = meshcat.node(viewer, path);
          axes.position.copy(body.position);
          axes.quaternion.copy(body.quaternion);
        }
      },
    },
    ruler: {
      show: (on) => (layers.ruler.visible = measuring = on),
      update() {},
      // Takes a point of the scene; returns the distance in words after the second one.
      measure(point) {
        if (!measuring) return null;
        if (ends.length > 1) ends.length = 0;
        ends.push(point);
        line.visible = ends.length > 1;
        if (ends.length < 2) return "ruler: click the second point";
        line.geometry.setFromPoints(ends);
        const step = ends[1].clone().sub(ends[0]);
        return `ruler: ${(1e3 * step.length()).toFixed(0)} mm (${step.toArray().map((value) => (1e3 * value).toFixed(0)).join(", ")})`;
      },
    },
  };
}
