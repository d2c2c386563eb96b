// @ts-check
// Pictures of the page's scene at given moments; the exporter loads this script into the opened page.
window.picture = (() => {
  const { viewer, seek } = window.pilegrasp;
  const { cameras } = window.pilegrasp.panels[0];
  const root = getComputedStyle(document.documentElement);
  const colour = (name) => root.getPropertyValue(`--${name}`).trim();
  const canvas = document.createElement("canvas");
  const pen = canvas.getContext("2d");
  const tile = { width: 480, height: 300, text: 46, gap: 14 };
  const head = 84;
  let columns = 1;

  function size(width, height) {
    const pane = /** @type {any} */ (document.querySelector(".pane"));
    Object.assign(pane.style, { width: `${width}px`, height: `${height}px` });
    // Twice the pixels in each direction, which are averaged, and soft shadows, even if the page has hard ones.
    viewer.renderer.setPixelRatio(2);
    viewer.renderer.shadowMap.type = meshcat.THREE.PCFSoftShadowMap;
    viewer.scene.traverse(({ material }) => material && (material.needsUpdate = true));
    viewer.set_3d_pane_size();
  }

  // Returns the end of the text; text without room is cut with an ellipsis.
  function write(words, x, y, room, { points = 15, bold = false, ink = "ink", right = false } = {}) {
    pen.font = `${bold ? 600 : 400} ${points}px system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif`;
    const letters = [...words];
    let shown = words;
    while (letters.length && pen.measureText(shown).width > room) {
      letters.pop();
      shown = `${letters.join("").trimEnd()}…`;
    }
    pen.fillStyle = colour(ink);
    const width = pen.measureText(shown).width;
    pen.fillText(shown, right ? x - width : x, y);
    return x + width;
  }

  // Drawing and reading are one task, because the browser may clear the scene's canvas between two tasks.
  function scene(moment, x, y, width, height) {
    seek(moment);
    if (!cameras.moved()) cameras.frame();
    viewer.render();
    const sky = pen.createLinearGradient(0, y, 0, y + height);
    sky.addColorStop(0, colour("sky"));
    sky.addColorStop(1, colour("ground"));
    pen.fillStyle = sky;
    pen.fillRect(x, y, width, height);
    pen.drawImage(viewer.renderer.domElement, x, y, width, height);
  }

  const png = () => canvas.toDataURL("image/png").split(",")[1];

  function openMovie(width, height) {
    [canvas.width, canvas.height] = [width, height];
    size(width, height - 30);
  }

  // The page's text about the moment is below the scene; `note` is at the right.
  function frame(moment, note, ink) {
    const { width, height } = canvas;
    scene(moment, 0, 0, width, height - 30);
    pen.fillStyle = colour("paper");
    pen.fillRect(0, height - 30, width, 30);
    const end = write(document.querySelector(".moment").textContent, 10, height - 10, 0.7 * width);
    write(note, width - 10, height - 10, width - end - 30, { ink, bold: ink !== "soft", right: true });
    return png();
  }

  function openSheet(count, { title, verdict, reason, ink }) {
    columns = count <= 4 ? Math.min(count, 2) : count <= 12 ? 3 : 4;
    canvas.width = tile.gap + columns * (tile.width + tile.gap);
    canvas.height = head + Math.ceil(count / columns) * (tile.height + tile.text + tile.gap);
    size(tile.width, tile.height);
    pen.fillStyle = colour("paper");
    pen.fillRect(0, 0, canvas.width, canvas.height);
    pen.fillStyle = colour(ink);
    pen.fillRect(0, 0, 8, head - tile.gap);
    write(title, 22, 26, canvas.width - 40, { ink: "soft" });
    const end = write(verdict, 22, 56, canvas.width - 40, { points: 24, bold: true, ink });
    write(reason, end + 14, 56, canvas.width - end - 30, { points: 18 });
  }

  // The grasp is seen from near, everything else from where hand and pile fill the picture.
  function addTile(index, { time, words, failed, near }) {
    cameras.choose("action");
    cameras.showOnly(near ? "near" : "far");
    const x = tile.gap + (index % columns) * (tile.width + tile.gap);
    const y = head + Math.floor(index / columns) * (tile.height + tile.text + tile.gap);
    scene(time, x, y, tile.width, tile.height);
    const end = write(`${time.toFixed(2)} s`, x, y + tile.height + 19, tile.width, { bold: true });
    const ink = failed ? "bad" : "ink";
    write(words[0] ?? "", end + 10, y + tile.height + 19, x + tile.width - end - 10, { ink });
    write(words[1] ?? "", end + 10, y + tile.height + 38, x + tile.width - end - 10);
  }

  // The last moment, small and without words.
  function thumbnail(width, height) {
    [canvas.width, canvas.height] = [width, height];
    size(width, height);
    cameras.choose("action");
    cameras.showOnly("far");
    scene(Infinity, 0, 0, width, height);
    return canvas.toDataURL("image/jpeg", 0.8).split(",")[1];
  }

  return { thumbnail, openMovie, frame, openSheet, addTile, png };
})();
