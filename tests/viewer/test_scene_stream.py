"""The stream of commands: every body with its pose, and an animation that errs by little."""

from __future__ import annotations

import numpy as np
import pytest
from meshcat.commands import SetProperty, SetTransform
from meshcat.geometry import pack_numpy_array
from meshcat.path import Path as NodePath
from scipy.spatial.transform import Rotation, Slerp

from page_parts import of_type, still, tracks
from pilegrasp_ctrl.recording import Shape
from pilegrasp_ctrl.viewer.scene.animation import angle_between, rotation_track, slerp, vector_track
from pilegrasp_ctrl.viewer.scene.commands import commands, node_path, pack, unpack
from pilegrasp_ctrl.viewer.scene.overlays import direction_quaternions
from synthetic_recording import synthetic


@pytest.fixture(scope="module")
def attempt():
    return synthetic()


@pytest.fixture(scope="module")
def stream(attempt):
    return unpack(pack(commands(attempt)))


def test_the_animation_stays_within_a_fifth_of_a_millimeter_and_half_a_degree(attempt, stream):
    moving = tracks(stream)
    times = attempt.frame_time - attempt.frame_time[0]
    worst_position = worst_angle = 0.0
    for index, body in enumerate(attempt.bodies):
        keys = moving.get(node_path(index, body), {})
        position = np.broadcast_to(attempt.body_position[0, index], (times.size, 3))
        turns = Rotation.from_quat(np.tile(attempt.body_quaternion[0, index], (times.size, 1)), scalar_first=True)
        if ".position" in keys:
            t, x = keys[".position"]
            position = np.stack([np.interp(times, t, x[:, k]) for k in range(3)], axis=1)
        if ".quaternion" in keys:
            t, x = keys[".quaternion"]
            turns = Slerp(t, Rotation.from_quat(x))(np.clip(times, t[0], t[-1]))
        recorded = Rotation.from_quat(attempt.body_quaternion[:, index], scalar_first=True)
        worst_position = max(worst_position, np.linalg.norm(position - attempt.body_position[:, index], axis=1).max())
        worst_angle = max(worst_angle, (turns * recorded.inv()).magnitude().max())
    # Times in single precision shift a body at 1 m/s by a micrometer.
    assert 1e-5 < worst_position <= 0.2e-3 + 1e-6
    assert 1e-3 < worst_angle <= np.deg2rad(0.5) + 1e-6


def test_a_long_link_turns_more_exactly_than_a_small_one():
    times = np.linspace(0.0, 1.0, 60, dtype=np.float32)
    half = 0.3 * np.sin(6.0 * times)
    turn = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1).astype(np.float32)
    counts = {}
    for length in (0.02, 0.5):
        recording = still(
            [Shape("capsule", (0.01, length))],
            frames=60,
            frame_time=times,
            body_quaternion=turn[:, None],
        )
        (keys,) = tracks(unpack(pack(commands(recording)))).values()
        t, x = keys[".quaternion"]
        error = (Slerp(t, Rotation.from_quat(x))(times) * Rotation.from_quat(turn, scalar_first=True).inv()).magnitude()
        assert error.max() * (length + 0.01) <= 0.4e-3 + 1e-6
        counts[length] = len(t)
    assert counts[0.5] > counts[0.02]


def test_bodies_at_rest_have_no_keys_and_straight_lines_have_two(attempt, stream):
    moving = tracks(stream)
    assert not [path for path in moving if path.startswith("/Support/") or path.endswith("base")]
    line = np.outer(np.linspace(0, 1, 50), [0.1, 0.2, 0.3]).astype(np.float32)
    times = np.linspace(0, 2, 50).astype(np.float32)
    assert len(vector_track("position", times, line, 1e-4).times) == 2
    shake = line * 1e-4
    assert vector_track("position", times, shake, 1e-4) is None
    keys = sum(len(t) for properties in moving.values() for t, _ in properties.values())
    assert keys < 0.15 * 2 * len(attempt.bodies) * len(attempt.frame_time)


@pytest.mark.parametrize("seed", range(4))
def test_thinning_holds_its_bound_on_rough_motion(seed):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.01, 0.1, 200)).astype(np.float32)
    walk = np.cumsum(rng.normal(0.0, 2e-3, (200, 3)), axis=0).astype(np.float32)
    track = vector_track("position", times, walk, 5e-3)
    back = np.stack([np.interp(times, track.times, track.values[:, k]) for k in range(3)], axis=1)
    assert np.linalg.norm(back - walk, axis=1).max() <= 5e-3 + 1e-7
    # Quaternions whose sign flips at random are the same motion.
    turns = Rotation.from_rotvec(np.cumsum(rng.normal(0.0, 0.05, (200, 3)), axis=0))
    wxyz = (turns.as_quat(scalar_first=True) * rng.choice([-1.0, 1.0], (200, 1))).astype(np.float32)
    track = rotation_track(times, wxyz, 0.03)
    error = (Slerp(track.times, Rotation.from_quat(track.values))(times) * turns.inv()).magnitude()
    assert error.max() <= 0.03 + 1e-5
    assert len(track.times) < 200


