"""Recordings for other programs, read back by these programs' own libraries."""

from __future__ import annotations

import csv
import json
import sys

import numpy as np
import pytest

import pilegrasp_ctrl
from pilegrasp_ctrl import cli
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.files import VIEWS
from pilegrasp_ctrl.recording import Body, Recording, Shape
from pilegrasp_ctrl.recording_parts import SIZE_LENGTH
from pilegrasp_ctrl.viewer import write
from pilegrasp_ctrl.viewer.exports import FORMATS

CORNERS = [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.1, 0.1, 0.0), (0.0, 0.1, 0.0)]
"""Corners of a mesh of two triangles [m]."""


@pytest.fixture(scope="module")
def recording():
    """Two frames of a body with a shape of every kind, and two signals."""
    pose = {"position": (0.0, 0.0, 1.0), "quaternion": (np.sqrt(0.5), np.sqrt(0.5), 0, 0)}
    triangles = {"vertices": CORNERS, "faces": [(0, 1, 2), (0, 2, 3)]}
    shapes = tuple(
        Shape(kind, (0.1, 0.2, 0.3)[:length], **pose, **(triangles if kind == "mesh" else {}))
        for kind, length in SIZE_LENGTH.items()
    )
    turned = [np.cos(0.3), 0.0, 0.0, np.sin(0.3)]
    return Recording(
        meta={
            "scenario": "test",
            "outcomes": [
                {"name": "push", "status": "ended", "trigger": "grasp_force", "start": 0.0, "end": 0.5},
                {"name": "lift", "status": "failed", "trigger": "time", "start": 0.5, "end": 1.0},
            ],
        },
        bodies=(Body("all kinds", "object", shapes), Body("b", "hand", ())),
        frame_time=[0.0, 1.0],
        body_position=[[[0, 0, 0], [1, 2, 3]], [[0, 0, 0.5], [4, 5, 6]]],
        body_quaternion=[[[1, 0, 0, 0], turned]] * 2,
        signal_time=[0.0, 0.25, 1.0],
        signals={"push_force": [0.0, 1.5, 1 / 3], "q": [[1, 2], [3, 4], [5, 6]]},
    )


def test_every_suffix_has_a_writer():
    assert tuple(FORMATS) == VIEWS


