// @ts-check
// The page's script: one clock for all panels, and the controls that move it.
window.pilegrasp = (() => {
  const element = (id) => /** @type {any} */ (document.getElementById(id));
  const all = (selector) => /** @type {any[]} */ ([...document.querySelectorAll(selector)]);
  const blocks = ["commands", "contacts", "signals"].map((name) => all(`script.${name}`).map((block) => block.textContent));
  const panels = JSON.parse(element("page-data").textContent).map((data, index) =>
    makePanel(all(".panel")[index], data, blocks.map((texts) => texts[index])),
  );
  const start = Math.min(...panels.map(({ data }) => data.start));
  const end = Math.max(...panels.map(({ data }) => data.end));
  const marks = panels.flatMap(({ data }) => data.events).sort((a, b) => a.time - b.time);
  const api = { panels, viewer: null, overlays: {} };
  const HIDDEN = 1.5; // pause between two pictures after which the page was hidden [s]
  let now = start;
  let playing = false;
  let before = null;
  let pace = [];

  const speed = () => Number(element("speed").value);

  function show(moment) {
    now = Math.max(start, Math.min(end, moment));
    for (const panel of panels) panel.show(now);
    const scrub = element("scrub");
    scrub.value = end > start ? (now - start) / (end - start) : 0;
    scrub.setAttribute("aria-valuetext", panels.map((panel) => panel.words(Math.min(now, panel.data.end))).join("; "));
    element("clock").textContent = `${now.toFixed(2)} / ${end.toFixed(2)} s`;
  }

  // Tells a screen reader what a step has come to; while the page plays, nothing is said.
  const say = (words) => (element("said").textContent = words);

  function seek(moment) {
    pause();
    show(moment);
    say(element("scrub").getAttribute("aria-valuetext"));
  }

  function play() {
    if (!api.viewer || !(end > start)) return;
    if (now >= end - 1e-3) show(start);
    before = null;
    pace = [];
    playing = true;
  }

  function pause() {
    playing = false;
    element("rate").hidden = true;
  }

  const toggle = () => (playing ? pause() : play());

  // The frames of the first panel; a second one may have others.
  function step(frames) {
    const times = panels[0].data.frameTime;
    const at = lastFrame(times, now);
    seek(times[Math.max(0, Math.min(times.length - 1, frames < 0 && times[at] < now - 1e-6 ? at + frames + 1 : at + frames))]);
  }

  function toEvent(forward) {
    const found = forward ? marks.find(({ time }) => time > now + 1e-3) : marks.findLast(({ time }) => time < now - 1e-3);
    if (!found) return;
    seek(found.time);
    say(`${found.time.toFixed(2)} s: ${found.words}`);
  }

  // The true speed, if the page cannot keep the chosen one: over the last two seconds.
  function showRate(stamp) {
    pace.push([stamp, now]);
    while (pace.length > 2 && stamp - pace[0][0] > 2000) pace.shift();
    const [since, from] = pace[0];
    const rate = stamp > since ? (1000 * (now - from)) / (stamp - since) : speed();
    const honest = stamp - since < 500 || Math.abs(rate / speed() - 1) < 0.1;
    element("rate").hidden = honest;
    if (!honest) element("rate").textContent = `true speed ${rate.toFixed(2)}×`;
  }

  // Goes back to the start of the primitive that the clock has left, or of the last one.
  function loop(from) {
    const { primitives } = panels[0].data;
    const primitive = primitives.find((one) => from >= one.start - 1e-6 && from < one.end - 1e-6);
    if (!primitive || now < primitive.end) return;
    show(primitive.start);
    pace = [];
  }

  function tick(stamp) {
    requestAnimationFrame(tick);
    if (playing) {
      // A slow page skips frames, so that its clock is true; a page that was hidden goes on where it was.
      const elapsed = before === null ? 0 : (stamp - before) / 1000;
      before = stamp;
      const from = now;
      show(now + (elapsed > HIDDEN ? 0 : elapsed) * speed());
      if (element("loop").checked) loop(from);
      showRate(stamp);
      if (now >= end) pause();
    }
    const label = playing ? "Pause" : api.viewer && now >= end - 1e-3 ? "Replay" : "Play";
    if (element("play").textContent !== label) element("play").textContent = label;
  }

  function faster(places) {
    const choice = element("speed");
    choice.selectedIndex = Math.max(0, Math.min(choice.length - 1, choice.selectedIndex + places));
    pace = [];
  }

  function switchOverlays() {
    for (const box of all("[data-overlay]")) {
      const found = panels.map(({ overlays }) => overlays[box.dataset.overlay]).filter(Boolean);
      box.parentElement.hidden = !found.length;
      for (const overlay of found) overlay.show(box.checked);
    }
    show(now);
  }

  const drawn = () => panels.filter((panel) => panel.viewer);

  function switchCamera() {
    for (const panel of drawn()) panel.cameras.choose(element("camera").value);
    show(now);
  }

  function switchCloseup() {
    for (const panel of drawn()) panel.cameras.showCloseup(element("closeup").checked);
    reframe();
  }

  function reframe() {
    for (const panel of drawn()) panel.cameras.frame();
    show(now);
  }

  function setCamera(name) {
    element("camera").value = name;
    switchCamera();
  }

  // Two scenes are seen from the same side, at the same distance.
  function share() {
    if (panels.length < 2) return;
    for (const panel of drawn()) {
      panel.viewer.controls.addEventListener("change", () => {
        for (const other of drawn()) {
          if (other === panel || !panel.active) continue;
          other.viewer.camera.position.copy(panel.viewer.camera.position);
          other.viewer.controls.target.copy(panel.viewer.controls.target);
          other.viewer.camera.lookAt(other.viewer.controls.target);
          meshcat.redraw(other.viewer);
        }
      });
      panel.root.addEventListener("pointerdown", () => drawn().forEach((one) => (one.active = one === panel)), true);
      panel.root.addEventListener("wheel", () => drawn().forEach((one) => (one.active = one === panel)), { capture: true, passive: true });
    }
  }

  function zoom(factor) {
    for (const { timeline } of panels) timeline.zoom(factor, now);
  }

  function keys(event) {
    const { target, key } = event;
    if (target.closest("select, summary") || event.ctrlKey || event.metaKey || event.altKey) return;
    if (target.closest("button, input[type=checkbox]") && [" ", "Enter"].includes(key)) return;
    const far = event.shiftKey ? 1 : 0;
    const boxes = all("[data-overlay]");
    const cameras = [...element("camera").options].map(({ value }) => value);
    const actions = {
      " ": toggle,
      ArrowLeft: () => (far ? seek(now - far) : step(-1)),
      ArrowRight: () => (far ? seek(now + far) : step(1)),
      Home: () => seek(start),
      End: () => seek(end),
      "+": () => faster(1),
      "-": () => faster(-1),
      ",": () => toEvent(false),
      ".": () => toEvent(true),
      z: () => zoom(0.5),
      x: () => zoom(2),
      r: () => element("reframe").click(),
      t: () => setCamera("above"),
      c: () => setCamera(cameras[(cameras.indexOf(element("camera").value) + 1) % cameras.length]),
      n: () => element("closeup").click(),
    };
    const box = /^\d$/.test(key) ? boxes[(Number(key) + 9) % 10] : null;
    if (box && !box.parentElement.hidden) box.click();
    else if (actions[key]) actions[key]();
    else return;
    event.preventDefault();
  }

  function listenToPlot({ timeline }) {
    const { plot } = timeline;
    plot.addEventListener("pointerdown", (event) => {
      if (event.target.closest(".mark, .legend")) return;
      plot.setPointerCapture(event.pointerId);
      seek(timeline.momentAt(event.clientX));
    });
    plot.addEventListener("pointermove", (event) => {
      if (event.buttons) seek(timeline.momentAt(event.clientX));
      else timeline.hover(event.clientX);
    });
    plot.addEventListener("pointerleave", () => timeline.hover(null));
    plot.addEventListener("dblclick", () => zoom(1e6));
    plot.addEventListener(
      "wheel",
      (event) => {
        if (!event.ctrlKey) return;
        event.preventDefault();
        for (const one of panels) one.timeline.zoom(event.deltaY < 0 ? 0.8 : 1.25, timeline.momentAt(event.clientX));
      },
      { passive: false },
    );
  }

  // A click without a drag picks a body.
  function listenToScene(panel) {
    const pane = panel.root.querySelector(".pane");
    let pressed = null;
    panel.now = () => now;
    pane.addEventListener("pointerdown", (event) => (pressed = [event.clientX, event.clientY]));
    pane.addEventListener("pointerup", (event) => {
      if (!pressed || !panel.viewer || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
      panel.pick(event.clientX, event.clientY, now);
    });
  }

  function listen() {
    element("play").addEventListener("click", toggle);
    element("back").addEventListener("click", () => step(-1));
    element("forth").addEventListener("click", () => step(1));
    element("before").addEventListener("click", () => toEvent(false));
    element("next").addEventListener("click", () => toEvent(true));
    element("zoomin").addEventListener("click", () => zoom(0.5));
    element("zoomout").addEventListener("click", () => zoom(2));
    element("reframe").addEventListener("click", () => setCamera("whole"));
    element("camera").addEventListener("change", switchCamera);
    element("closeup").addEventListener("change", switchCloseup);
    element("more").addEventListener("click", () => {
      const open = element("overlays").classList.toggle("open");
      element("more").setAttribute("aria-expanded", String(open));
    });
    element("speed").addEventListener("change", () => (pace = []));
    element("scrub").addEventListener("input", (event) => (pause(), show(start + Number(event.target.value) * (end - start))));
    panels.forEach(listenToPlot);
    panels.forEach(listenToScene);
    document.addEventListener("keydown", keys);
    window.addEventListener("beforeprint", print);
    for (const button of all("[data-seek]")) button.addEventListener("click", () => seek(Number(button.dataset.seek)));
    for (const box of all("[data-overlay]")) box.addEventListener("change", switchOverlays);
    for (const box of all("[data-signal]")) {
      box.addEventListener("change", () => panels.forEach(({ timeline }) => timeline.choose(box.dataset.signal, box.checked)));
    }
    // A menu closes when the reader goes elsewhere.
    document.addEventListener("pointerdown", (event) => {
      const target = /** @type {any} */ (event.target);
      for (const id of ["signals", "share"]) if (!target.closest(`#${id}`)) element(id).open = false;
    });
  }

  // Paper gets the picture of the moment; a browser prints the canvas of a scene empty.
  function print() {
    for (const { viewer, root } of drawn()) {
      viewer.render();
      const pane = root.querySelector(".pane");
      const picture = root.querySelector(".printed") ?? document.createElement("img");
      picture.className = "printed";
      picture.alt = "the scene";
      pane.before(picture);
      picture.src = viewer.renderer.domElement.toDataURL("image/png");
    }
  }

  async function open() {
    try {
      await Promise.all(panels.map((panel) => panel.open()));
      api.viewer = panels[0].viewer;
    } catch (error) {
      for (const panel of panels) panel.showBlank(error);
    }
    share();
    switchOverlays();
    reframe();
    for (const id of ["overlays", "more", "play"]) element(id).hidden = !api.viewer;
    if (!api.viewer) show(end);
    else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play();
  }

  listen();
  show(start);
  tick(0);
  const ready = open();
  // Time of the first picture, in milliseconds since the request of the page.
  const first = ready.then(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  return Object.assign(api, { seek: show, play, pause, step, toEvent, zoom, setCamera, time: () => now, playing: () => playing, ready, drawn: first });
})();