def test_slerp_agrees_with_scipy():
    rng = np.random.default_rng(3)
    for size in (2.9, 0.1, 1e-4, 0.0):
        first = Rotation.random(random_state=rng)
        second = Rotation.from_rotvec(size * np.array([0.6, 0.0, 0.8])) * first
        fractions = np.linspace(0.0, 1.0, 7)
        ours = slerp(first.as_quat(scalar_first=True), -second.as_quat(scalar_first=True), fractions)
        theirs = Slerp([0.0, 1.0], Rotation.concatenate([first, second]))(fractions)
        assert angle_between(ours, theirs.as_quat(scalar_first=True)).max() < 1e-7


def test_the_stream_speaks_meshcats_language(stream):
    matrix = np.arange(16.0).reshape(4, 4)
    theirs = SetTransform(matrix, NodePath(("meshcat", "a"))).lower()
    ours = of_type(stream, "set_transform")[0]
    assert ours.keys() == theirs.keys()
    assert (
        SetProperty("visible", False, NodePath(("Grid",))).lower().keys() == of_type(stream, "set_property")[0].keys()
    )
    assert {command["type"] for command in stream} == {"set_object", "set_transform", "set_property", "set_animation"}
    block = pack_numpy_array(np.zeros((3, 2), dtype=np.float32))["array"]
    animation = of_type(stream, "set_animation")[0]["animations"]
    assert animation[0]["clip"]["tracks"][0]["values"].type == block.type


def test_every_body_is_an_object_with_its_first_pose(attempt, stream):
    objects = {command["path"]: command["object"] for command in of_type(stream, "set_object")}
    transforms = {command["path"]: command["matrix"] for command in of_type(stream, "set_transform")}
    for index, body in enumerate(attempt.bodies):
        path = node_path(index, body)
        meshes = len(objects[path]["object"]["children"])
        assert meshes == len(body.shapes) * (2 if body.role == "object" else 1)
        matrix = np.reshape(transforms[path], (4, 4)).T
        np.testing.assert_allclose(matrix[:3, 3], attempt.body_position[0, index], atol=1e-6)
        turn = Rotation.from_quat(attempt.body_quaternion[0, index], scalar_first=True)
        np.testing.assert_allclose(matrix[:3, :3], turn.as_matrix(), atol=1e-6)
    assert len([path for path in objects if path.startswith("/Objects/")]) == 18


def test_the_arrow_has_the_forces_length_and_direction():
    count = 5
    force = np.tile([-10.0, 0.0, 0.0], (count, 1))
    force[0] = 0.0
    recording = still(
        [Shape("sphere", (0.03,))],
        frames=count,
        signal_time=np.arange(count) / 30.0,
        signals={
            "wrench": np.c_[force, np.zeros((count, 3))],
            "tool_position": np.tile([0.5, 0.1, 0.2], (count, 1)),
        },
    )
    moving = tracks(unpack(pack(commands(recording))))
    root = "/Overlays/wrench/force"
    length = moving[f"{root}/shaft"][".scale"][1][-1, 2] + moving[f"{root}/head"][".scale"][1][-1, 2]
    assert length == pytest.approx(0.10, abs=1e-3)
    assert moving[f"{root}/shaft"][".scale"][1][0].max() < 1e-3
    turn = Rotation.from_quat(moving[root][".quaternion"][1][-1])
    np.testing.assert_allclose(turn.apply([0.0, 0.0, 1.0]), (-1.0, 0.0, 0.0), atol=1e-6)
    (place,) = [c for c in of_type(commands(recording), "set_property", root) if c["value"][0] == 0.5]
    assert place["value"] == pytest.approx([0.5, 0.1, 0.2])


def test_directions_map_up_onto_the_vector_and_outlast_a_gap():
    vectors = np.array([[0, 0, 5.0], [0, 0, -5.0], [3.0, 4.0, 0], [0.01, 0, 0], [-1.0, 1.0, -1.0]])
    turned = Rotation.from_quat(direction_quaternions(vectors), scalar_first=True).apply([0.0, 0.0, 1.0])
    expected = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    expected[3] = expected[2]
    np.testing.assert_allclose(turned, expected, atol=1e-6)
