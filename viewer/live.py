"""An attempt in the browser while it runs: a small server on this machine's loopback interface, and nowhere else.

meshcat's own server answers on every interface of the machine, so its viewer is served from here instead.
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
from pilegrasp_ctrl.viewer.shapes import column_major, tubes

LOOPBACK = "127.0.0.1"

PORTS = (*range(7000, 7020), 0)
"""Tried in this order; meshcat's usual port comes first, so that a tunnel to it can be set up once. 0 is any."""

PATIENCE = 20.0
"""So long the attempt waits for somebody to open the page [s]."""

ROOM = np.array([0.1, 0.1, 0.05])
"""By so much the picture's box goes beyond hand and objects as they are at the start, to each side [m]."""

_HERE = Path(__file__).parent


class LiveView:
    """Serves one attempt to any number of browsers on this machine; a context manager that leaves nothing running.

    Its method `show` is what `episode.run(on_frame=...)` calls. It holds the simulation back to real time, starts when
    the first page is open or `patience` [s] have passed since the view was made, and takes nothing but time from it.

    Attributes:
        url: of the page.

    Raises:
        ExportError: where no port is free or meshcat's viewer is missing.
    """

    def __init__(self, title: str, patience: float = PATIENCE) -> None:
        self._deadline = time.monotonic() + patience
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
        # It shares the process, so no end of this program, however violent, leaves a server behind.
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
        """Show a frame at its time: sleep until the wall clock has come as far as the simulation, `moment` [s].

        Where the simulation is the slower one, it is shown as it comes; it does not catch up afterwards.
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
        self._tell(self._audience.frame, pack(transforms), _text(now=f"{moment:.2f} s · {primitive}"))

    def _open(
        self,
        moment: float,
        bodies: tuple[Body, ...],
        position: NDArray[np.float64],
        quaternion: NDArray[np.float64],
    ) -> None:
        """Send the scene, and wait for somebody to see it."""
        places, turns = (array[None].astype(np.float32) for array in (position, quaternion))
        still = Recording({}, bodies, np.array([moment]), places, turns, np.array([]), {})
        box = view(still)
        # Where hand and objects will go is not known yet.
        box["low"], box["high"] = [np.add(box[key], side * ROOM).tolist() for key, side in (("low", -1), ("high", 1))]
        self._paths = [node_path(index, body) for index, body in enumerate(bodies)]
        self._tell(self._audience.scene, pack(commands(still)), _text(view=box, tubes=tubes(still, self._paths)))
        self._audience.present.wait(max(0.0, self._deadline - time.monotonic()))

    def finish(self, verdict: str, reason: str = "", success: bool | None = None) -> None:
        """Show how the attempt ended."""
        state = {True: "success", False: "failure", None: "unknown"}[success]
        self._tell(self._audience.verdict, _text(verdict=verdict, reason=reason, state=state))

    def _tell(self, method: Any, *messages: bytes | str) -> None:
        self._loop.call_soon_threadsafe(method, *messages)

    def close(self) -> None:
        """Say goodbye to the pages and stop the server; the pages keep the last frame."""
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
