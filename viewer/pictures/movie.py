"""Movies of an attempt at any speed: GIF by Pillow, MP4 by the program ffmpeg, if it is found."""

from __future__ import annotations

import importlib
import io
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO, cast

import numpy as np

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import whole_file, write_whole
from pilegrasp_ctrl.interruption import signals_wait
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.page.summary import summarize
from pilegrasp_ctrl.viewer.pictures.contact_sheet import ink, title
from pilegrasp_ctrl.viewer.pictures.stills import Progress, Stills

GIF_RATE = 12.5
"""Frames per second of a GIF, whose frames last whole hundredths of a second."""

GIF_SIZE = (640, 430)
"""Width and height of a GIF [px]; chosen."""

MP4_RATE = 15.0
"""Frames per second of an MP4; chosen."""

MP4_SIZE = (960, 630)
"""Width and height of an MP4 [px]; chosen, and even, because the encoder requires it."""

HOLD = 1.5
"""Time for which the last frame, with the verdict, is shown [s]; chosen."""

MAX_FRAMES = 3000
"""Largest number of frames in a movie; chosen."""

MIN_SPEED, MAX_SPEED = 0.01, 100.0
"""Range of a movie's speed, in times real time; chosen."""

PALETTE_FRAMES = 6
"""Number of frames from which the palette of a GIF is computed; chosen. All frames share it, so that colours do not
flicker."""

RARE_COLORS = ("#d62728", "#14733b", "#a11a12")
"""The arrow's red and the verdict's green and red: they cover few pixels, so a palette by frequency would lose them."""

SWATCH_HEIGHT = 24
"""Height of the stripe of each rare colour in the picture from which the palette is computed [px]; chosen."""


def frame_times(recording: Recording, fps: float, speed: float) -> tuple[float, ...]:
    """Return the moments [s] that a movie shows: from the first frame on every `speed / fps`, and the last frame.

    Raises:
        ExportError: The speed is out of range, or the movie would be longer than `MAX_FRAMES`.
    """
    if not MIN_SPEED <= speed <= MAX_SPEED:
        raise ExportError(f"a speed of {speed:g} is out of range; give {MIN_SPEED:g} to {MAX_SPEED:g}, 1 is real time")
    first, last = float(recording.frame_time[0]), float(recording.frame_time[-1])
    step = speed / fps
    count = int((last - first) / step + 1e-6) + 1
    if count > MAX_FRAMES:
        fitting = speed * count / MAX_FRAMES
        raise ExportError(
            f"{last - first:.0f} s at {speed:g} times real time are {count} pictures, more than {MAX_FRAMES}; "
            f"give a speed of {fitting:.2g} or more"
        )
    times = [first + k * step for k in range(count)]
    # The last frame is always shown; a frame just before it would stutter.
    if count > 1 and last - times[-1] < 0.5 * step:
        times.pop()
    return (*times, last) if last > first else (first,)


def _frames(
    stills: Stills, recording: Recording, times: tuple[float, ...], speed: float, progress: Progress | None
) -> Iterator[bytes]:
    summary = summarize(recording.meta)
    note = title(summary) + ("" if speed == 1.0 else f", {speed:g}×")
    for index, time in enumerate(times):
        last = index == len(times) - 1
        yield stills.frame(time, summary.verdict, ink(summary.success)) if last else stills.frame(time, note)
        if progress:
            progress(index + 1, len(times))


def write_gif(
    recording: Recording, path: str | os.PathLike[str], speed: float = 1.0, progress: Progress | None = None
) -> None:
    """Write an animated GIF, all of it or nothing; it repeats for ever.

    Raises:
        ExportError: No Chromium or no Pillow is found, the speed does not fit, or the place cannot be written.
    """
    try:
        from PIL import Image
    except ImportError:
        raise ExportError("a .gif is written by Pillow, which was not found; `pip install pillow`") from None

    times = frame_times(recording, GIF_RATE, speed)
    with Stills(recording) as stills:
        stills.open_movie(*GIF_SIZE)

        def picture(png: bytes) -> Image.Image:
            return Image.open(io.BytesIO(png)).convert("RGB")

        chosen = sorted({times[k] for k in np.linspace(0, len(times) - 1, PALETTE_FRAMES).astype(int)})
        samples = Image.new("RGB", (GIF_SIZE[0], GIF_SIZE[1] * len(chosen) + SWATCH_HEIGHT * len(RARE_COLORS)))
        for row, time in enumerate(chosen):
            samples.paste(picture(stills.frame(time)), (0, row * GIF_SIZE[1]))
        for row, color in enumerate(RARE_COLORS):
            top = GIF_SIZE[1] * len(chosen) + SWATCH_HEIGHT * row
            samples.paste(color, (0, top, GIF_SIZE[0], top + SWATCH_HEIGHT))
        palette = samples.quantize(256, Image.Quantize.MEDIANCUT)
        images = [
            picture(frame).quantize(palette=palette, dither=Image.Dither.NONE)
            for frame in _frames(stills, recording, times, speed, progress)
        ]
    content = io.BytesIO()
    durations = [round(1000 / GIF_RATE)] * (len(images) - 1) + [round(1000 * HOLD)]
    images[0].save(
        content, "GIF", save_all=True, append_images=images[1:], duration=durations, loop=0, optimize=False, disposal=1
    )
    try:
        write_whole(Path(path), content.getvalue())
    except (OSError, ValueError) as error:
        raise ExportError(f"the movie cannot be written to {str(path)!r}: {error}") from error


