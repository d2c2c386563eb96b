"use strict";
// The page's script: feeds meshcat's viewer, frames the scene, and ties the strips' cursors to the viewer's clock.
window.pilegrasp = (() => {
  const element = (id) => document.getElementById(id);
  const data = JSON.parse(element("page-data").textContent);
  const span = data.end - data.start;
  let viewer = null;
  let movedByHand = false;
  let shown = null;

  // Each command stands after its length (32 bits, little-endian).
  function* messages(base64) {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const numbers = new DataView(bytes.buffer);
    for (let at = 0; at < bytes.length; ) {
      const length = numbers.getUint32(at, true);
      yield bytes.slice(at + 4, at + 4 + length);
      at += 4 + length;
    }
  }

  // The scene is z-up and the viewer's world y-up.
  const world = ([x, y, z]) => new MeshCat.THREE.Vector3(x, z, -y);

  // The nearest place on the line of sight from which every corner of the action's box would be in the picture, and a
  // tenth nearer, as nothing fills the corners.
  function frame() {
    const { low, high, direction } = data.view;
    const target = world(low).add(world(high)).multiplyScalar(0.5);
    const toward = world(direction).normalize();
    const right = new MeshCat.THREE.Vector3(0, 1, 0).cross(toward).normalize();
    const up = toward.clone().cross(right);
    const height = Math.tan((viewer.camera.fov * Math.PI) / 360);
    const width = height * viewer.camera.aspect;
    let distance = 0;
    for (let corner = 0; corner < 8; corner++) {
      const point = world([0, 1, 2].map((axis) => (corner & (1 << axis) ? high : low)[axis])).sub(target);
      const across = Math.abs(point.dot(right)) / width;
      const along = Math.abs(point.dot(up)) / height;
      distance = Math.max(distance, point.dot(toward) + Math.max(across, along));
    }
    viewer.camera.position.copy(target).addScaledVector(toward, 0.9 * distance);
    viewer.controls.target.copy(target);
    viewer.controls.update();
    movedByHand = false;
    viewer.set_dirty();
  }

  function light() {
    const { low, high, direction } = data.view;
    const spot = viewer.scene_tree.find(["Lights", "SpotLight", "<object>"]).object;
    const middle = [0, 1, 2].map((axis) => (low[axis] + high[axis]) / 2);
    spot.position.set(middle[0] - 0.5, middle[1] + (direction[1] > 0 ? 0.9 : -0.9), middle[2] + 1.8);
    spot.target.position.copy(world(middle));
    spot.target.updateMatrixWorld();
    spot.shadow.normalBias = 0.004;
  }

  function open() {
    viewer = new MeshCat.Viewer(element("pane"));
    // meshcat sizes itself to the window; here it fills its pane.
    const resize = viewer.set_3d_pane_size.bind(viewer);
    viewer.set_3d_pane_size = () => {
      const pane = element("pane");
      resize(pane.clientWidth, pane.clientHeight);
      if (!movedByHand) frame();
    };
    for (const message of messages(element("commands").textContent.trim())) {
      viewer.handle_command_bytearray(message);
    }
    // A page that was hidden, or is slow, goes on where it was instead of skipping to the end.
    const clock = viewer.animator.clock;
    const elapsed = clock.getDelta.bind(clock);
    clock.getDelta = () => Math.min(elapsed(), 0.1);
    light();
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
