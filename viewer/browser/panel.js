// @ts-check
// One attempt on the page: its scene, its timeline, its table.
function makePanel(root, data, blocks) {
  const find = (selector) => root.querySelector(selector);
  const rows = [...root.querySelectorAll("tr.primitive")];
  const groups = [...root.querySelectorAll("tbody.attempt")];
  const timeline = makeTimeline(root, data);
  const span = data.end - data.start;
  let updateTubes = () => {};
  let [card, cameras] = [null, null];
  let present = null;
  /** @type {(moment: number) => string} */
  let touched = () => "";
  const FEW = 4; // largest number of touched objects that are named

  async function inflate(text) {
    const bytes = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  // The close-up's frame and name, and the texts of the scene that must not lie on it.
  function showPlaces(beside) {
    const label = find(".closeup-label");
    label.hidden = !beside;
    if (!beside) return;
    const [left, bottom, width, height] = beside;
    find(".scene").classList.toggle("inset-left", left === 0);
    Object.assign(label.style, { left: `${left}px`, bottom: `${bottom}px`, width: `${width}px`, height: `${height}px` });
  }

  async function open() {
    const [commands, contactBytes, signals] = await Promise.all(blocks.map(inflate));
    timeline.load(readSignals(signals));
    const viewer = sceneView.open(find(".pane"), () => cameras && !cameras.moved() && cameras.frame());
    panel.viewer = viewer;
    sceneView.runCommands(viewer, commands);
    meshcat.start(viewer);
    sceneView.light(viewer, data.view);
    roundPalm(viewer, data.bodies);
    updateTubes = makeTubes(viewer, data.tubes);
    const contacts = drawing.readContacts(contactBytes);
    if (contacts) touched = (moment) => touching(contacts, moment);
    panel.cameras = cameras = makeCameras(viewer, find(".pane"), data, showPlaces);
    panel.overlays = makeOverlays(viewer, data, contacts);
    panel.card = card = makeCard(root, viewer, data, contacts);
    panel.tree = makeTree(root, viewer, data, panel.choose);
    meshcat.onRender(viewer, cameras.render);
    viewer.set_3d_pane_size();
  }

  function words(moment) {
    const primitive = data.primitives.find(({ start, end }) => moment >= start && moment < end);
    const number = data.ordered ? `attempt ${data.attempts.indexOf(attemptAt(data.attempts, moment)) + 1} · ` : "";
    const force = data.force ? data.force[Math.min(lastFrame(data.frameTime, moment - 1e-4) + 1, data.force.length - 1)].toFixed(1) : null;
    const spoken = force === null ? "" : ` · push force ${force.replace("-", "−").replace("−0.0", "0.0")} N`;
    return `${moment.toFixed(2)} s${primitive ? ` · ${number}${primitive.name}` : ""}${spoken}${touched(moment)}`;
  }

  // What the hand touches at a moment, by the recorded contacts: objects by their numbers, table and walls as support.
  function touching(contacts, moment) {
    const [first, last] = contacts.range(lastFrame(data.frameTime, moment));
    const found = new Set();
    for (let k = first; k < last; k++) {
      const [hand, other] = contacts.bodies(k).map((body) => data.bodies[body]);
      if (hand?.role === "hand" && other?.role === "support") found.add("support");
      if (hand?.role === "hand" && other?.role === "object") found.add(other.name.match(/\d+$/)?.[0] ?? other.name);
    }
    const names = [...found].sort((a, b) => a.localeCompare(b, "en", { numeric: true }));
    if (!names.length) return "";
    return ` · hand touches ${names.length > FEW ? `${names.length} bodies` : names.join(", ")}`;
  }

  // The rows of the present attempt are open; the others show what came of them.
  function showAttempt(moment) {
    const index = groups.findLastIndex((group) => Number(group.dataset.start) <= moment + 1e-6);
    const group = groups[Math.max(0, index)];
    if (!group || group === present) return;
    present = group;
    for (const one of groups) one.classList.toggle("closed", one !== group);
  }

  function show(moment) {
    const own = Math.max(data.start, Math.min(data.end, moment));
    timeline.show(moment);
    showAttempt(own);
    data.primitives.forEach(({ start, end }, index) => rows[index].classList.toggle("now", own >= start && own < end));
    find(".moment").textContent = words(own);
    if (!panel.viewer) return;
    const elapsed = Math.min(own - data.start, span);
    meshcat.seek(panel.viewer, elapsed);
    updateTubes();
    if (data.tool) cameras.follow(data.tool[lastFrame(data.frameTime, own)], attemptAt(data.attempts, own).forward);
    for (const overlay of Object.values(panel.overlays)) overlay.update(own);
    card.update(own);
  }

  // A finger is drawn as one tube; a hit belongs to the nearest of its segments.
  function fingerHits(ray) {
    const tubes = [];
    panel.viewer.scene.traverse((mesh) => mesh.name === "tube" && tubes.push(mesh));
    return tubes.flatMap((tube) => {
      tube.geometry.computeBoundingSphere();
      return ray.intersectObject(tube, false).map((hit) => {
        const place = tube.parent.worldToLocal(hit.point.clone());
        const away = (path) => meshcat.node(panel.viewer, path).position.distanceTo(place);
        const [path] = tube.userData.paths.toSorted((a, b) => away(a) - away(b));
        return { path, distance: hit.distance, point: hit.point };
      });
    });
  }

  // Marks a body, or the end of the ruler, at a point of the picture.
  function pick(clientX, clientY, moment) {
    const box = find(".pane").getBoundingClientRect();
    const [x, y] = [clientX - box.left, box.bottom - clientY];
    const inside = (place) => place && x >= place[0] && x <= place[0] + place[2] && y >= place[1] && y <= place[1] + place[3];
    const [far, beside] = cameras.places();
    const [camera, place] = inside(beside) ? [cameras.near, beside] : [panel.viewer.camera, far];
    const ray = new meshcat.THREE.Raycaster();
    ray.setFromCamera({ x: (2 * (x - place[0])) / place[2] - 1, y: (2 * (y - place[1])) / place[3] - 1 }, camera);
    const seen = data.bodies.map(({ path }) => [path, meshcat.node(panel.viewer, path)]).filter(([, node]) => node.visible);
    const hits = seen.flatMap(([path, node]) => ray.intersectObject(node, true).map((hit) => ({ path, ...hit })));
    const hit = [...hits, ...fingerHits(ray)].sort((a, b) => a.distance - b.distance)[0];
    if (!hit) return;
    const { x: right, y: up, z: toward } = hit.point;
    const measured = panel.overlays.ruler?.measure(new meshcat.THREE.Vector3(right, -toward, up));
    card.say(measured ?? "");
    if (measured) card.update(moment);
    else panel.choose(hit.path, moment);
    meshcat.redraw(panel.viewer);
  }

  function choose(path, moment = panel.now()) {
    card.choose(path);
    panel.overlays.triads?.choose(card.path());
    panel.tree.mark(card.path());
    card.update(moment);
    panel.overlays.triads?.update(moment);
    meshcat.redraw(panel.viewer);
  }

  function showBlank(error) {
    console.warn("no scene:", error);
    panel.viewer = null;
    find(".blank").hidden = false;
  }

  const panel = { data, root, timeline, plot: timeline.plot, viewer: null, cameras: null, card: null, tree: null, overlays: {}, now: () => data.start, open, show, words, pick, choose, showBlank };
  return panel;
}
