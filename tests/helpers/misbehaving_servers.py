"""Servers on this machine that are no dask scheduler, or a bad one, by name: what they do with a connection."""

from __future__ import annotations

import contextlib
import os
import socket
import ssl
import struct
import threading
import time
from collections.abc import Callable, Iterator

LIFETIME = 60.0
"""How long a server keeps a connection that it does not answer [s] (chosen)."""


def _say_nothing(connection: socket.socket) -> None:
    time.sleep(LIFETIME)


def _close_at_once(connection: socket.socket) -> None:
    connection.close()


def _reset(connection: socket.socket) -> None:
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    connection.close()


def _speak_http(connection: socket.socket) -> None:
    connection.sendall(b"HTTP/1.1 400 Bad Request\r\nContent-Type: text/html\r\nContent-Length: 2\r\n\r\nno")
    time.sleep(LIFETIME)


def _speak_ssh(connection: socket.socket) -> None:
    connection.sendall(b"SSH-2.0-OpenSSH_9.2p1 Debian-2+deb12u3\r\n")
    time.sleep(LIFETIME)


def _speak_noise(connection: socket.socket) -> None:
    connection.sendall(os.urandom(1 << 16))
    time.sleep(LIFETIME)


def _speak_zeros(connection: socket.socket) -> None:
    with contextlib.suppress(OSError):
        while True:
            connection.sendall(bytes(1 << 16))


def _echo(connection: socket.socket) -> None:
    with contextlib.suppress(OSError):
        while data := connection.recv(1 << 16):
            connection.sendall(data)


def _drip(connection: socket.socket) -> None:
    """Announce a short message and send a byte of it every half second."""
    connection.sendall(struct.pack("<Q", 1000))
    with contextlib.suppress(OSError):
        for _ in range(1000):
            time.sleep(0.5)
            connection.sendall(b"\x01")


def _announce_gigabytes(connection: socket.socket) -> None:
    connection.sendall(struct.pack("<Q", 1 << 40))
    time.sleep(LIFETIME)


def _greet_and_fall_silent(connection: socket.socket) -> None:
    """Greet as dask does, and never say anything again."""
    from distributed.protocol import dumps
    from distributed.protocol.utils import pack_frames_prelude

    frames = dumps({"compression": None, "python": (3, 11, 7), "pickle-protocol": 5})
    body = pack_frames_prelude(frames) + b"".join(map(bytes, frames))
    connection.sendall(struct.pack("<Q", len(body)) + body)
    time.sleep(LIFETIME)


def _greet_with_a_list(connection: socket.socket) -> None:
    """Greet with a value of another type than dask expects."""
    from distributed.protocol import dumps
    from distributed.protocol.utils import pack_frames_prelude

    frames = dumps(["no", "greeting"])
    body = pack_frames_prelude(frames) + b"".join(map(bytes, frames))
    connection.sendall(struct.pack("<Q", len(body)) + body)
    time.sleep(LIFETIME)


def _wait_for_tls(connection: socket.socket) -> None:
    """Speak TLS without a certificate: every handshake fails."""
    with contextlib.suppress(OSError):
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).wrap_socket(connection, server_side=True)
    time.sleep(LIFETIME)


SERVERS: dict[str, Callable[[socket.socket], None]] = {
    "says nothing": _say_nothing,
    "closes at once": _close_at_once,
    "resets": _reset,
    "speaks HTTP": _speak_http,
    "speaks SSH": _speak_ssh,
    "sends noise": _speak_noise,
    "sends zeros without end": _speak_zeros,
    "sends back what it gets": _echo,
    "drips": _drip,
    "announces a terabyte": _announce_gigabytes,
    "greets and falls silent": _greet_and_fall_silent,
    "greets with a list": _greet_with_a_list,
    "waits for TLS": _wait_for_tls,
}
"""What a server does with a connection, by name."""

ADDRESSES = (
    "x",
    "",
    " ",
    "tls://",
    "tcp://",
    "tcp://:8786",
    "tcp://127.0.0.1",
    "tcp://127.0.0.1:0",
    "tcp://127.0.0.1:99999",
    "tcp://127.0.0.1:port",
    "tcp://127.0.0.1:8786/path",
    "tcp://user@127.0.0.1:8786",
    "tcp://[::1:8786",
    "tcp://a\x00b:1",
    "tcp://a b:1",
    "tls://127.0.0.1:1",
    "http://127.0.0.1:1",
    "inproc://127.0.0.1/1/1",
    "ucx://127.0.0.1:1",
    "127.0.0.1:1:1",
    "tcp://" + "a" * 300 + ".invalid:1",
    "tcp://" + "a." * 30000 + ":1",
)
"""Texts that are no address of a scheduler."""


@contextlib.contextmanager
def serve(name: str) -> Iterator[int]:
    """Run a server on this machine and yield its port."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(64)

        def accept() -> None:
            with contextlib.suppress(OSError):
                while True:
                    connection, _ = listener.accept()
                    threading.Thread(target=_answer, args=(SERVERS[name], connection), daemon=True).start()

        threading.Thread(target=accept, daemon=True).start()
        yield listener.getsockname()[1]


def _answer(handler: Callable[[socket.socket], None], connection: socket.socket) -> None:
    with contextlib.suppress(OSError), connection:
        handler(connection)
