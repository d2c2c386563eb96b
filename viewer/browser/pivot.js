// @ts-check
"use strict";
// The plot of success over a key of the study, apart by another, with intervals; and the numbers of it as a table.
(() => {
  const element = (id) => /** @type {any} */ (document.getElementById(id));
  const found = JSON.parse(element("pivots").textContent);
  if (found.length === 0) return;

  // Colours and marks of the series; the colours are Okabe and Ito's, which stay apart for colour-blind readers.
  const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8860b", "#56b4e9", "#777777", "#8b5cf6"];
  const MARKS = ["M-4-4h8v8h-8z", "M0-5l5 9h-10z", "M0-5l5 5-5 5-5-5z", "M-5-5l10 10M5-5l-10 10", "M0-5v10M-5 0h10"];
  const CIRCLE = "M-4.5 0a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0 -9 0";
  const [LEFT, TOP, HEIGHT, BOTTOM] = [52, 12, 220, 58];

  function svg(name, attributes, text = "") {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, String(value));
    node.textContent = text;
    return node;
  }

  const short = (text, length = 16) => (text.length > length ? text.slice(0, length - 1) + "…" : text);

  function say([n, successes, low, high]) {
    return `${successes} of ${n}, ${Math.round((100 * successes) / n)} % (${Math.round(100 * low)}–${Math.round(100 * high)} %)`;
  }

  function draw(pivot) {
    const room = Math.min(900, element("chart").parentElement.clientWidth) - LEFT - 10;
    const step = Math.max(Math.min(64, 22 + 7 * Math.max(...pivot.values.map(({ length }) => length))), Math.min(150, room / pivot.values.length), 7 * pivot.series.length + 14);
    const width = LEFT + step * pivot.values.length + 10;
    const y = (rate) => TOP + HEIGHT * (1 - rate);
    const chart = svg("svg", { width, height: TOP + HEIGHT + BOTTOM, role: "img", "aria-label": `success over ${pivot.x}` });
    for (const rate of [0, 0.25, 0.5, 0.75, 1]) {
      chart.append(svg("line", { x1: LEFT, x2: width - 10, y1: y(rate), y2: y(rate), class: "grid" }));
      chart.append(svg("text", { x: LEFT - 6, y: y(rate) + 4, class: "end" }, `${100 * rate} %`));
    }
    pivot.values.forEach((value, place) => {
      const text = svg("text", { x: LEFT + step * (place + 0.5), y: TOP + HEIGHT + 20, class: "middle" }, short(value, Math.floor(step / 7)));
      text.append(svg("title", {}, value));
      chart.append(text);
    });
    chart.append(svg("text", { x: LEFT + (step * pivot.values.length) / 2, y: TOP + HEIGHT + 44, class: "middle" }, pivot.x));
    // A line leads from number to number, not from word to word.
    const numbers = pivot.values.every((value) => Number.isFinite(Number.parseFloat(value)));
    pivot.series.forEach((name, index) => {
      const shift = Math.min(10, (step - 14) / pivot.series.length) * (index - (pivot.series.length - 1) / 2);
      const group = svg("g", { stroke: COLOURS[index % COLOURS.length], fill: COLOURS[index % COLOURS.length] });
      const places = pivot.cells[index].flatMap((cell, place) => (cell ? [{ cell, place, x: LEFT + step * (place + 0.5) + shift }] : []));
      if (numbers) group.append(svg("path", { d: places.map(({ cell, x }, i) => `${i ? "L" : "M"}${x} ${y(cell[1] / cell[0])}`).join(""), class: "course" }));
      for (const { cell, place, x } of places) {
        const point = svg("g", {});
        point.append(svg("title", {}, `${pivot.x} ${pivot.values[place]}${name && `, ${pivot.by} ${name}`}: ${say(cell)}`));
        point.append(svg("line", { x1: x, x2: x, y1: y(cell[2]), y2: y(cell[3]) }));
        point.append(svg("path", { d: mark(index), transform: `translate(${x} ${y(cell[1] / cell[0])})` }));
        group.append(point);
      }
      chart.append(group);
    });
    const parts = [chart];
    if (pivot.by) parts.push(legend(pivot));
    element("chart").replaceChildren(...parts);
  }

  const mark = (index) => [CIRCLE, ...MARKS][index % (MARKS.length + 1)];

  function legend(pivot) {
    const list = document.createElement("p");
    list.className = "legend";
    list.append(`${pivot.by}: `);
    pivot.series.forEach((name, index) => {
      const colour = COLOURS[index % COLOURS.length];
      const sign = svg("svg", { width: 14, height: 14, viewBox: "-7 -7 14 14", stroke: colour, fill: colour, "aria-hidden": true });
      sign.append(svg("path", { d: mark(index) }));
      const entry = document.createElement("span");
      entry.append(sign, ` ${name} `);
      list.append(entry);
    });
    return list;
  }

  function row(cells, kind) {
    const line = document.createElement("tr");
    for (const text of cells) {
      const cell = document.createElement(kind);
      cell.textContent = text;
      line.append(cell);
    }
    return line;
  }

  function tabulate(pivot) {
    const rows = pivot.values.map((value, place) =>
      row([value, ...pivot.cells.map((cells) => (cells[place] ? say(cells[place]) : "—"))], "td"),
    );
    const names = pivot.by ? pivot.series.map((name) => `${pivot.by} ${name}`) : ["success"];
    element("pivot").replaceChildren(row([pivot.x, ...names], "th"), ...rows);
  }

  function show() {
    const [x, by] = [element("over").value, element("by").value];
    const pivot = found.find((one) => one.x === x && one.by === (by === x ? "" : by));
    draw(pivot);
    tabulate(pivot);
  }

  const keys = [...new Set(found.map((pivot) => pivot.x))];
  element("over").append(...keys.map((key) => new Option(key, key)));
  element("by").append(new Option("nothing", ""), ...keys.map((key) => new Option(key, key)));
  // The fullest plot opens first; among equals, that of the keys that were asked for last.
  const filled = ({ by, cells, series }) => (by && series.length <= COLOURS.length ? cells.flat().filter(Boolean).length : 0);
  const fullest = found.reduce((best, one) => (filled(one) >= filled(best) ? one : best));
  element("over").value = fullest.x;
  element("by").value = fullest.by;
  addEventListener("resize", show);
  for (const id of ["over", "by"]) element(id).addEventListener("input", show);
  element("plot").hidden = false;
  show();
})();
