"""The live view: an attempt in the browser while it runs, from a small server on this machine's loopback interface.

The server of meshcat answers on every interface of the machine, so its viewer is served from here instead.
"""

from __future__ import annotations

import asyncio
import json
import socket
import threading
import time
from collections.abc import Mapping
from concurrent.futures import Future
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets

from pilegrasp_ctrl.analysis.reading import number, plain
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.recording_parts import Body
from pilegrasp_ctrl.types import rotation_matrices
from pilegrasp_ctrl.viewer.browser import LIVE_SCRIPTS, own_script, viewer_script
from pilegrasp_ctrl.viewer.live.forces import WINDOW, Forces
from pilegrasp_ctrl.viewer.live.pace import Pace
from pilegrasp_ctrl.viewer.live.server import Audience, application
from pilegrasp_ctrl.viewer.page.panel import STATES
from pilegrasp_ctrl.viewer.page.summary import summarize, tally
from pilegrasp_ctrl.viewer.scene.camera import view
from pilegrasp_ctrl.viewer.scene.commands import commands, node_path, pack
from pilegrasp_ctrl.viewer.scene.shapes import column_major, tubes
from pilegrasp_ctrl.viewer.templates import render, trusted

LOOPBACK = "127.0.0.1"
"""Address of the server: only this machine can reach it."""

PORTS = (*range(7000, 7020), 0)
"""Ports that are tried, in this order; 0 means any free port. Meshcat's default port comes first, so that an existing
tunnel still works."""

FIRST_PAGE_TIMEOUT = 20.0
"""Time that the attempt waits for a first open page [s]; chosen."""

BOX_MARGIN = np.array([0.1, 0.1, 0.05])
"""Margin of the framed box around hand and objects at the start, because they will move [m]; chosen."""