def test_the_table_of_signals_keeps_every_digit(recording, tmp_path):
    recording.save(tmp_path / "a.npz")
    assert cli.main(["export", str(tmp_path / "a.npz"), str(tmp_path / "a.csv")]) == 0
    with open(tmp_path / "a.csv", newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["time", "push_force", "q[0]", "q[1]"]
    values = np.array(rows, dtype=np.float64)
    assert np.array_equal(values[:, 0], recording.signal_time)
    assert np.array_equal(values[:, 1].astype(np.float32), recording.signals["push_force"])
    assert np.array_equal(values[:, 2:], recording.signals["q"])


def test_a_recording_without_signals_has_no_table(recording, tmp_path):
    bare = Recording({}, recording.bodies, [0.0], [[[0, 0, 0]] * 2], [[[1, 0, 0, 0]] * 2], [], {})
    with pytest.raises(PilegraspError, match="has no signals"):
        write(bare, tmp_path / "a.csv")


def test_foxglove_gets_bodies_poses_signals_and_events(recording, tmp_path):
    reader = pytest.importorskip("mcap.reader")
    write(recording, tmp_path / "a.mcap")
    with open(tmp_path / "a.mcap", "rb") as file:
        found = [
            (channel.topic, schema.name, message.log_time, json.loads(message.data))
            for schema, channel, message in reader.make_reader(file).iter_messages()
        ]
    by_topic = {topic: [entry[2:] for entry in found if entry[0] == topic] for topic in {entry[0] for entry in found}}
    assert {(topic, schema) for topic, schema, _, _ in found} == {
        ("/scene", "foxglove.SceneUpdate"),
        ("/tf", "foxglove.FrameTransforms"),
        ("/events", "foxglove.Log"),
        ("/signals/push_force", "pilegrasp.Signal"),
        ("/signals/q", "pilegrasp.Signal"),
    }
    assert [time for time, _ in by_topic["/tf"]] == [0, 10**9]
    last = by_topic["/tf"][1][1]["transforms"][1]
    assert last["translation"] == {"x": 4.0, "y": 5.0, "z": 6.0}
    assert last["rotation"]["z"] == pytest.approx(np.sin(0.3), abs=1e-6)
    assert by_topic["/signals/push_force"][1] == (250_000_000, {"value": 1.5})
    assert by_topic["/signals/q"][2] == (10**9, {"0": 5.0, "1": 6.0})
    assert [(time, log["level"], log["message"]) for time, log in by_topic["/events"]] == [
        (500_000_000, 2, "push: grasp force"),
        (10**9, 3, "lift: time"),
    ]
    entity = by_topic["/scene"][0][1]["entities"][0]
    assert {kind: len(entity[kind]) for kind in ("spheres", "cylinders", "cubes")} == {
        "spheres": 4,  # a sphere, an ellipsoid, and the two caps of a capsule
        "cylinders": 2,
        "cubes": 2,
    }
    (mesh,) = entity["triangles"]
    assert [tuple(point.values()) for point in mesh["points"]] == CORNERS
    assert mesh["indices"] == [0, 1, 2, 0, 2, 3]
    # The capsule lies along -y, because it is turned by a quarter about x; its caps are 0.2 m from its middle.
    caps = sorted(one["pose"]["position"]["y"] for one in entity["spheres"][1:3])
    assert caps == pytest.approx([-0.2, 0.2])


def test_equal_recordings_give_equal_mcap_files(recording, tmp_path):
    pytest.importorskip("mcap")
    for name in ("a.mcap", "b.mcap"):
        write(recording, tmp_path / name)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_rerun_gets_bodies_poses_signals_and_events(recording, tmp_path):
    chunk = pytest.importorskip("rerun.chunk")
    write(recording, tmp_path / "a.rrd")
    chunks = chunk.RrdReader(str(tmp_path / "a.rrd")).stream().to_chunks()
    tables = {}
    for one in chunks:
        tables.setdefault(one.entity_path, []).append(one.to_record_batch())

    def column(entity, name):
        return [
            value
            for batch in tables[entity]
            for field in batch.schema.names
            if field.endswith(name)
            for value in batch.column(field).to_pylist()
        ]

    assert np.allclose(column("/signals/push_force", "Scalars:scalars"), [[0.0], [1.5], [1 / 3]])
    assert column("/signals/q", "Scalars:scalars") == [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]
    assert column(r"/scene/hand/1\ b", "Transform3D:translation") == [[[1.0, 2.0, 3.0]], [[4.0, 5.0, 6.0]]]
    assert column("/events", "TextLog:text") == [["push: grasp force"], ["lift: time"]]
    shapes = [entity for entity in tables if entity.startswith(r"/scene/object/0\ all\ kinds/")]
    assert len(shapes) == len(SIZE_LENGTH)
    assert np.allclose(
        column(rf"/scene/object/0\ all\ kinds/{list(SIZE_LENGTH).index('mesh')}", "vertex_positions"), CORNERS
    )


@pytest.mark.parametrize(("suffix", "package"), [(".rrd", "rerun"), (".mcap", "mcap")])
def test_a_missing_package_is_named_before_anything_is_made(recording, tmp_path, capsys, monkeypatch, suffix, package):
    real = pilegrasp_ctrl.viewer.exports.FORMATS[suffix].requires[0].__module__
    monkeypatch.setattr(sys.modules[real].importlib.util, "find_spec", lambda name: None)
    recording.save(tmp_path / "a.npz")
    assert cli.main(["export", str(tmp_path / "a.npz"), str(tmp_path / f"a{suffix}")]) == 2
    assert "pip install 'pilegrasp[export]'" in capsys.readouterr().err
    assert not (tmp_path / f"a{suffix}").exists()
