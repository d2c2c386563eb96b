"use strict";
// The page of a running attempt: binary messages hold meshcat's commands, texts hold the view, the moment and the verdict.
window.live = (() => {
  const element = (id) => document.getElementById(id);
  let view = null;
  let movedByHand = false;
  let ended = false;
  let updateTubes = () => {};
  const viewer = sceneView.open(element("pane"), () => view && !movedByHand && sceneView.frame(viewer, view));
  viewer.set_3d_pane_size();
  viewer.controls.addEventListener("start", () => (movedByHand = true));

  function showVerdict(verdict, reason = "", state = "unknown") {
    element("head").className = state;
    element("verdict").textContent = verdict;
    element("reason").textContent = reason;
  }

  function receive(message) {
    if (message.view) {
      view = message.view;
      sceneView.light(viewer, view);
      updateTubes = makeTubes(viewer, message.tubes);
      viewer.set_3d_pane_size();
    }
    if (message.now !== undefined) {
      element("now").textContent = message.now;
      updateTubes();
      showVerdict("Running");
    }
    if (message.verdict !== undefined) {
      ended = true;
      showVerdict(message.verdict, message.reason, message.state);
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
