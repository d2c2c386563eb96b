"""Write the movie of the README: a grasp with its force curve.

Usage: python docs/studies/readme_gif.py RECORDING.npz MOVIE.gif OUT.gif, after `pilegrasp export`
"""

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageSequence

from pilegrasp_ctrl.recording import Recording
from script import run_script

SIZE, CURVE = (480, 322), 78
"""Size of a picture and height of the curve below it [px]; chosen for a README."""
EVERY = 3
"""Pictures of the movie for each one that is kept."""
COLOURS = 64
"""Colours of the palette."""
BLOCK = 4
"""Samples for each point of the curve."""
PERIOD = 240
"""Time for which a picture stays [ms]: three pictures of 80 ms."""
INK, CURVE_INK, LIMIT_INK = (70, 70, 70), (214, 39, 40), (120, 120, 120)
"""Colours of text, curve and F_grasp."""


def main(recording: Path, movie: Path, out: Path) -> None:
    """Add the force against the push, and F_grasp, to every third picture."""
    attempt = Recording.load(recording)
    time, force = attempt.signal_time, attempt.signals["push_force"].astype(float)
    limit = float(attempt.meta["grasp_force"])
    pictures = [frame.convert("RGB") for frame in ImageSequence.Iterator(Image.open(movie))][::EVERY]
    begin, end = attempt.frame_time[0], attempt.frame_time[-1]
    drawn = [
        _with_curve(picture, time - begin, force, limit, (end - begin) * (k + 1) / len(pictures), end - begin)
        for k, picture in enumerate(pictures)
    ]
    palette = drawn[len(drawn) // 2].quantize(COLOURS)
    first, *rest = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in drawn]
    stay = [PERIOD] * len(rest) + [1500]
    first.save(out, save_all=True, append_images=rest, duration=stay, loop=0, optimize=True)
    print(f"{out}: {out.stat().st_size / 1e6:.2f} MB")


def _with_curve(
    picture: Image.Image, time: np.ndarray, force: np.ndarray, limit: float, now: float, span: float
) -> Image.Image:
    canvas = Image.new("RGB", (SIZE[0], SIZE[1] + CURVE), "white")
    canvas.paste(picture.resize(SIZE, Image.Resampling.LANCZOS))
    pen, top = ImageDraw.Draw(canvas), max(force.max(), limit) * 1.1

    def at(moment: float, value: float) -> tuple[float, float]:
        return 8 + (SIZE[0] - 16) * moment / span, SIZE[1] + CURVE - 6 - (CURVE - 22) * max(value, 0.0) / top

    pen.text((8, SIZE[1] + 2), "force against the push [N]", fill=INK)
    level = at(0.0, limit)[1]
    pen.line([(8, level), (SIZE[0] - 8, level)], fill=LIMIT_INK)
    pen.text((SIZE[0] - 92, level - 12), f"F_grasp {limit:g} N", fill=INK)
    # The largest force of each block stays, so that the curve shows where it reaches F_grasp.
    blocks = np.array_split(np.flatnonzero(time <= now), max(1, int((time <= now).sum()) // BLOCK))
    points = [at(time[block[-1]], force[block].max()) for block in blocks if len(block)]
    if len(points) > 1:
        pen.line(points, fill=CURVE_INK, width=2)
    return canvas


if __name__ == "__main__":
    run_script(main)
