"""Recordings: a saved one is read back to the bit, and damaged or foreign files are rejected."""

from __future__ import annotations

import json
import os
import pickle
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

import pilegrasp_ctrl.recording as module
from pilegrasp_ctrl.exceptions import RecordingError
from pilegrasp_ctrl.recording import Body, Recording, Shape
from pilegrasp_ctrl.recording_parts import Contacts
from synthetic_recording import synthetic

ARRAYS = ("frame_time", "body_position", "body_quaternion", "signal_time")


def small(**changes):
    """A recording of two frames and two bodies, with some arguments replaced."""
    arguments = {
        "meta": {"scenario": "small", "seed": 1},
        "bodies": (
            Body("ball", "object", (Shape("sphere", (0.03,)),)),
            Body("table", "support", (Shape("plane", (0.0, 0.0)),)),
        ),
        "frame_time": [0.0, 0.1],
        "body_position": np.zeros((2, 2, 3)),
        "body_quaternion": np.tile([1.0, 0.0, 0.0, 0.0], (2, 2, 1)),
        "signal_time": [0.0, 0.05, 0.1],
        "signals": {"push_force": [0.0, 1.0, 2.0], "wrench": np.zeros((3, 6))},
    }
    return Recording(**(arguments | changes))


@pytest.fixture(scope="module")
def attempt():
    return synthetic(frames=60)


def assert_equal(a: Recording, b: Recording) -> None:
    assert a.meta == b.meta
    assert a.bodies == b.bodies
    assert a.signals.keys() == b.signals.keys()
    for name in ARRAYS:
        assert getattr(a, name).dtype == getattr(b, name).dtype
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    for name, signal in a.signals.items():
        np.testing.assert_array_equal(signal, b.signals[name])
    assert (a.contacts is None) == (b.contacts is None)
    for name in ("start", "bodies", "position", "force") if a.contacts and b.contacts else ():
        np.testing.assert_array_equal(getattr(a.contacts, name), getattr(b.contacts, name))


def touching(**changes):
    """Two contacts in the second of two frames."""
    arguments = {"start": [0, 0, 2], "bodies": [[0, 1], [0, 1]], "position": np.ones((2, 3)), "force": np.eye(3)[:2]}
    return Contacts(**(arguments | changes))


def test_a_recording_is_read_back_to_the_bit(attempt, tmp_path):
    attempt.save(tmp_path / "a.npz")
    assert_equal(attempt, Recording.load(tmp_path / "a.npz"))


def test_contacts_are_read_back_and_belong_to_their_frame(tmp_path):
    recording = small(contacts=touching())
    recording.save(tmp_path / "a.npz")
    again = Recording.load(tmp_path / "a.npz")
    assert_equal(recording, again)
    assert again.contacts.frames == 2
    assert len(again.contacts.force[again.contacts.at(0)]) == 0
    np.testing.assert_array_equal(again.contacts.force[again.contacts.at(1)], np.eye(3)[:2])
    with pytest.raises(ValueError, match="read-only"):
        again.contacts.force[0] = 1.0


def test_a_recording_of_the_first_version_is_read_without_contacts(tmp_path):
    write_header(tmp_path / "a.npz", version=1)
    assert Recording.load(tmp_path / "a.npz").contacts is None


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"start": [1, 2]}, "begins at 0"),
        ({"start": [0, 2, 1]}, "does not decrease"),
        ({"start": []}, "begins at 0"),
        ({"start": [0, 1]}, r"bodies has shape \(2, 2\); \(1, 2\) is expected"),
        ({"bodies": [[0, -1], [0, 1]]}, "negative index"),
        ({"bodies": [[0, 0.5], [0, 1]]}, "bodies holds a value that is not a whole number"),
        ({"force": np.full((2, 3), np.nan)}, "force holds a value that is not finite"),
        ({"position": np.full((2, 3), 1e300)}, "position holds a value that is not finite"),
        ({"position": "far"}, "position is not an array of numbers"),
    ],
)
def test_wrong_contacts_are_rejected(changes, words):
    with pytest.raises(RecordingError, match=words):
        touching(**changes)


