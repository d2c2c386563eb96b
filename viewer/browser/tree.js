// @ts-check
// The bodies of a scene: a tree with a switch for each, and what is known about the one that is clicked.
const makeTree = (() => {
  const GROUPS = [["Arm", ["arm", "sensor"]], ["Hand", ["hand"]], ["Objects", ["object"]], ["Support", ["support"]]];

  function element(tag, attributes = {}, text = "") {
    const made = Object.assign(document.createElement(tag), attributes);
    if (text) made.textContent = text;
    return made;
  }

  // A box that shows and hides; `change` gets whether it is on.
  function eye(label, change) {
    const line = element("label");
    const box = element("input", { type: "checkbox", checked: true });
    box.addEventListener("change", () => change(box.checked));
    line.append(box, document.createTextNode(label));
    return [line, box];
  }

  return (root, viewer, data, choose) => {
    const place = root.querySelector("details.tree");
    const buttons = new Map();
    const shown = (path, on) => {
      meshcat.node(viewer, path).visible = on;
      meshcat.redraw(viewer);
    };
    for (const [name, roles] of GROUPS) {
      const bodies = data.bodies.filter(({ role }) => roles.includes(role));
      if (!bodies.length) continue;
      const group = element("details");
      const head = element("summary", {}, `${name} (${bodies.length})`);
      const boxes = [];
      const [whole] = eye("all", (on) => {
        for (const [box, path] of boxes) {
          box.checked = on;
          shown(path, on);
        }
      });
      group.append(head, whole);
      for (const { path, name: body } of bodies) {
        const line = element("div", { className: "body" });
        const [label, box] = eye("", (on) => shown(path, on));
        box.setAttribute("aria-label", `show ${body}`);
        const button = element("button", { type: "button" }, body);
        button.addEventListener("click", () => choose(path));
        boxes.push([box, path]);
        buttons.set(path, button);
        line.append(label, button);
        group.append(line);
      }
      place.append(group);
    }
    return {
      mark(path) {
        for (const [own, button] of buttons) button.setAttribute("aria-pressed", String(own === path));
      },
    };
  };
})();

// The chosen body: an outline, and a card with its name, pose, speed, contacts and time in the hand.
function makeCard(root, viewer, data, contacts) {
  const card = root.querySelector(".card");
  const outlines = new Map();
  let path = null;
  let note = "";
  const millimeters = (vector) => vector.toArray().map((value) => (1e3 * value).toFixed(0)).join(", ");

  function touching(body, moment) {
    if (!contacts) return "contacts were not recorded";
    const [first, end] = contacts.range(lastFrame(data.frameTime, moment));
    const found = [];
    for (let k = first; k < end; k++) {
      const pair = contacts.bodies(k);
      if (!pair.includes(body)) continue;
      const other = data.bodies[pair[0] === body ? pair[1] : pair[0]];
      found.push(`${other?.name ?? "?"} ${contacts.force(k).length().toFixed(1)} N`);
    }
    return found.length ? `touches ${found.slice(0, 6).join(", ")}${found.length > 6 ? ", …" : ""}` : "touches nothing";
  }

  function words(moment) {
    const body = data.bodies.findIndex((one) => one.path === path);
    const { name, role } = data.bodies[body];
    const [motion] = drawing.motions(viewer, [path]);
    const elapsed = moment - data.start;
    const step = drawing.positionAt(motion, elapsed + 0.02).sub(drawing.positionAt(motion, Math.max(0, elapsed - 0.02)));
    const turn = meshcat.node(viewer, path).quaternion;
    const angle = (2 * Math.acos(Math.min(1, Math.abs(turn.w))) * 180) / Math.PI;
    const held = data.carried.filter((one) => one.name === name).map(({ start, end, ending }) => `${start.toFixed(1)}–${end.toFixed(1)} s, ${ending}`);
    return [
      `${name} (${role})`,
      `at ${millimeters(drawing.positionAt(motion, elapsed))} mm, turned by ${angle.toFixed(0)}°`,
      `speed ${(1e3 * step.length() / 0.04).toFixed(0)} mm/s`,
      touching(body, moment),
      ...(role === "object" ? [held.length ? `in the hand ${held.join("; ")}` : "never in the hand"] : []),
    ];
  }

  function update(moment) {
    card.hidden = !path && !note;
    if (card.hidden) return;
    card.replaceChildren(...[...(path ? words(moment) : []), ...(note ? [note] : [])].map((text) => Object.assign(document.createElement("div"), { textContent: text })));
  }

  return {
    update,
    path: () => path,
    say: (text) => (note = text),
    choose(chosen) {
      outlines.get(path)?.(false);
      path = chosen === path ? null : chosen;
      if (!path) return;
      if (!outlines.has(path)) outlines.set(path, outline(viewer, path, 0xffffff, 1.1));
      outlines.get(path)(true);
    },
  };
}
