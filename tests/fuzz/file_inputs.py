"""Robots, recordings, studies and caches as inputs: good ones, made once, and then damaged."""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import sqlite3
import tempfile
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

from pilegrasp_ctrl.robots import path as robot_path
from question import SPECIAL, Question
from synthetic_recording import synthetic
from values import FUNCTIONS, MINE, damaged, noise, numbers, texts, toml, values

ROBOT_FILES = ("robot.toml", "wam7.urdf", "wam7.xml")
"""Files of an arm's folder."""


@cache
def robot_files() -> dict[str, bytes]:
    """Return the files of a shipped arm."""
    return {name: robot_path("wam7", name).read_bytes() for name in ROBOT_FILES}


@st.composite
def changed_xml(draw: Callable[..., Any], content: bytes) -> bytes:
    """An XML with some attribute's value changed, or an element cut out, or damaged bytes."""
    if draw(st.integers(0, 3)) == 0:
        return draw(damaged(content))
    parts = content.split(b'"')
    for _ in range(draw(st.integers(1, 3))):
        place = 2 * draw(st.integers(0, (len(parts) - 2) // 2)) + 1
        value = st.one_of(numbers().map(repr), texts(12), st.just("0 0 0"), st.just("1e400"), st.just("nan nan nan"))
        parts[place] = draw(value).encode("utf-8", "replace").replace(b'"', b"'").replace(b"<", b"")
    return b'"'.join(parts)


@st.composite
def robots(draw: Callable[..., Any]) -> Question:
    """The folder of an arm, a URDF or an MJCF, to load."""
    files: dict[str, bytes | str] = {f"arm/{name}": content for name, content in robot_files().items()}
    call = draw(st.sampled_from((("@arm", "arm"), ("@urdf", "arm/wam7.urdf"), ("@mjcf", "arm/wam7.xml"))))
    name = {"@arm": "robot.toml", "@urdf": "wam7.urdf", "@mjcf": "wam7.xml"}[call[0]]
    if call[0] == "@arm" and draw(st.booleans()):
        name = "wam7.urdf"
    content = robot_files()[name]
    changed = damaged(content) if name == "robot.toml" else changed_xml(content)
    files[f"arm/{name}"] = draw(st.one_of(changed, changed, changed, noise(), st.sampled_from(SPECIAL)))
    return Question("robot", call, files)


HAND_FILES = ("robot.toml", "parallel_gripper.xml")
"""Files of a hand's folder."""


@st.composite
def hands(draw: Callable[..., Any]) -> Question:
    """The folder of a hand, to load and compile."""
    files = {name: robot_path("hands", "parallel_gripper", name).read_bytes() for name in HAND_FILES}
    if draw(st.integers(0, 4)) == 0:
        function = draw(st.sampled_from(FUNCTIONS))
        text = re.sub(r"(?m)^builder = .*$", lambda _: f"builder = {toml(function)}", _built_hand(), count=1)
        return Question("hand", ("@hand", "hand"), {"hand/robot.toml": text.encode(), "hand/mine.py": MINE})
    name = draw(st.sampled_from(HAND_FILES))
    changed = st.one_of(damaged(files[name]), changed_xml(files[name]))
    if name.endswith(".xml"):
        changed = st.one_of(changed, st.sampled_from(_LEADING_OUTSIDE).map(lambda path: _with_mesh(files[name], path)))
    content = draw(st.one_of(changed, changed, noise(), st.sampled_from(SPECIAL)))
    return Question(
        "hand", ("@hand", "hand"), {f"hand/{other}": files[other] for other in files} | {f"hand/{name}": content}
    )


def _built_hand() -> str:
    """Return the text of a hand that a function builds."""
    return robot_path("hands", "shovel", "robot.toml").read_text(encoding="utf-8")


_LEADING_OUTSIDE = (b"../a.stl", b"/etc/passwd", b"", b"a\x00.stl", b"./" * 3000 + b"a.stl")


def _with_mesh(model: bytes, path: bytes) -> bytes:
    """Return an MJCF that names a mesh, too."""
    return model.replace(b"<worldbody>", b'<asset><mesh name="m" file="' + path + b'"/></asset><worldbody>', 1)


@cache
def recording_bytes() -> bytes:
    """Return a short recording."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.npz"
        synthetic(frames=8, objects=3, duration=0.3).save(path)
        return path.read_bytes()


@st.composite
def changed_recording(draw: Callable[..., Any]) -> bytes:
    """A recording whose archive is whole, and whose arrays or header hold something else."""
    with np.load(io.BytesIO(recording_bytes())) as archive:
        arrays = {name: archive[name] for name in archive.files}
    for _ in range(draw(st.integers(1, 2))):
        name = draw(st.sampled_from(sorted(arrays)))
        array = arrays[name]
        match draw(st.sampled_from(("header", "value", "shape", "type", "cut", "new"))):
            case "header":
                header = json.loads(str(arrays["header"])) if "header" in arrays else {}
                arrays["header"] = np.array(json.dumps(draw(changed_json(header)), default=str))
            case "value" if array.size and array.dtype.kind == "f":
                array = array.copy()
                value = draw(st.sampled_from((np.nan, np.inf, -1.0, 1e30, 0.0)))
                array.reshape(-1)[draw(st.integers(0, array.size - 1))] = value
                arrays[name] = array
            case "shape":
                arrays[name] = draw(
                    st.sampled_from((array[..., None], array.reshape(-1), array.reshape(-1)[:1], np.zeros(0)))
                )
            case "type":
                kinds = ("U5", "i8", "f4", "c16", "b1", "S3")
                arrays[name] = np.zeros(array.shape, draw(st.sampled_from(kinds)))
            case "cut":
                del arrays[name]
                if not arrays:
                    break
            case "new":
                arrays[draw(texts(8)).replace("/", "-") or "a"] = np.zeros(3)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as made:
        for name, array in arrays.items():
            entry = io.BytesIO()
            np.lib.format.write_array(entry, np.asanyarray(array), allow_pickle=False)
            made.writestr(zipfile.ZipInfo(f"{name}.npy"), entry.getvalue())
    return buffer.getvalue()


@st.composite
def changed_json(draw: Callable[..., Any], document: Any) -> Any:
    """A document of JSON in which one value, somewhere, is another one or absent."""
    if isinstance(document, dict) and document and draw(st.integers(0, 4)):
        key = draw(st.sampled_from(sorted(document)))
        if draw(st.integers(0, 6)) == 0:
            return {name: part for name, part in document.items() if name != key}
        return document | {key: draw(changed_json(document[key]))}
    if isinstance(document, list) and document and draw(st.integers(0, 4)):
        place = draw(st.integers(0, len(document) - 1))
        return [*document[:place], draw(changed_json(document[place])), *document[place + 1 :]]
    return draw(values())


@st.composite
def recordings(draw: Callable[..., Any]) -> Question:
    """A recording, to export as a page or to measure."""
    content = draw(
        st.one_of(
            changed_recording(),
            changed_recording(),
            damaged(recording_bytes()),
            noise(),
            st.builds(zipped_bomb),
            st.sampled_from(SPECIAL),
        )
    )
    exports = [("export", "a.npz", f"a{suffix}", "--json") for suffix in (".html", ".html", ".csv", ".mcap", ".rrd")]
    call = draw(st.sampled_from((*exports, ("@recording", "a.npz"))))
    return Question("recording", call, {"a.npz": content}, writes=())


@cache
def zipped_bomb() -> bytes:
    """Return an archive of one megabyte of zeros that claims to unpack to two gigabytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(zipfile.ZipInfo("header.npy"), bytes(1 << 20), zipfile.ZIP_DEFLATED)
    data = bytearray(buffer.getvalue())
    place = data.index(b"PK\x01\x02") + 24  # the unpacked size in the directory
    data[place : place + 4] = (2 << 30).to_bytes(4, "little")
    return bytes(data)


@cache
def study_bytes() -> bytes:
    """Return the file of a study of lines with three attempts, one of which raised."""
    from pilegrasp_ctrl.study import run
    from pilegrasp_ctrl.study.condition import conditions
    from pilegrasp_ctrl.study.dispatch import InlinePool

    with tempfile.TemporaryDirectory() as folder:
        pool, run.open_pool = run.open_pool, lambda jobs, scheduler: InlinePool()
        try:
            found = conditions("free_space_line", {"line.speed": [0.2, 0.3]}, {"line.displacement": [0.0, 0.01, 0.0]})
            attempts = [(condition, seed) for condition in found for seed in range(2)]
            configuration = {"scenario": {}, "set": {}, "varied": ["line.speed"]}
            run.run_study(attempts, folder, configuration=configuration).close()
        finally:
            run.open_pool = pool
        return (Path(folder) / "study.db").read_bytes()


@st.composite
def changed_study(draw: Callable[..., Any]) -> bytes:
    """A study whose file is a good database, and some of whose cells hold something else."""
    connection = sqlite3.connect(":memory:")
    connection.deserialize(study_bytes())
    for _ in range(draw(st.integers(1, 2))):
        name = draw(st.sampled_from(("attempts", "scenarios", "origins", "about", "costs")))
        columns = [row[1] for row in connection.execute(f"PRAGMA table_info({name})")]
        if not columns:
            continue
        column = draw(st.sampled_from(columns))
        rows = connection.execute(f"SELECT {column} FROM {name}").fetchall()
        try:
            match draw(st.sampled_from(("cell", "cell", "cell", "json", "json", "row", "column", "table"))):
                case "cell":
                    cells = st.one_of(
                        st.none(), texts(), st.binary(max_size=9), st.integers(-(2**63), 2**63 - 1), st.floats()
                    )
                    connection.execute(f"UPDATE {name} SET {column} = ?", (draw(cells),))
                case "json" if rows and isinstance(rows[0][0], str) and rows[0][0].startswith("{"):
                    changed = json.dumps(draw(changed_json(json.loads(rows[0][0]))), default=str)
                    connection.execute(f"UPDATE {name} SET {column} = ?", (changed,))
                case "row":
                    connection.execute(f"DELETE FROM {name}")
                case "column":
                    connection.execute(f"ALTER TABLE {name} RENAME COLUMN {column} TO other")
                case "table":
                    connection.execute(f"DROP TABLE {name}")
        except sqlite3.Error:
            continue
    connection.commit()
    content = connection.serialize()
    connection.close()
    return content


SWEEP = (
    *("sweep", "free_space_line", "--set", "line.displacement=[0.0, 0.01, 0.0]", "--vary", "line.speed=0.2,0.3"),
    *("--seeds", "0:2", "--out", "study", "--json"),
)
"""The command that began the study of `study_bytes`, but for its configuration."""


@st.composite
def studies(draw: Callable[..., Any]) -> Question:
    """The folder of a study, to export, to report on, or to continue."""
    content = draw(
        st.one_of(
            changed_study(),
            changed_study(),
            damaged(study_bytes()),
            damaged(study_bytes(), 30),
            noise(),
            st.sampled_from(SPECIAL),
        )
    )
    files: dict[str, bytes | str] = {"study/study.db": content}
    if draw(st.integers(0, 3)) == 0:
        files["study/recordings/0123456789abcdef-0.npz"] = draw(st.one_of(damaged(recording_bytes()), noise()))
    if draw(st.integers(0, 9)) == 0:
        name = draw(st.sampled_from((".lock", "index.html", "recordings", "study.db-journal")))
        files = {path: inside for path, inside in files.items() if not path.startswith(f"study/{name}/")}
        files[f"study/{name}"] = draw(noise())
    calls = (
        ("export", "study", "table.csv"),
        ("report", "study", "--json"),
        SWEEP,
        ("report", "study", "--recordings", "1"),
    )
    return Question("study", draw(st.sampled_from(calls)), files, writes=("study",), stop_after=None)


def cached_pile() -> tuple[str, bytes]:
    """Return name and content of the cached pile that `calls.pile` settles with seed 0."""
    return _settled()[:2]


def settled_pile() -> str:
    """Return what `calls.pile` prints if there is no cache."""
    return _settled()[2]


@cache
def _settled() -> tuple[str, bytes, str]:
    from calls import pile

    text = io.StringIO()
    before = os.environ.get("XDG_CACHE_HOME")
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(text):
        os.environ["XDG_CACHE_HOME"] = folder
        try:
            pile("0")
        finally:
            del os.environ["XDG_CACHE_HOME"]
            if before is not None:
                os.environ["XDG_CACHE_HOME"] = before
        (path,) = (Path(folder) / "pilegrasp" / "piles").iterdir()
        return path.name, path.read_bytes(), text.getvalue()


@st.composite
def changed_pile(draw: Callable[..., Any]) -> bytes:
    """A cached pile whose archive is whole and whose poses are others."""
    with np.load(io.BytesIO(cached_pile()[1])) as archive:
        arrays = {name: archive[name] for name in archive.files}
    name = draw(st.sampled_from(sorted(arrays)))
    array = np.array(arrays[name])
    match draw(st.sampled_from(("zeros", "move", "shape", "type", "cut"))):
        case "zeros":
            arrays[name] = np.zeros_like(array)
        case "move" if array.dtype.kind == "f":
            arrays[name] = array + draw(st.sampled_from((1e-9, 1.0, np.nan, -5.0)))
        case "shape":
            arrays[name] = array.reshape(-1)[:1]
        case "cut":
            del arrays[name]
        case _:
            arrays[name] = np.array(["text"])
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


@st.composite
def caches(draw: Callable[..., Any]) -> Question:
    """A cached pile that is not what was written; the pile must be the settled one all the same."""
    name, content = cached_pile()
    changed = draw(st.one_of(changed_pile(), damaged(content), noise(), st.sampled_from(SPECIAL)))
    return Question("cache", ("@pile", "0"), {f"~/.cache/pilegrasp/piles/{name}": changed})