def test_contacts_fit_their_recording():
    with pytest.raises(RecordingError, match="contacts hold 1 frames; 2 are expected"):
        small(contacts=touching(start=[0, 2]))
    with pytest.raises(RecordingError, match="contacts name a body that is not recorded"):
        small(contacts=touching(bodies=[[0, 1], [0, 2]]))


def test_equal_recordings_give_equal_files(attempt, tmp_path):
    attempt.save(tmp_path / "a.npz")
    # Entries given in another order, and a second generation through a file.
    other = replace(Recording.load(tmp_path / "a.npz"), signals=dict(reversed(attempt.signals.items())))
    other.save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_numpy_and_json_alone_read_the_file(attempt, tmp_path):
    attempt.save(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz", allow_pickle=False) as archive:
        header = json.loads(str(archive["header"]))
        assert archive["signal/push_force"].dtype == np.float32
        assert archive["body_position"].shape == (60, len(header["bodies"]), 3)
    assert (header["format"], header["version"]) == ("pilegrasp-recording", 2)
    assert header["meta"]["outcomes"][1]["trigger"] == "grasp_force"
    ball = next(body for body in header["bodies"] if body["role"] == "object")
    assert ball["shapes"][0]["kind"] == "sphere"


def test_a_recording_is_printed_in_one_line():
    assert repr(small(contacts=touching())) == "Recording('small', seed=1, 2 frames, 2 bodies, 2 signals)"
    assert repr(touching()) == "Contacts(2 contacts in 2 frames)"


def test_a_recording_cannot_be_changed():
    position = np.zeros((2, 2, 3))
    meta = {"outcomes": [{"name": "push"}]}
    recording = small(body_position=position, meta=meta)
    position[:] = 7.0
    meta["outcomes"][0]["name"] = "lift"
    assert not recording.body_position.any()
    assert recording.meta["outcomes"][0]["name"] == "push"
    with pytest.raises(ValueError, match="read-only"):
        recording.signals["push_force"][0] = 1.0
    with pytest.raises(FrozenInstanceError):
        recording.frame_time = None


def test_meta_takes_numpy_values_and_a_recording_travels_between_processes():
    recording = small(meta={"grasped": np.int64(2), "success": np.True_, "list": np.arange(2), "tuple": (1, 2)})
    assert recording.meta == {"grasped": 2, "success": True, "list": [0, 1], "tuple": [1, 2]}
    assert_equal(recording, pickle.loads(pickle.dumps(recording)))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"frame_time": [0.0, 0.0]}, "frame_time is not a list of strictly increasing"),
        ({"frame_time": [0.0, np.nan]}, "frame_time holds a value that is not finite"),
        ({"frame_time": [0.0, 1e300]}, "frame_time holds a time beyond"),
        ({"frame_time": ["a", "b"]}, "frame_time is not an array of numbers"),
        ({"frame_time": []}, "at least one body and one frame"),
        ({"bodies": ()}, "at least one body and one frame"),
        ({"bodies": (Body("ball", "object", ()),) * 2}, "'ball' is used more than once"),
        ({"body_position": np.zeros((2, 3, 3))}, r"body_position has shape \(2, 3, 3\); \(2, 2, 3\)"),
        ({"body_position": np.full((2, 2, 3), np.inf)}, "body_position holds a value that is not finite"),
        ({"body_position": np.full((2, 2, 3), 1e300)}, "body_position holds a value that is not finite"),
        ({"body_quaternion": np.zeros((2, 2, 4))}, "not of unit length"),
        ({"signal_time": [0.0, 0.1, 0.05]}, "signal_time is not a list of strictly increasing"),
        ({"signals": {"q": np.zeros((2, 7))}}, r"signal 'q' has shape \(2, 7\); its length must be 3"),
        ({"signals": {"q": np.zeros((3, 7, 1))}}, "signal 'q' has shape"),
        ({"signals": {"push_force": [0.0, np.nan, 0.0]}}, "signal 'push_force' holds a value that is not finite"),
        ({"meta": {"peak": float("nan")}}, "meta cannot be written as JSON"),
        ({"meta": {"when": object()}}, "meta cannot be written as JSON: object is not a JSON value"),
    ],
)
def test_a_wrong_recording_is_rejected(changes, words):
    with pytest.raises(RecordingError, match=words):
        small(**changes)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"kind": "torus", "size": (1.0,)}, "'torus'; it must be one of sphere, capsule"),
        ({"kind": [], "size": (1.0,)}, "must be one of"),
        ({"kind": "box", "size": (1.0, 1.0)}, "the size of a box"),
        ({"kind": "box", "size": 1.0}, "the size of a box is 1.0; numbers are expected"),
        ({"kind": "sphere", "size": (-0.1,)}, "must be positive"),
        ({"kind": "capsule", "size": (0.1, 0.0)}, "must be positive"),
        ({"kind": "sphere", "size": (np.nan,)}, "1 finite numbers are expected"),
        ({"kind": "sphere", "size": (1.0,), "position": (0, 0)}, "a shape's position"),
        ({"kind": "sphere", "size": (1.0,), "quaternion": (2, 0, 0, 0)}, "not a unit quaternion"),
        ({"kind": "sphere", "size": (1.0,), "rgba": (0, 0, 0, 2)}, "must lie in 0..1"),
    ],
)
def test_a_wrong_shape_is_rejected(arguments, words):
    with pytest.raises(RecordingError, match=words):
        Shape(**arguments)


