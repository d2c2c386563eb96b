"""The live view: an attempt in the browser while it runs, from a small server on this machine's loopback interface.

The server of meshcat answers on every interface of the machine, so its viewer is served from here instead.
"""

from __future__ import annotations

import asyncio
import json
import socket
import threading
import time
from concurrent.futures import Future
from html import escape
from pathlib import Path
from string import Template
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.recording_parts import Body
from pilegrasp_ctrl.types import rotation_matrices
from pilegrasp_ctrl.viewer.camera import view
from pilegrasp_ctrl.viewer.commands import commands, node_path, pack
from pilegrasp_ctrl.viewer.html import own_script, viewer_script
from pilegrasp_ctrl.viewer.live_server import Audience, application
from pilegrasp_ctrl.viewer.panel import STATES
from pilegrasp_ctrl.viewer.shapes import column_major, tubes

LOOPBACK = "127.0.0.1"
"""Address of the server: only this machine can reach it."""

PORTS = (*range(7000, 7020), 0)
"""Ports that are tried, in this order; 0 means any free port. Meshcat's default port comes first, so that an existing
tunnel still works."""

FIRST_PAGE_TIMEOUT = 20.0
"""Time that the attempt waits for a first open page [s]; chosen."""

BOX_MARGIN = np.array([0.1, 0.1, 0.05])
"""Margin of the framed box around hand and objects at the start, because they will move [m]; chosen."""

_HERE = Path(__file__).parent


class LiveView:
    """The server of one attempt for any number of browsers on this machine; a context manager.

    `episode.run(on_frame=view.show)` shows the attempt. The view slows the simulation down to real time and changes
    nothing else. It starts when the first page is open, or `timeout` [s] after the view was made.

    Attributes:
        url: Address of the page.

    Raises:
        ExportError: No port is free, or meshcat's viewer is missing.
    """

    def __init__(self, title: str, timeout: float = FIRST_PAGE_TIMEOUT) -> None:
        self._deadline = time.monotonic() + timeout
        self._ahead: float | None = None
        self._paths: list[str] = []
        self._audience = Audience()
        files = {
            "": ("text/html", _page(title)),
            "meshcat.js": ("text/javascript", viewer_script()),
            "live.js": ("text/javascript", own_script("scene_view.js", "tubes.js", "live.js")),
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
        behind = time.monotonic() - moment
        self._ahead = behind if self._ahead is None else max(self._ahead, behind)
        time.sleep(self._ahead - behind)
        poses = zip(self._paths, position, quaternion, strict=True)
        transforms = [
            {"type": "set_transform", "path": path, "matrix": column_major(p, rotation_matrices(q))}
            for path, p, q in poses
        ]
        self._send(self._audience.frame, pack(transforms), _text(now=f"{moment:.2f} s · {primitive}"))

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
        box = view(still)
        # The motion is not known yet, so the box gets a margin.
        box["low"], box["high"] = [
            np.add(box[key], side * BOX_MARGIN).tolist() for key, side in (("low", -1), ("high", 1))
        ]
        self._paths = [node_path(index, body) for index, body in enumerate(bodies)]
        self._send(self._audience.scene, pack(commands(still)), _text(view=box, tubes=tubes(still, self._paths)))
        self._audience.present.wait(max(0.0, self._deadline - time.monotonic()))

    def finish(self, verdict: str, reason: str = "", success: bool | None = None) -> None:
        """Show the verdict of the attempt."""
        self._send(self._audience.verdict, _text(verdict=verdict, reason=reason, state=STATES[success]))

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


def _page(title: str) -> str:
    style = (_HERE / "page.css").read_text(encoding="utf-8")
    return Template((_HERE / "live.html").read_text(encoding="utf-8")).substitute(title=escape(title), style=style)


def _text(**content: Any) -> str:
    return json.dumps(content)