class LiveView:
    """The server of one attempt for any number of browsers on this machine; a context manager.

    `episode.run(on_frame=view.show, on_sample=view.sample)` shows the attempt. The view slows the simulation down to
    real time and changes nothing else. It starts when the first page is open, or `timeout` [s] after the view was made.

    Args:
        title: Title of the page.
        timeout: Longest time to wait for a first page [s].
        config: Scenario as JSON values; the page draws its F_grasp.

    Attributes:
        url: Address of the page.

    Raises:
        ExportError: No port is free, or meshcat's viewer is missing.
    """

    def __init__(
        self, title: str, timeout: float = FIRST_PAGE_TIMEOUT, config: Mapping[str, Any] | None = None
    ) -> None:
        self._deadline = time.monotonic() + timeout
        self._config = config
        self._pace, self._forces = Pace(), Forces()
        self._paths: list[str] = []
        self._audience = Audience()
        files = {
            "": ("text/html", _page(title, summarize({"config": config}).grasp_force if config else None)),
            "meshcat.js": ("text/javascript", viewer_script()),
            "live.js": ("text/javascript", own_script(*LIVE_SCRIPTS)),
        }
        sockets = _bind()
        self.url = f"http://{LOOPBACK}:{sockets[0].getsockname()[1]}/"
        self._loop = asyncio.new_event_loop()
        started: Future[HTTPServer] = Future()
        # The thread ends with the process, so even a killed program leaves no server behind.
        self._thread = threading.Thread(target=self._serve, args=(sockets, files, started), daemon=True)
        self._thread.start()
        self._server = started.result()

    def _serve(
        self, sockets: list[socket.socket], files: dict[str, tuple[str, str]], started: Future[HTTPServer]
    ) -> None:
        asyncio.set_event_loop(self._loop)

        async def start() -> None:
            server = HTTPServer(application(LOOPBACK, files, self._audience))
            server.add_sockets(sockets)
            started.set_result(server)

        self._loop.run_until_complete(start())
        self._loop.run_forever()
        self._loop.run_until_complete(self._loop.shutdown_asyncgens())
        self._loop.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def sample(self, sample: Mapping[str, Any]) -> None:
        """Keep the forces of a sample for the next frame."""
        self._forces.add(sample)

    def show(
        self,
        moment: float,
        primitive: str,
        bodies: tuple[Body, ...],
        position: NDArray[np.float64],
        quaternion: NDArray[np.float64],
    ) -> None:
        """Show a frame at its time: sleep until the wall clock has reached the simulated time `moment` [s].

        Frames of a simulation that is slower than real time are shown at once; it does not catch up afterwards.
        """
        if not self._paths:
            self._open(moment, bodies, position, quaternion)
        self._pace.hold(moment)
        factor = self._pace.factor()
        poses = zip(self._paths, position, quaternion, strict=True)
        transforms = [
            {"type": "set_transform", "path": path, "matrix": column_major(p, rotation_matrices(q))}
            for path, p, q in poses
        ]
        state = _text(
            now=f"{moment:.2f} s · {plain(primitive)}",
            forces=self._forces.message(),
            factor=None if factor is None else round(factor, 3),
        )
        self._send(self._audience.frame, pack(transforms), state)
        self._pace.resume(moment)

    def _open(
        self,
        moment: float,
        bodies: tuple[Body, ...],
        position: NDArray[np.float64],
        quaternion: NDArray[np.float64],
    ) -> None:
        """Send the scene, and wait until a page is open."""
        places, turns = (array[None].astype(np.float32) for array in (position, quaternion))
        still = Recording({}, bodies, np.array([moment]), places, turns, np.array([]), {})
        box = {key: value for key, value in view(still).items() if not key.startswith("outer")}
        # The motion is not known yet, so the box gets a margin.
        box["low"], box["high"] = [
            np.add(box[key], side * BOX_MARGIN).tolist() for key, side in (("low", -1), ("high", 1))
        ]
        self._paths = [node_path(index, body) for index, body in enumerate(bodies)]
        roles = [{"path": path, "role": body.role} for path, body in zip(self._paths, bodies, strict=True)]
        self._send(
            self._audience.scene, pack(commands(still)), _text(view=box, tubes=tubes(still, self._paths), bodies=roles)
        )
        self._audience.present.wait(max(0.0, self._deadline - time.monotonic()))

    def finish(self, result: Mapping[str, Any]) -> None:
        """Show the end of the attempt in the words of its page.

        Args:
            result: What `EpisodeResult.as_dict` returns.
        """
        summary = summarize({"config": self._config, **result})
        words = {
            "verdict": summary.verdict,
            "reason": summary.reason,
            "tally": tally(result.get("carried"), summary.success),
            "factor": number(result.get("realtime_factor")),
        }
        self._send(self._audience.verdict, _text(**words, state=STATES[summary.success]))

    def _send(self, method: Any, *messages: bytes | str) -> None:
        """Call a method of the audience in the server's thread."""
        self._loop.call_soon_threadsafe(method, *messages)

    def close(self) -> None:
        """Close the pages' connections and stop the server; the pages keep the last frame."""
        if self._thread.is_alive():

            async def stop() -> None:
                self._server.stop()
                await self._audience.dismiss()
                await self._server.close_all_connections()

            asyncio.run_coroutine_threadsafe(stop(), self._loop).result(10.0)
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join(10.0)


def _bind() -> list[socket.socket]:
    for port in PORTS:
        try:
            return bind_sockets(port, address=LOOPBACK, reuse_port=False)
        except OSError as error:
            last = error
    raise ExportError(f"no port on {LOOPBACK} is free for the live page: {last.strerror}; run without --live")


def _page(title: str, grasp_force: float | None) -> str:
    threshold = None if grasp_force is None else f"{grasp_force:g}"
    return str(
        render("live/live.html", title=title, style=trusted("page/page.css"), grasp_force=threshold, window=WINDOW)
    )


def _text(**content: Any) -> str:
    return json.dumps(content)
