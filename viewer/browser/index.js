// @ts-check
"use strict";
// The tables of a study: filters of the attempts, order by a column, and the attempts that are shown as CSV.
(() => {
  const element = (id) => /** @type {any} */ (document.getElementById(id));
  const all = (selector, root = document) => /** @type {any[]} */ ([...root.querySelectorAll(selector)]);
  const STEP = 300; // number of rows that are drawn at once; more follow when the reader scrolls
  const body = element("attempts").tBodies[0];
  const words = new Map();
  let fitting = [];
  let drawn = 0;

  // Draws further attempts of those that fit.
  function draw(count) {
    for (const row of fitting.slice(drawn, drawn + count)) row.hidden = false;
    drawn += count;
  }

  function wordsOf(row) {
    if (!words.has(row)) words.set(row, row.textContent.toLowerCase());
    return words.get(row);
  }

  function filter() {
    const wanted = element("words").value.toLowerCase().split(/\s+/).filter(Boolean);
    const chosen = (id) => element(id).value;
    const rows = /** @type {any[]} */ ([...body.rows]);
    fitting = rows.filter(
      (row) =>
        (!chosen("verdict") || row.className === chosen("verdict")) &&
        (!chosen("group") || row.dataset.group === chosen("group")) &&
        (!chosen("reason") || row.dataset.reason === chosen("reason")) &&
        (!element("recorded").checked || row.querySelector("a")) &&
        wanted.every((word) => wordsOf(row).includes(word)),
    );
    for (const row of rows) row.hidden = true;
    drawn = 0;
    draw(STEP);
    element("count").textContent = fitting.length === rows.length ? `${rows.length}` : `${fitting.length} of ${rows.length}`;
  }

  const pane = element("attempts").parentElement;
  pane.addEventListener("scroll", () => {
    if (drawn < fitting.length && pane.scrollTop + 2 * pane.clientHeight > pane.scrollHeight) draw(STEP);
  });
  addEventListener("beforeprint", () => draw(fitting.length));

  function only(id, value) {
    element(id).value = value;
    filter();
    element("filters").scrollIntoView();
  }

  element("filters").addEventListener("input", filter);
  element("filters").addEventListener("submit", (event) => event.preventDefault());
  element("filters").addEventListener("reset", () => setTimeout(filter));
  for (const button of all("[data-only]")) button.addEventListener("click", () => only("group", button.dataset.only));
  for (const button of all("button[data-reason]")) {
    button.addEventListener("click", () => only("reason", button.dataset.reason));
  }
  filter();

  // Numbers by their value, the rest by its letters, what is empty at the end.
  function compare(a, b) {
    if (!a || !b) return (a ? 0 : 1) - (b ? 0 : 1);
    const [x, y] = [Number.parseFloat(a), Number.parseFloat(b)];
    return Number.isFinite(x) && Number.isFinite(y) && x !== y ? x - y : a.localeCompare(b);
  }

  for (const table of all("table.sortable")) {
    for (const head of all("th", table)) {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const rising = head.getAttribute("aria-sort") !== "ascending";
        for (const other of all("th", table)) other.removeAttribute("aria-sort");
        head.setAttribute("aria-sort", rising ? "ascending" : "descending");
        const sign = rising ? 1 : -1;
        const keyed = [...table.tBodies[0].rows].map((row) => ({ row, key: row.cells[head.cellIndex].textContent.trim() }));
        keyed.sort((a, b) => (a.key && b.key ? sign * compare(a.key, b.key) : compare(a.key, b.key)));
        table.tBodies[0].append(...keyed.map(({ row }) => row));
        if (table.id === "attempts") filter();
      });
    }
  }

  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

  function csv() {
    const lines = [element("attempts").tHead.rows[0], ...fitting]
      .map((row) => [...row.cells].slice(1).map((cell) => quoted(cell.textContent.trim())).join(","));
    return lines.join("\r\n") + "\r\n";
  }

  element("csv").addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([csv()], { type: "text/csv" }));
    link.download = "attempts.csv";
    link.click();
    URL.revokeObjectURL(link.href);
  });
  window.study = { csv };
})();
