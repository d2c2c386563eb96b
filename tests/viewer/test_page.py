"""The page as one file: it requests nothing, and hostile content stays text."""

from __future__ import annotations

import base64
import hashlib
import importlib.util
import json
import os
import re
from dataclasses import replace

import numpy as np
import pytest

from page_parts import of_type, still, text_of
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.recording import Recording, Shape
from pilegrasp_ctrl.recording_parts import Contacts
from pilegrasp_ctrl.viewer import page, write_html
from pilegrasp_ctrl.viewer.scene.commands import commands
from synthetic_recording import synthetic

HOSTILE = '</script><script>window.pwned=1</script><img src=x onerror="window.pwned=1">&"\'\ud800'


@pytest.fixture(scope="module")
def attempt():
    return synthetic()


@pytest.fixture(scope="module")
def document(attempt):
    return page(attempt)


@pytest.mark.slow
def test_a_page_of_sixty_bodies_is_small():
    for frames, duration in ((300, 10.0), (600, 20.0)):
        recording = synthetic(objects=25, frames=frames, duration=duration)
        assert len(recording.bodies) >= 60
        assert len(page(recording).encode()) <= 1.2e6


def test_a_page_of_ninety_objects_is_small():
    assert len(page(synthetic(objects=90, frames=300, duration=10.0)).encode()) <= 3e6


@pytest.mark.slow
def test_a_page_of_five_minutes_is_small():
    once = synthetic(objects=18, frames=300)
    cycles = 3
    begins = np.repeat(np.arange(cycles), 300) * (10.0 + 1 / 30)
    recording = replace(
        once,
        contacts=Contacts(
            np.concatenate([[0], np.cumsum(np.tile(np.diff(once.contacts.start), cycles))]),
            *(np.tile(getattr(once.contacts, name), (cycles, 1)) for name in ("bodies", "position", "force")),
        ),
        frame_time=np.tile(once.frame_time, cycles) + begins,
        body_position=np.tile(once.body_position, (cycles, 1, 1)),
        body_quaternion=np.tile(once.body_quaternion, (cycles, 1, 1)),
    )
    short, long = (len(page(shown).encode()) for shown in (once, recording))
    # What a cycle adds, thirty times; the signals are drawn with as many points whatever their length.
    assert short + 29 * (long - short) / (cycles - 1) <= 6e6


def test_the_page_requests_nothing(document):
    addresses = set(re.findall(r"\w+://[^\s\"'`)]+", document))
    # A namespace, and what meshcat's `connect` would open; nobody calls it, and the policy forbids it.
    assert addresses <= {"http://www.w3.org/1999/xhtml", "ws://${location.host}"}
    assert "connect(" not in document.split("<script>")[-1]
    links = re.findall(r"<[^>]+\s(?:src|href|action|data)=[\"']?([^\"'\s>]+)", document.split("<script>")[0])
    assert links == ["data:,"]


def test_the_policy_allows_exactly_the_pages_two_programs(document):
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]+)"', document)
    programs = re.findall(r"<script>(.*?)</script>", document, flags=re.DOTALL)
    hashes = {base64.b64encode(hashlib.sha256(program.encode()).digest()).decode() for program in programs}
    assert len(programs) == 2
    assert set(re.findall(r"'sha256-([^']+)'", policy)) == hashes
    assert "default-src 'none'" in policy
    assert "unsafe-eval" not in policy
    assert "script-src 'unsafe-inline'" not in policy


def test_the_page_carries_the_licence_of_what_it_bundles(document):
    assert "Robin Deits" in document
    assert "Three.js Authors" in document


def test_equal_recordings_give_equal_pages(attempt, document, tmp_path):
    attempt.save(tmp_path / "a.npz")
    assert page(Recording.load(tmp_path / "a.npz")) == document


GARBLED = {
    "scenario": HOSTILE,
    "seed": HOSTILE,
    "config_hash": {"a": HOSTILE},
    "config": {HOSTILE: HOSTILE, "strategy": [1, 2], "hand": HOSTILE, "pile": {"object": HOSTILE, "count": True}},
    "success": "yes",
    "grasped": "many",
    "reason": HOSTILE * 20,
    "hand": 3,
    "grasp_force": "seventeen",
    "outcomes": [
        {"name": HOSTILE, "status": "failed", "trigger": HOSTILE, "start": 0.0, "end": 1.0, "travel": "x"},
        {"name": "push", "start": "now", "end": 2},
        {"name": "late", "start": 5, "end": 1},
        {"name": "long", "start": -1e300, "end": 1e300, "peak_force": 10**400},
        HOSTILE,
        None,
    ],
    "versions": {HOSTILE: HOSTILE},
}


def test_hostile_meta_and_names_stay_text():
    plain = synthetic(frames=5)
    names = [HOSTILE, "__proto__", "constructor", "../..", "a/b/c", *(f"b{k}" for k in range(len(plain.bodies) - 5))]
    bodies = tuple(replace(body, name=name) for body, name in zip(plain.bodies, names, strict=True))
    document = page(replace(plain, meta=GARBLED, bodies=bodies))
    start = document.split("<script>")[0]
    assert "<img" not in start
    assert document.count("</script>") == 6
    assert "&lt;img src=x" in start
    json.loads(re.search(r'id="page-data">(.*?)</script>', document, flags=re.DOTALL)[1])
    paths = [c["path"] for c in of_type(commands(replace(plain, bodies=bodies)), "set_transform")]
    assert len(set(paths)) == len(paths)
    assert all(re.fullmatch(r"/[A-Z][a-z]+/\d+ [\w-]+", path) for path in paths)


@pytest.mark.parametrize(
    "meta", [{}, {"outcomes": "none", "config": [], "versions": 3}, {"success": None, "seed": 0, "reason": None}]
)
def test_a_recording_without_its_meta_is_still_a_page(meta):
    recording = still([Shape("plane", (0.0, 0.0))], role="support", meta=meta)
    words = text_of(page(recording))
    assert "Recorded" in words
    assert "No primitives were recorded." in words


def test_a_recording_of_one_frame_and_of_huge_numbers_is_a_page():
    one = still([], frames=1)
    assert not of_type(commands(one), "set_animation")
    assert "<html" in page(one)
    huge = still([Shape("box", (1e30, 1e30, 1e-30))], position=(1e38, -1e38, 0.0), signal_time=[0.0, 1e7])
    huge = replace(huge, signals={"push_force": [-3e38, 3e38], "wrench": np.full((2, 6), 1e38), "q": np.zeros((2, 0))})
    assert "<html" in page(huge)


@pytest.mark.slow
def test_the_file_is_written_whole_or_not_at_all(attempt, document, tmp_path, monkeypatch):
    path = tmp_path / "a.html"
    write_html(attempt, path)
    assert path.read_text(encoding="utf-8") == document
    with pytest.raises(ExportError, match="the page cannot be written to"):
        write_html(attempt, tmp_path / "missing" / "a.html")

    def refuse(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(ExportError, match=r"the page cannot be written to .*a\.html.*no space left"):
        write_html(synthetic(frames=2), path)
    assert path.read_text(encoding="utf-8") == document
    assert os.listdir(tmp_path) == ["a.html"]


def test_a_missing_viewer_is_one_sentence(attempt, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ExportError, match="pip install meshcat"):
        page(attempt)
