"use strict";
// The page of a running attempt: binary messages are meshcat's commands, texts say what to frame and what happens.
window.live = (() => {
  const element = (id) => document.getElementById(id);
  let view = null;
  let movedByHand = false;
  let ended = false;
  let bend = () => {};
  const viewer = sceneView.open(element("pane"), () => view && !movedByHand && sceneView.frame(viewer, view));
  viewer.set_3d_pane_size();
  viewer.controls.addEventListener("start", () => (movedByHand = true));

  function tell(verdict, reason = "", state = "unknown") {
    element("head").className = state;
    element("verdict").textContent = verdict;
    element("reason").textContent = reason;
  }

  function hear(message) {
    if (message.view) {
      view = message.view;
      sceneView.light(viewer, view);
      bend = makeTubes(viewer, message.tubes);
      viewer.set_3d_pane_size();
    }
    if (message.now !== undefined) {
      element("now").textContent = message.now;
      bend();
      tell("Running");
    }
    if (message.verdict !== undefined) {
      ended = true;
      tell(message.verdict, message.reason, message.state);
    }
  }

  const socket = new WebSocket(`ws://${location.host}/frames`);
  socket.binaryType = "arraybuffer";
  socket.addEventListener("message", ({ data }) => {
    if (typeof data === "string") hear(JSON.parse(data));
    else sceneView.obey(viewer, new Uint8Array(data));
  });
  socket.addEventListener("close", () => ended || tell("Ended", "the program has ended or was interrupted"));
  return { viewer };
})();
