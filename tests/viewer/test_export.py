"""Contact sheets and movies of a recording: which moments they show, and how."""

from __future__ import annotations

import os
import shutil
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from browser import program
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.viewer import write
from pilegrasp_ctrl.viewer.pictures.contact_sheet import MAX_TILES, USUAL_TILES, moments
from pilegrasp_ctrl.viewer.pictures.movie import GIF_RATE, HOLD, MAX_FRAMES, frame_times
from pilegrasp_ctrl.viewer.pictures.stills import Stills
from synthetic_recording import PHASES, synthetic

HOSTILE = '</script><script>window.pwned=1</script><img src="x" onerror="window.pwned=1">${pwned=1}`'


SPEED = 20.0


# Counts the pictures that reach it, in place of a movie; the last argument is the file.
COUNTING_FFMPEG = """#!/bin/sh
for last; do :; done
grep -a -o PNG | wc -l > "${last#file:}"
"""


@pytest.fixture(scope="module")
def attempt():
    return synthetic(frames=60, objects=6)


def pixels(image):
    return np.asarray(image.convert("RGB")).astype(float)


def test_the_sheet_holds_start_and_end_of_each_primitive(attempt):
    shown = moments(attempt)
    assert len(shown) == USUAL_TILES
    times = [moment.time for moment in shown]
    assert times == sorted(times)
    assert (times[0], times[-1]) == (0.0, 10.0)
    words = {moment.time: moment.words for moment in shown}
    assert words[0.0] == ("approach begins",)
    assert words[2.2] == ("approach ends: touch force", "push begins")
    assert words[10.0] == ("lift ends: lifted",)
    for name, start, end in PHASES:
        assert {start, end} <= words.keys()
        between = [words[t] for t in times if start < t < end]
        assert all(texts == (name,) for texts in between)


def test_a_loss_has_a_tile(attempt):
    # The first ball falls from the hand at 9 s.
    ball = next(k for k, body in enumerate(attempt.bodies) if body.name == "light_sphere_00")
    position = np.array(attempt.body_position)
    late = attempt.frame_time > 9.0
    position[late, ball] = position[0, ball]
    (tile,) = (moment for moment in moments(replace(attempt, body_position=position)) if "lost" in str(moment.words))
    assert tile.words == ("lost light sphere 00",)
    assert tile.failed
    assert tile.time == pytest.approx(9.0, abs=0.05)


def test_a_failure_is_marked():
    shown = moments(synthetic(success=False, frames=30))
    assert shown[-1].failed
    assert shown[-1].words == ("push failed: travel limit of 0.36 m",)
    assert not any(moment.failed for moment in shown[:-1])


@pytest.mark.parametrize("frames", [1, 2])
def test_a_recording_of_few_frames_has_a_sheet(frames):
    plain = synthetic(frames=2, outcomes=[])
    last = slice(0, frames)
    short = replace(
        plain,
        contacts=None,
        frame_time=plain.frame_time[last],
        body_position=plain.body_position[last],
        body_quaternion=plain.body_quaternion[last],
    )
    assert len(moments(short)) == (1 if frames == 1 else USUAL_TILES)
    assert len(frame_times(short, 10.0, 1.0)) == (1 if frames == 1 else 101)


def test_primitives_without_end_or_out_of_time_add_no_tiles():
    rows = [{"name": f"p{k}", "status": "ended", "start": 0.1 * k, "end": 0.1 * k + 0.1} for k in range(90)]
    rows.append({"name": "late", "status": "ended", "start": 50.0, "end": 60.0})
    shown = moments(synthetic(frames=30, outcomes=rows))
    assert len(shown) == MAX_TILES
    assert shown[-1].time == 10.0
    assert not any("late" in word for moment in shown for word in moment.words)


@pytest.mark.parametrize("speed", [0.3, 1.0, 7.0, 100.0])
def test_a_movie_runs_from_the_first_frame_to_the_last(attempt, speed):
    times = frame_times(attempt, 12.5, speed)
    assert (times[0], times[-1]) == (0.0, 10.0)
    gaps = [b - a for a, b in pairwise(times)]
    step = speed / 12.5
    assert all(gap == pytest.approx(step) for gap in gaps[:-1])
    assert 0.0 < gaps[-1] < 1.5 * step + 1e-9


def test_a_movie_that_would_not_end_is_refused():
    with pytest.raises(ExportError, match=f"more than {MAX_FRAMES}; give a speed of 1"):
        frame_times(synthetic(frames=2, duration=2500.0), 15.0, 1.0)


