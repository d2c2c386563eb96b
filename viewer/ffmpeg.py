"""Pictures to MP4 by the program ffmpeg, which is found or not; nothing else of this library needs it."""

from __future__ import annotations

import importlib
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import IO

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import whole_file


def require_ffmpeg() -> str:
    """Return the path of the program: on the PATH, or the one that the Python package imageio-ffmpeg carries.

    Raises:
        ExportError: where there is neither.
    """
    found = shutil.which("ffmpeg")
    if found:
        return found
    try:
        return str(importlib.import_module("imageio_ffmpeg").get_ffmpeg_exe())
    # imageio-ffmpeg raises RuntimeError where its package holds no program for this machine.
    except (ImportError, RuntimeError):
        raise ExportError(
            "an .mp4 is encoded by ffmpeg, which was not found; install it (on Debian `apt-get install ffmpeg`), "
            "or `pip install imageio-ffmpeg`; a .gif works without"
        ) from None


def encode_mp4(executable: str, pictures: Iterable[bytes], fps: float, path: Path) -> None:
    """Write PNG pictures of one even size as MP4, all of it or nothing.

    Which encoder is taken is left to the program: H.264 where it was built with one. Colours are 4:2:0, as many players
    show nothing else, and the index comes first, so that a browser plays before it has all.

    Raises:
        ExportError: where the program fails or the place cannot be written.
    """
    command = [executable, "-hide_banner", "-loglevel", "error", "-nostdin", "-y"]
    command += ["-f", "image2pipe", "-framerate", f"{fps:g}", "-c:v", "png", "-i", "pipe:0"]
    command += ["-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4"]
    try:
        with whole_file(path) as beside, tempfile.TemporaryFile() as complaints:
            _feed([*command, f"file:{beside}"], pictures, complaints)
    except (OSError, ValueError) as error:
        raise ExportError(f"the movie cannot be written to {str(path)!r}: {error}") from error


def _feed(command: list[str], pictures: Iterable[bytes], complaints: IO[bytes]) -> None:
    # An interrupt from the keyboard is this program's; it then ends ffmpeg in order.
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=complaints, start_new_session=True
    )
    assert process.stdin is not None
    try:
        try:
            for picture in pictures:
                process.stdin.write(picture)
            process.stdin.close()
        except BrokenPipeError:
            # The program has ended; its status and its words tell why.
            pass
        status = process.wait()
    finally:
        process.kill()
        process.wait()
    if status:
        complaints.seek(0)
        words = complaints.read().decode(errors="replace").split("\n")
        last = next((line.strip() for line in reversed(words) if line.strip()), f"status {status}")
        raise ExportError(f"ffmpeg ({command[0]}) failed: {last}; a .gif works without it")
