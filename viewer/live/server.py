"""The live view's server: its answers, and the messages to its pages. All of this runs in the server's thread."""

from __future__ import annotations

import asyncio
import contextlib
import re
import threading
from collections.abc import Mapping
from typing import Any

from tornado.web import Application, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'unsafe-inline'; img-src data: blob:; "
    "connect-src 'self' ws://{host}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Content security policy of the page: its own scripts, and a connection to this server only."""

CLOSE_TIMEOUT = 2.0
"""Longest time to wait until a page has received its last messages [s]; chosen."""


class Audience:
    """The open pages, and the messages that a page must get first if it opens late.

    Attributes:
        present: Event that is set once a page has been open.
    """

    def __init__(self) -> None:
        self.present = threading.Event()
        self._scene: tuple[bytes | str, ...] = ()
        self._frame: tuple[bytes | str, ...] = ()
        self._verdict: tuple[bytes | str, ...] = ()
        self._pending: dict[WebSocketHandler, asyncio.Future[None] | None] = {}

    def enter(self, page: WebSocketHandler) -> None:
        """Send a new page the messages that it missed."""
        self._pending[page] = None
        self._send(page, *self._scene, *self._frame, *self._verdict)
        self.present.set()

    def leave(self, page: WebSocketHandler) -> None:
        """Forget a page."""
        self._pending.pop(page, None)

    def scene(self, *messages: bytes | str) -> None:
        """Send every page the scene."""
        self._scene = messages
        for page in list(self._pending):
            self._send(page, *messages)

    def frame(self, *messages: bytes | str) -> None:
        """Send every page a frame; skip a page that has not received the last one yet."""
        self._frame = messages
        for page, pending in list(self._pending.items()):
            if pending is None or pending.done():
                self._send(page, *messages)

    def verdict(self, *messages: bytes | str) -> None:
        """Send every page the end of the attempt, and the last frame, which a slow page may have missed."""
        self._verdict = messages
        for page in list(self._pending):
            self._send(page, *self._frame, *messages)

    async def dismiss(self) -> None:
        """Close every page's connection after its last message."""
        waiting = [future for future in self._pending.values() if future is not None]
        if waiting:
            await asyncio.wait(waiting, timeout=CLOSE_TIMEOUT)
        for page in list(self._pending):
            page.close()
        self._pending.clear()

    def _send(self, page: WebSocketHandler, *messages: bytes | str) -> None:
        for message in messages:
            try:
                self._pending[page] = asyncio.ensure_future(
                    _quietly(page.write_message(message, binary=isinstance(message, bytes)))
                )
            except WebSocketClosedError:
                return self.leave(page)


async def _quietly(written: Any) -> None:
    """Wait until a message is sent; a page that closed meanwhile is no error."""
    with contextlib.suppress(WebSocketClosedError):
        await written


class FileHandler(RequestHandler):
    """Answers with one of the view's files, which are in memory."""

    def initialize(self, kind: str, content: str) -> None:
        """Take the arguments from the application's table."""
        self._kind, self._content = kind, content

    def get(self) -> None:
        """Send the file under a policy that lets the page reach this server only."""
        self.set_header("Content-Type", f"{self._kind}; charset=utf-8")
        self.set_header("Content-Security-Policy", POLICY.format(host=self.request.host))
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Cache-Control", "no-store")
        self.finish(self._content.encode("utf-8", errors="replace"))


class FramesHandler(WebSocketHandler):
    """The connection of one page; tornado refuses a page of another origin."""

    def initialize(self, audience: Audience) -> None:
        """Take the arguments from the application's table."""
        self._audience = audience

    def open(self, *_: str) -> None:
        """Add the page to the audience."""
        self._audience.enter(self)

    def on_message(self, message: str | bytes) -> None:
        """Ignore the message: pages only listen."""

    def on_close(self) -> None:
        """Remove the page from the audience."""
        self._audience.leave(self)


def application(address: str, files: Mapping[str, tuple[str, str]], audience: Audience) -> Application:
    """Return the answers to requests for `address` or localhost; every other name gets 404.

    A foreign page can let its name resolve to this machine, to reach a local server through the browser (DNS
    rebinding). Its requests get 404.

    Args:
        address: Address on which the server listens.
        files: Content type and content of each file, by path.
        audience: Audience that new pages join.
    """
    answers = Application(log_function=lambda handler: None)
    routes: list[Any] = [
        (f"/{re.escape(path)}", FileHandler, {"kind": kind, "content": content})
        for path, (kind, content) in files.items()
    ]
    routes.append(("/frames", FramesHandler, {"audience": audience}))
    answers.add_handlers(rf"({re.escape(address)}|localhost)", routes)
    return answers
