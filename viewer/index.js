"use strict";
// Filters of the table of attempts.
(() => {
  const element = (id) => document.getElementById(id);
  const rows = [...document.querySelectorAll("#attempts tbody tr")].map((row) => ({ row, words: row.textContent.toLowerCase() }));

  function filter() {
    const words = element("words").value.toLowerCase().split(/\s+/).filter(Boolean);
    const [verdict, group, recorded] = [element("verdict").value, element("group").value, element("recorded").checked];
    let shown = 0;
    for (const { row, words: own } of rows) {
      const fits =
        (!verdict || row.className === verdict) &&
        (!group || row.dataset.group === group) &&
        (!recorded || row.querySelector("a")) &&
        words.every((word) => own.includes(word));
      row.hidden = !fits;
      shown += fits ? 1 : 0;
    }
    element("count").textContent = shown === rows.length ? `${shown}` : `${shown} of ${rows.length}`;
  }

  element("filters").addEventListener("input", filter);
  element("filters").addEventListener("submit", (event) => event.preventDefault());
  element("filters").addEventListener("reset", () => setTimeout(filter));
  for (const button of document.querySelectorAll("[data-only]")) {
    button.addEventListener("click", () => {
      element("group").value = button.dataset.only;
      filter();
      element("filters").scrollIntoView();
    });
  }
  filter();
})();
