// @ts-check
// The page of a running attempt: binary messages hold meshcat's commands, texts the view, the moment with its forces, and
// the verdict.
window.live = (() => {
  const element = (id) => /** @type {any} */ (document.getElementById(id));
  let view = null;
  let movedByHand = false;
  let ended = false;
  let updateTubes = () => {};
  const pane = element("pane");
  const viewer = sceneView.open(pane, () => {
    if (view && !movedByHand) sceneView.frame(viewer, view.low, view.high, view.direction, pane.clientWidth / pane.clientHeight);
  });
  viewer.set_3d_pane_size();
  viewer.controls.addEventListener("start", () => (movedByHand = true));

  const showForces = makeForces(element("forces"));

  // A simulation that is slower than real time is shown as slow as it is.
  function showPace(factor) {
    const slow = factor < 0.95;
    element("pace").textContent = `real-time factor ${factor.toFixed(factor < 10 ? 1 : 0)}${slow ? ", slower than real time" : ""}`;
    element("pace").className = slow ? "slow" : "";
  }

  function showVerdict(verdict, reason = "", state = "unknown", tally = "") {
    element("tally").textContent = tally && `· ${tally}`;
    element("head").className = state;
    element("verdict").textContent = verdict;
    element("reason").textContent = reason;
  }

  function receive(message) {
    if (message.view) {
      view = message.view;
      sceneView.light(viewer, view);
      roundPalm(viewer, message.bodies);
      updateTubes = makeTubes(viewer, message.tubes);
      viewer.set_3d_pane_size();
    }
    if (message.now !== undefined) {
      element("now").textContent = message.now;
      updateTubes();
      if (message.forces.curves) showForces(message.forces);
      if (message.factor) showPace(message.factor);
      showVerdict("Running");
    }
    if (message.verdict !== undefined) {
      ended = true;
      if (message.factor) showPace(message.factor);
      showVerdict(message.verdict, message.reason, message.state, message.tally);
    }
  }

  const socket = new WebSocket(`ws://${location.host}/frames`);
  socket.binaryType = "arraybuffer";
  socket.addEventListener("message", ({ data }) => {
    if (typeof data === "string") receive(JSON.parse(data));
    else sceneView.runCommands(viewer, new Uint8Array(data));
  });
  socket.addEventListener("close", () => ended || showVerdict("Ended", "the program has ended or was interrupted"));
  return { viewer };
})();