def test_a_wrong_body_is_rejected():
    with pytest.raises(RecordingError, match="must be one of arm, hand, object, support, sensor"):
        Body("cup", "tool", ())
    with pytest.raises(RecordingError, match="non-empty text"):
        Body("", "object", ())
    with pytest.raises(RecordingError, match="not all of type Shape"):
        Body("cup", "object", ("sphere",))


def test_sizes_are_those_of_mujoco():
    assert Shape("sphere", np.array([0.03, 0.0, 0.0])) == Shape("sphere", [0.03])
    assert Shape("capsule", (0.01, 0.05)).half_extents() == pytest.approx((0.01, 0.01, 0.06))
    assert Shape("cylinder", (0.01, 0.05)).half_extents() == (0.01, 0.01, 0.05)
    assert Shape("plane", (0.4, 0.3, 0.05)).half_extents() == (0.4, 0.3, 0.0)
    assert Shape("ellipsoid", (1, 2, 3)).half_extents() == (1.0, 2.0, 3.0)


def test_a_failed_save_leaves_the_old_file_and_no_other(tmp_path, monkeypatch):
    path = tmp_path / "a.npz"
    small().save(path)
    before = path.read_bytes()

    def refuse(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(RecordingError, match=r"cannot be written to .*a\.npz.*no space left"):
        small(meta={}).save(path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.npz"]


def test_an_unwritable_path_is_one_sentence(tmp_path):
    for place in (tmp_path / "missing" / "a.npz", tmp_path):
        with pytest.raises(RecordingError, match="cannot be written to"):
            small().save(place)
    assert os.listdir(tmp_path) == []


def write_header(path, **changes):
    """Save a recording whose header differs."""
    small().save(path)
    with np.load(path) as archive:
        arrays = dict(archive)
    header = json.loads(str(arrays["header"])) | changes
    np.savez(path, **(arrays | {"header": np.array(json.dumps(header))}))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"version": 4}, "it has version 4; this program reads versions 1 to 3"),
        ({"version": None}, "it has version None"),
        ({"format": "other"}, "does not hold the format 'pilegrasp-recording'"),
        ({"bodies": [{"name": "a"}]}, "damaged"),
        ({"bodies": 3}, "damaged"),
        ({"bodies": [{"name": "a", "role": "tool", "shapes": []}] * 2}, "must be one of arm"),
        ({"bodies": []}, "at least one body"),
        ({"meta": None}, "meta cannot be written"),
        ({"signals": ["push_force", "q"]}, "the entry 'signal/q' is missing"),
        ({"contacts": True}, "the entry 'contact/bodies' is missing"),
    ],
)
def test_a_wrong_header_is_rejected(changes, words, tmp_path):
    write_header(tmp_path / "a.npz", **changes)
    with pytest.raises(RecordingError, match=words):
        Recording.load(tmp_path / "a.npz")


