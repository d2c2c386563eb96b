// @ts-check
// The curves of the forces under a running attempt: the last seconds, with F_grasp.
function makeForces(plot) {
  const LEAST = 2; // least upper end [N], so that the sensor's noise looks small
  const [width, limit] = [Number(plot.dataset.window), Number(plot.dataset.threshold ?? 0)];
  const find = (selector) => plot.querySelector(selector);
  const values = [...plot.querySelectorAll(".value")];
  const lines = [find("polyline.c0"), find("polyline.c1")];
  const [lane, grid, threshold] = [find(".lane"), find("svg g"), find(".threshold")];
  const place = find(".ticks");

  function labels(parent, name, side, found) {
    for (const old of parent.querySelectorAll(`.${name}`)) old.remove();
    for (const [share, text] of found) {
      const label = document.createElement("span");
      label.className = name;
      label.style[side] = `${100 * share}%`;
      label.textContent = text;
      parent.append(label);
    }
  }

  return ({ values: present, curves }) => {
    const [times, ...forces] = curves;
    const last = Math.max(times[times.length - 1], times[0] + width);
    const first = last - width;
    const all = forces.flat();
    const [lowest, highest] = [Math.min(0, ...all), Math.max(LEAST, 1.1 * limit, ...all)];
    const [low, high] = [lowest - 0.04 * (highest - lowest), highest + 0.08 * (highest - lowest)];
    const up = (value) => (value - low) / (high - low);
    const across = (time) => (time - first) / width;
    lines.forEach((line, index) =>
      line.setAttribute("points", forces[index].map((value, k) => `${(1000 * across(times[k])).toFixed(1)},${(100 * (1 - up(value))).toFixed(1)}`).join(" ")),
    );
    values.forEach((value, index) => (value.textContent = written(present[index], 1)));
    for (const end of ["y1", "y2"]) threshold?.setAttribute(end, String(100 * (1 - up(limit))));
    const [steps, decimals] = niceTicks(low, high, 5);
    grid.replaceChildren(
      ...steps.map((value) => {
        const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
        const y = String(100 * (1 - up(value)));
        for (const [key, text] of Object.entries({ class: "grid", x1: "0", x2: "1000", y1: y, y2: y })) line.setAttribute(key, text);
        return line;
      }),
    );
    labels(lane, "ty", "bottom", steps.map((value) => [up(value), written(value, decimals)]));
    const [moments] = niceTicks(first, last, 10);
    labels(place, "tx", "left", moments.map((time) => [across(time), time.toFixed(0)]));
  };
}