@pytest.mark.slow
@pytest.mark.browser
def test_a_contact_sheet_shows_every_moment(chromium, attempt, tmp_path):
    seen = []
    write(attempt, tmp_path / "a.png", progress=lambda done, total: seen.append((done, total)))
    assert seen == [(k, USUAL_TILES) for k in range(1, USUAL_TILES + 1)]
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]
    sheet = Image.open(tmp_path / "a.png")
    width, height, top, gap, text = 480, 300, 84, 14, 46
    assert sheet.size == (gap + 3 * (width + gap), top + 3 * (height + text + gap))
    tiles, captions = [], []
    for row in range(3):
        for column in range(3):
            x, y = gap + column * (width + gap), top + row * (height + text + gap)
            tiles.append(pixels(sheet.crop((x, y, x + width, y + height))))
            captions.append(pixels(sheet.crop((x, y + height, x + width, y + height + text))))
    for tile, caption in zip(tiles, captions, strict=True):
        # A scene has hundreds of colours; the sky alone has a few dozen greys.
        assert len(np.unique(tile.reshape(-1, 3), axis=0)) > 300
        assert tile.std(axis=(0, 1)).min() > 10.0
        assert caption.min() < 80.0 < 240.0 < caption.max()
    for one, two in pairwise(tiles):
        assert np.abs(one - two).max() > 100.0
    head = pixels(sheet.crop((0, 0, 8, 60)))
    assert np.ptp(head, axis=(0, 1)).max() == 0.0
    red, green, _ = head[0, 0]
    assert green > red


@pytest.mark.slow
@pytest.mark.browser
def test_a_gif_moves_and_ends_on_the_verdict(chromium, attempt, tmp_path):
    write(attempt, tmp_path / "a.gif", speed=SPEED)
    assert [path.name for path in tmp_path.iterdir()] == ["a.gif"]
    movie = Image.open(tmp_path / "a.gif")
    times = frame_times(attempt, GIF_RATE, SPEED)
    assert movie.n_frames == len(times)
    frames, durations = [], []
    for index in range(movie.n_frames):
        movie.seek(index)
        frames.append(pixels(movie))
        durations.append(movie.info["duration"])
    assert durations == [1000 / GIF_RATE] * (len(times) - 1) + [1000 * HOLD]
    assert movie.info["loop"] == 0
    for one, two in pairwise(frames):
        assert np.abs(one - two)[:-30].max() > 100.0
    # The verdict's green appears in the last caption and in no other.
    green = [int(((f[-30:, :, 1] > f[-30:, :, 0] + 40) & (f[-30:, :, 1] > f[-30:, :, 2] + 40)).sum()) for f in frames]
    assert green[-1] > 50
    assert max(green[:-1]) == 0


@pytest.mark.slow
@pytest.mark.browser
def test_a_still_depends_on_its_moment_only(chromium, attempt):
    with Stills(attempt) as stills:
        stills.open_movie(320, 230)
        first = stills.frame(5.0)
        assert stills.frame(2.0) != first
        assert stills.frame(5.0) == first


@pytest.mark.slow
@pytest.mark.browser
def test_hostile_names_are_drawn_and_run_nothing(chromium, tmp_path):
    plain = synthetic(frames=10, objects=2)
    names = [HOSTILE, "__proto__", *(f"b{k}" for k in range(len(plain.bodies) - 2))]
    bodies = tuple(replace(body, name=name) for body, name in zip(plain.bodies, names, strict=True))
    rows = [{"name": HOSTILE, "status": "failed", "trigger": "\u202e\ud800\u2028" + HOSTILE, "start": 0.0, "end": 6.0}]
    meta = {"scenario": HOSTILE, "seed": HOSTILE, "reason": HOSTILE, "outcomes": rows, "success": False}
    hostile = replace(plain, meta=meta, bodies=bodies)
    shown = moments(hostile)
    with Stills(hostile) as stills:
        stills.open_sheet(2, {"title": HOSTILE, "verdict": HOSTILE, "reason": HOSTILE, "ink": "bad"})
        stills.add_tile(0, replace(shown[0], failed=True))
        assert len(stills.sheet()) > 1000
        stills.open_movie(320, 230)
        assert len(stills.frame(1.0, HOSTILE)) > 1000
        assert stills._browser.evaluate("typeof window.pwned") == "undefined"
        assert stills._browser.evaluate("document.images.length") == 0


@pytest.mark.slow
@pytest.mark.browser
def test_an_mp4_gets_every_frame_and_holds_the_last(chromium, attempt, tmp_path, monkeypatch):
    tools = tmp_path / "tools"
    tools.mkdir()
    program(tools, "ffmpeg", COUNTING_FFMPEG)
    monkeypatch.setenv("PATH", f"{tools}{os.pathsep}{os.environ['PATH']}")
    folder = tmp_path / "out"
    folder.mkdir()
    write(attempt, folder / "a.mp4", speed=40.0)
    expected = len(frame_times(attempt, 15.0, 40.0)) + round(15.0 * HOLD)
    assert int((folder / "a.mp4").read_text()) == expected
    assert [path.name for path in folder.iterdir()] == ["a.mp4"]


@pytest.mark.browser
@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_a_real_mp4_is_one(chromium, attempt, tmp_path):
    write(attempt, tmp_path / "a.mp4", speed=40.0)
    assert (tmp_path / "a.mp4").read_bytes()[4:8] == b"ftyp"