def test_other_files_are_rejected(tmp_path):
    foreign = {
        "text.npz": b"not an archive",
        "empty.npz": b"",
        "pickle.npz": pickle.dumps({"a": 1}),
    }
    for name, content in foreign.items():
        (tmp_path / name).write_bytes(content)
    np.savez(tmp_path / "other.npz", x=np.arange(3))
    np.savez(tmp_path / "object.npz", header=np.array({"format": "pilegrasp-recording"}, dtype=object))
    np.save(tmp_path / "array.npz.npy", np.arange(3))
    (tmp_path / "folder.npz").mkdir()
    for place in [*sorted(tmp_path.iterdir()), tmp_path / "missing.npz", tmp_path / "a\0b.npz"]:
        with pytest.raises(RecordingError) as caught:
            Recording.load(place)
        assert "\n" not in str(caught.value)
        assert len(str(caught.value)) < 400


class Trap:
    """Makes a folder when it is unpickled."""

    def __init__(self, place):
        self.place = place

    def __reduce__(self):
        return os.mkdir, (self.place,)


def test_nothing_in_a_file_is_executed(tmp_path):
    np.savez(tmp_path / "a.npz", header=np.array(Trap(str(tmp_path / "sprung")), dtype=object))
    with pytest.raises(RecordingError):
        Recording.load(tmp_path / "a.npz")
    assert os.listdir(tmp_path) == ["a.npz"]


def test_the_error_names_a_missing_entry(tmp_path):
    small().save(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as archive:
        arrays = {name: archive[name] for name in archive.files if name != "body_position"}
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(RecordingError, match="the entry 'body_position' is missing"):
        Recording.load(tmp_path / "a.npz")


def test_an_archive_that_unpacks_to_too_much_is_rejected(tmp_path, monkeypatch):
    small().save(tmp_path / "a.npz")
    monkeypatch.setattr(module, "MAX_BYTES", 1000)
    with pytest.raises(RecordingError, match="would unpack to more than"):
        Recording.load(tmp_path / "a.npz")


def test_every_truncation_is_detected(tmp_path):
    path = tmp_path / "a.npz"
    small().save(path)
    content = path.read_bytes()
    for length in range(0, len(content) - 1, 23):
        path.write_bytes(content[:length])
        with pytest.raises(RecordingError):
            Recording.load(path)


def test_flipped_bytes_are_detected_or_harmless(tmp_path):
    path = tmp_path / "a.npz"
    whole = small()
    whole.save(path)
    content = path.read_bytes()
    rng = np.random.default_rng(0)
    refused = 0
    for position in rng.choice(len(content), 300, replace=False):
        damaged = bytearray(content)
        damaged[position] ^= int(rng.integers(1, 256))
        path.write_bytes(bytes(damaged))
        try:
            assert_equal(Recording.load(path), whole)
        except RecordingError:
            refused += 1
    assert refused > 150


@pytest.mark.parametrize("kind", ["c16", "U3", "S3", "M8[s]", "O"])
def test_only_numbers_are_taken_for_numbers(kind):
    with pytest.raises(RecordingError, match=r"signal 'push_force' is not an array of numbers"):
        small(signals={"push_force": np.zeros(3, kind), "wrench": np.zeros((3, 6))})
