// @ts-check
// What leaves the page: a link to this moment, the command of the attempt, its recording, curves and picture.
(() => {
  const element = (id) => /** @type {any} */ (document.getElementById(id));
  const all = (selector) => /** @type {any[]} */ ([...document.querySelectorAll(selector)]);
  const { panels, ready } = window.pilegrasp;

  // The state of the page as the part of its address behind "#".
  function state() {
    const shown = all("[data-overlay]").filter((box) => box.checked && !box.parentElement.hidden);
    const parts = new URLSearchParams({
      t: window.pilegrasp.time().toFixed(3),
      cam: element("camera").value,
      show: shown.map((box) => box.dataset.overlay).join(","),
      close: element("closeup").checked ? "1" : "0",
    });
    return String(parts).replaceAll("%2C", ",");
  }

  // Follows an address; what it does not name, or names wrongly, stays as it is.
  function follow() {
    const asked = new URLSearchParams(location.hash.slice(1));
    const boxes = all("[data-overlay]");
    if (asked.has("show")) {
      const names = asked.get("show").split(",");
      for (const box of boxes) if (box.checked !== names.includes(box.dataset.overlay)) box.click();
    }
    if (asked.has("close") && element("closeup").checked !== (asked.get("close") === "1")) element("closeup").click();
    if ([...element("camera").options].some(({ value }) => value === asked.get("cam"))) window.pilegrasp.setCamera(asked.get("cam"));
    const moment = Number.parseFloat(asked.get("t") ?? "");
    if (!Number.isFinite(moment)) return;
    window.pilegrasp.pause();
    window.pilegrasp.seek(moment);
  }

  const link = () => `${location.href.split("#")[0]}#${state()}`;

  // Puts a text into the field below, and into the clipboard where the browser allows that.
  async function copy(text, what) {
    const field = element("copied");
    field.hidden = false;
    field.value = text;
    field.select();
    try {
      await navigator.clipboard.writeText(text);
      element("said").textContent = `${what} copied`;
    } catch {
      element("said").textContent = `${what} in the field, ready to copy`;
    }
  }

  function save(name, content, type) {
    const anchor = document.createElement("a");
    anchor.href = URL.createObjectURL(new Blob([content], { type }));
    anchor.download = name;
    anchor.click();
    setTimeout(() => URL.revokeObjectURL(anchor.href), 1000);
  }

  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const numbered = (stem, index, suffix) => (panels.length > 1 ? `${stem}-${index + 1}.${suffix}` : `${stem}.${suffix}`);

  // All curves of a panel, a line for each sample.
  function csv({ data, timeline }) {
    const { times, columns } = timeline.signals();
    const lines = [["time [s]", ...data.curves].map((name) => `"${name.replaceAll('"', '""')}"`).join(",")];
    for (let k = 0; k < times.length; k++) {
      lines.push([times[k].toFixed(4), ...columns.map((values) => String(Number(values[k].toPrecision(5))))].join(","));
    }
    return lines.join("\r\n") + "\r\n";
  }

  // Drawing and reading are one task, because the browser may clear the canvas between two tasks.
  function png({ viewer }) {
    viewer.render();
    return bytes(viewer.renderer.domElement.toDataURL("image/png").split(",")[1]);
  }

  const actions = {
    link: () => copy(link(), "link"),
    command: () => copy(panels.map(({ data }) => data.command).filter(Boolean).join("\n"), "command"),
    recording: () => all("script.recording").forEach((block, index) => save(numbered("recording", index, "npz"), bytes(block.textContent.trim()), "application/octet-stream")),
    csv: () => panels.forEach((panel, index) => save(numbered("curves", index, "csv"), csv(panel), "text/csv")),
    png: () => panels.filter(({ viewer }) => viewer).forEach((panel, index) => save(numbered("scene", index, "png"), png(panel), "image/png")),
  };
  for (const button of all("[data-share]")) button.addEventListener("click", actions[button.dataset.share]);
  if (new URLSearchParams(location.search).has("embed")) document.body.classList.add("embed");
  window.addEventListener("hashchange", follow);
  ready.then(follow);
  Object.assign(window.pilegrasp, { state, link, csv, png });
})();