def write_mp4(
    recording: Recording, path: str | os.PathLike[str], speed: float = 1.0, progress: Progress | None = None
) -> None:
    """Write an MP4, all of it or nothing.

    Raises:
        ExportError: No Chromium or no ffmpeg is found, one of them fails, the speed does not fit, or the place cannot
            be written.
    """
    executable = require_ffmpeg()
    times = frame_times(recording, MP4_RATE, speed)
    with Stills(recording) as stills:
        stills.open_movie(*MP4_SIZE)

        def frames() -> Iterator[bytes]:
            picture = b""
            for picture in _frames(stills, recording, times, speed, progress):
                yield picture
            yield from [picture] * round(HOLD * MP4_RATE)

        encode_mp4(executable, frames(), MP4_RATE, Path(path))


def require_ffmpeg() -> str:
    """Return the path of ffmpeg: on the PATH, or in the Python package imageio-ffmpeg.

    Raises:
        ExportError: Neither is found.
    """
    found = shutil.which("ffmpeg")
    if found:
        return found
    try:
        return str(importlib.import_module("imageio_ffmpeg").get_ffmpeg_exe())
    # imageio-ffmpeg raises RuntimeError if its package holds no program for this machine.
    except (ImportError, RuntimeError):
        raise ExportError(
            "an .mp4 is encoded by ffmpeg, which was not found; install it (on Debian `apt-get install ffmpeg`), "
            "or `pip install imageio-ffmpeg`; a .gif works without"
        ) from None


def encode_mp4(executable: str, pictures: Iterable[bytes], fps: float, path: Path) -> None:
    """Write PNG pictures of one even size as MP4, all of it or nothing.

    The program chooses the encoder: H.264 if it was built with one. Colours are 4:2:0, because many players show
    nothing else. The index comes first, so that a browser can play before the download ends.

    Raises:
        ExportError: The program fails, or the place cannot be written.
    """
    command = [executable, "-hide_banner", "-loglevel", "error", "-nostdin", "-y"]
    command += ["-f", "image2pipe", "-framerate", f"{fps:g}", "-c:v", "png", "-i", "pipe:0"]
    command += ["-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4"]
    try:
        with whole_file(path) as beside, tempfile.TemporaryFile() as messages:
            _feed([*command, f"file:{beside}"], pictures, messages)
    except (OSError, ValueError) as error:
        raise ExportError(f"the movie cannot be written to {str(path)!r}: {error}") from error


def _feed(command: list[str], pictures: Iterable[bytes], messages: IO[bytes]) -> None:
    """Run ffmpeg on the pictures; its error messages go to `messages`."""
    # An interrupt from the keyboard reaches this program only, which then ends ffmpeg in order.
    process: subprocess.Popen[bytes] | None = None
    try:
        with signals_wait():
            process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=messages, start_new_session=True
            )
        pipe = cast(IO[bytes], process.stdin)
        try:
            for picture in pictures:
                pipe.write(picture)
            pipe.close()
        except BrokenPipeError:
            # The program has ended; its status and its messages give the reason.
            pass
        status = process.wait()
    finally:
        # The program must have ended before its file is removed.
        with signals_wait():
            if process is not None:
                process.kill()
                process.wait()
    if status:
        messages.seek(0)
        lines = messages.read().decode(errors="replace").split("\n")
        last = next((line.strip() for line in reversed(lines) if line.strip()), f"status {status}")
        raise ExportError(f"ffmpeg ({command[0]}) failed: {last}; a .gif works without it")
