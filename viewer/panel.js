"use strict";
// Index of the last time that is not after a moment, at least 0; the times increase.
function lastFrame(times, moment) {
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= moment + 1e-6) low = middle;
    else high = middle - 1;
  }
  return low;
}

// One attempt on the page: its scene, its timeline, its table.
function makePanel(root, data, blocks) {
  const find = (selector) => root.querySelector(selector);
  const plot = find(".plot");
  const cursor = find(".cursor");
  const [windowStart, windowEnd] = [Number(plot.dataset.start), Number(plot.dataset.end)];
  const rows = [...root.querySelectorAll("tbody tr")];
  const span = data.end - data.start;
  let movedByHand = false;
  let updateTubes = () => {};

  async function inflate(text) {
    const bytes = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  // From above, the hand points to the right of the picture.
  function frame(above = false) {
    const [x, y] = data.forward;
    sceneView.frame(panel.viewer, above ? { ...data.view, direction: [0.03 * y, -0.03 * x, 1] } : data.view);
    movedByHand = above;
  }

  async function open() {
    const [commands, contacts] = await Promise.all(blocks.map(inflate));
    const viewer = sceneView.open(find(".pane"), () => movedByHand || frame());
    panel.viewer = viewer;
    sceneView.runCommands(viewer, commands);
    // The page's clock moves the animation; meshcat's own buttons would disturb it.
    viewer.animator.folder.domElement.style.display = "none";
    for (const action of viewer.animator.actions) action.play();
    sceneView.light(viewer, data.view);
    updateTubes = makeTubes(viewer, data.tubes);
    panel.overlays = makeOverlays(viewer, data, contacts);
    viewer.set_3d_pane_size();
    viewer.controls.addEventListener("start", () => (movedByHand = true));
  }

  function words(moment) {
    const primitive = data.primitives.find(({ start, end }) => moment >= start && moment < end);
    const force = data.force ? data.force[Math.min(lastFrame(data.frameTime, moment - 1e-4) + 1, data.force.length - 1)].toFixed(1) : null;
    const spoken = force === null ? "" : ` · push force ${force.replace("-", "−").replace("−0.0", "0.0")} N`;
    return `${moment.toFixed(2)} s${primitive ? ` · ${primitive.name}` : ""}${spoken}`;
  }

  function show(moment) {
    const own = Math.max(data.start, Math.min(data.end, moment));
    cursor.style.left = `${(100 * (moment - windowStart)) / (windowEnd - windowStart)}%`;
    data.primitives.forEach(({ start, end }, index) => rows[index].classList.toggle("now", own >= start && own < end));
    find(".moment").textContent = words(own);
    if (!panel.viewer) return;
    const elapsed = Math.min(own - data.start, span);
    panel.viewer.animator.seek(elapsed);
    panel.viewer.animator.display_progress(elapsed);
    updateTubes();
    for (const overlay of Object.values(panel.overlays)) overlay.update(own);
  }

  function showBlank(error) {
    console.warn("no scene:", error);
    panel.viewer = null;
    find(".blank").hidden = false;
  }

  const panel = { data, root, plot, viewer: null, overlays: {}, open, show, frame, showBlank };
  return panel;
}
