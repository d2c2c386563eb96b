"use strict";
// The page's script: one clock for all panels, and the controls that move it.
window.pilegrasp = (() => {
  const element = (id) => document.getElementById(id);
  const blocks = ["commands", "contacts"].map((name) => [...document.querySelectorAll(`script.${name}`)].map((block) => block.textContent));
  const panels = JSON.parse(element("page-data").textContent).map((data, index) =>
    makePanel(document.querySelectorAll(".panel")[index], data, blocks.map((texts) => texts[index])),
  );
  const start = Math.min(...panels.map(({ data }) => data.start));
  const end = Math.max(...panels.map(({ data }) => data.end));
  const api = { panels, viewer: null, overlays: {} };
  let now = start;
  let playing = false;
  let before = null;

  function show(moment) {
    now = Math.max(start, Math.min(end, moment));
    for (const panel of panels) panel.show(now);
    element("scrub").value = end > start ? (now - start) / (end - start) : 0;
    element("clock").textContent = `${now.toFixed(2)} / ${end.toFixed(1)} s`;
  }

  function play() {
    if (!api.viewer || !(end > start)) return;
    if (now >= end - 1e-3) show(start);
    before = null;
    playing = true;
  }

  function pause() {
    playing = false;
  }

  const toggle = () => (playing ? pause() : play());

  // The frames of the first panel; a second one may have others.
  function step(frames) {
    const times = panels[0].data.frameTime;
    const at = lastFrame(times, now);
    pause();
    show(times[Math.max(0, Math.min(times.length - 1, frames < 0 && times[at] < now - 1e-6 ? at + frames + 1 : at + frames))]);
  }

  function tick(stamp) {
    requestAnimationFrame(tick);
    if (playing) {
      // A page that was hidden, or is slow, continues from its last moment instead of skipping to the end.
      const elapsed = before === null ? 0 : Math.min((stamp - before) / 1000, 0.1);
      before = stamp;
      show(now + elapsed * Number(element("speed").value));
      if (now >= end) pause();
    }
    const label = playing ? "Pause" : api.viewer && now >= end - 1e-3 ? "Replay" : "Play";
    if (element("play").textContent !== label) element("play").textContent = label;
  }

  function faster(places) {
    const speed = element("speed");
    speed.selectedIndex = Math.max(0, Math.min(speed.length - 1, speed.selectedIndex + places));
  }

  function switchOverlays() {
    for (const box of document.querySelectorAll("[data-overlay]")) {
      const found = panels.map(({ overlays }) => overlays[box.dataset.overlay]).filter(Boolean);
      box.parentElement.hidden = !found.length;
      for (const overlay of found) overlay.show(box.checked);
    }
    show(now);
  }

  function keys(event) {
    if (event.target.closest("select, summary, .dg") || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.closest("button, input[type=checkbox]") && [" ", "Enter"].includes(event.key)) return;
    const far = event.shiftKey ? 1 : 0;
    const boxes = document.querySelectorAll("[data-overlay]");
    const actions = {
      " ": toggle,
      ArrowLeft: () => (far ? (pause(), show(now - far)) : step(-1)),
      ArrowRight: () => (far ? (pause(), show(now + far)) : step(1)),
      Home: () => (pause(), show(start)),
      End: () => (pause(), show(end)),
      "+": () => faster(1),
      "-": () => faster(-1),
      r: () => element("reframe").click(),
      t: () => element("above").click(),
    };
    const box = boxes[Number(event.key) - 1];
    if (box && !box.parentElement.hidden) box.click();
    else if (actions[event.key]) actions[event.key]();
    else return;
    event.preventDefault();
  }

  function listen() {
    element("play").addEventListener("click", toggle);
    element("back").addEventListener("click", () => step(-1));
    element("forth").addEventListener("click", () => step(1));
    element("reframe").addEventListener("click", () => panels.forEach((panel) => panel.viewer && panel.frame()));
    element("above").addEventListener("click", () => panels.forEach((panel) => panel.viewer && panel.frame(true)));
    element("scrub").addEventListener("input", (event) => (pause(), show(start + Number(event.target.value) * (end - start))));
    for (const { plot } of panels) {
      const [first, last] = [Number(plot.dataset.start), Number(plot.dataset.end)];
      const follow = (event) => {
        const box = plot.getBoundingClientRect();
        pause();
        show(first + ((last - first) * (event.clientX - box.left)) / box.width);
      };
      plot.addEventListener("pointerdown", (event) => {
        plot.setPointerCapture(event.pointerId);
        follow(event);
      });
      plot.addEventListener("pointermove", (event) => event.buttons && follow(event));
    }
    document.addEventListener("keydown", keys);
    for (const button of document.querySelectorAll("[data-seek]")) {
      button.addEventListener("click", () => (pause(), show(Number(button.dataset.seek))));
    }
    for (const box of document.querySelectorAll("[data-overlay]")) box.addEventListener("change", switchOverlays);
  }

  async function open() {
    try {
      await Promise.all(panels.map((panel) => panel.open()));
      api.viewer = panels[0].viewer;
    } catch (error) {
      for (const panel of panels) panel.showBlank(error);
    }
    switchOverlays();
    element("overlays").hidden = element("play").hidden = !api.viewer;
    if (!api.viewer) show(end);
    play();
  }

  listen();
  show(start);
  tick(0);
  const ready = open();
  // Time of the first picture, in milliseconds since the request of the page.
  const drawn = ready.then(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  return Object.assign(api, { seek: show, play, pause, step, time: () => now, playing: () => playing, ready, drawn });
})();
