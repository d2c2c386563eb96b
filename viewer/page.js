"use strict";
// The page's script: feeds meshcat's viewer, and ties the strips' cursors to its clock.
window.pilegrasp = (() => {
  const element = (id) => document.getElementById(id);
  const data = JSON.parse(element("page-data").textContent);
  const span = data.end - data.start;
  let viewer = null;
  let movedByHand = false;
  let shown = null;

  function frame() {
    stage.frame(viewer, data.view);
    movedByHand = false;
  }

  function open() {
    viewer = stage.open(element("pane"), () => movedByHand || frame());
    stage.obey(viewer, Uint8Array.from(atob(element("commands").textContent.trim()), (letter) => letter.charCodeAt(0)));
    // A page that was hidden, or is slow, goes on where it was instead of skipping to the end.
    const clock = viewer.animator.clock;
    const elapsed = clock.getDelta.bind(clock);
    clock.getDelta = () => Math.min(elapsed(), 0.1);
    stage.light(viewer, data.view);
    viewer.set_3d_pane_size();
    viewer.controls.addEventListener("start", () => (movedByHand = true));
  }

  const time = () => data.start + (viewer ? Math.min(viewer.animator.time, span) : (shown ?? span));
  const playing = () => viewer !== null && viewer.animator.playing;

  function seek(moment) {
    const elapsed = Math.max(0, Math.min(span, moment - data.start));
    if (viewer) {
      viewer.animator.seek(elapsed);
      viewer.animator.display_progress(elapsed);
    }
    refresh(data.start + elapsed);
  }

  function play() {
    if (!viewer || !(span > 0)) return;
    if (viewer.animator.time >= span - 1e-3) viewer.animator.reset();
    viewer.animator.play();
  }

  function pause() {
    if (playing()) viewer.animator.pause();
  }

  function forceAt(moment) {
    if (!data.force) return "";
    const after = data.frameTime.findIndex((t) => t >= moment);
    const force = data.force[after < 0 ? data.force.length - 1 : after].toFixed(1);
    return ` · push force ${force.replace("-", "−").replace("−0.0", "0.0")} N`;
  }

  const plots = [...document.querySelectorAll(".plot")].map((plot) => ({
    plot,
    cursor: plot.querySelector(".cursor"),
    start: Number(plot.dataset.start),
    end: Number(plot.dataset.end),
  }));
  const rows = [...document.querySelectorAll("tbody tr")];

  function refresh(moment) {
    shown = moment;
    for (const { cursor, start, end } of plots) {
      cursor.style.left = `${(100 * (moment - start)) / (end - start)}%`;
    }
    plots[0].plot.setAttribute("aria-valuenow", moment.toFixed(2));
    const inside = (phase) => moment >= phase.start && moment < phase.end;
    const phase = data.phases.find(inside);
    data.phases.forEach((candidate, index) => rows[index].classList.toggle("now", inside(candidate)));
    element("now").textContent = `${moment.toFixed(2)} s${phase ? ` · ${phase.name}` : ""}${forceAt(moment)}`;
  }

  function tick() {
    requestAnimationFrame(tick);
    if (viewer && time() !== shown) refresh(time());
    const ended = viewer && viewer.animator.time >= span - 1e-3;
    const label = playing() ? "Pause" : ended ? "Replay" : "Play";
    if (element("play").textContent !== label) element("play").textContent = label;
  }

  function listen() {
    element("play").addEventListener("click", () => (playing() ? pause() : play()));
    element("reframe").addEventListener("click", () => viewer && frame());
    element("speed").addEventListener("change", (event) => {
      if (viewer) viewer.animator.mixer.timeScale = Number(event.target.value);
    });
    for (const { plot, start, end } of plots) {
      const follow = (event) => {
        const box = plot.getBoundingClientRect();
        pause();
        seek(start + ((end - start) * (event.clientX - box.left)) / box.width);
      };
      plot.addEventListener("pointerdown", (event) => {
        plot.setPointerCapture(event.pointerId);
        follow(event);
      });
      plot.addEventListener("pointermove", (event) => event.buttons && follow(event));
    }
    const slider = plots[0].plot;
    const limits = { role: "slider", tabindex: 0, "aria-label": "time", "aria-valuemin": data.start, "aria-valuemax": data.end };
    Object.entries(limits).forEach(([name, value]) => slider.setAttribute(name, value));
    document.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1 / 30, ArrowRight: 1 / 30 }[event.key];
      if (event.target.closest("input, select, button, summary, .dg")) return;
      if (event.key === " ") playing() ? pause() : play();
      else if (step) (pause(), seek(time() + step));
      else return;
      event.preventDefault();
    });
    for (const button of document.querySelectorAll("[data-seek]")) {
      button.addEventListener("click", () => (pause(), seek(Number(button.dataset.seek))));
    }
  }

  try {
    open();
  } catch (error) {
    console.warn("no scene:", error);
    viewer = null;
    element("blank").hidden = false;
    element("controls").hidden = true;
  }
  listen();
  refresh(viewer ? data.start : data.end);
  tick();
  play();
  return { viewer, seek, play, pause, time, playing };
})();
