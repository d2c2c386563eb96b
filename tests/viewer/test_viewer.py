"""The page without a browser: what the stream of commands says, and that hostile content stays text."""

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
from meshcat.commands import SetProperty, SetTransform
from meshcat.geometry import Box, Cylinder, pack_numpy_array
from meshcat.path import Path as NodePath
from scipy.spatial.transform import Rotation, Slerp

from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.recording import Body, Recording, Shape
from pilegrasp_ctrl.recording_parts import Contacts
from pilegrasp_ctrl.viewer import page, write_html
from pilegrasp_ctrl.viewer.animation import angle_between, rotation_track, slerp, vector_track
from pilegrasp_ctrl.viewer.camera import action_box, best_direction, directions
from pilegrasp_ctrl.viewer.commands import commands, node_path, pack, unpack
from pilegrasp_ctrl.viewer.lane import nice_ticks, thinned
from pilegrasp_ctrl.viewer.overlays import direction_quaternions
from pilegrasp_ctrl.viewer.shapes import PALETTE, body_object
from pilegrasp_ctrl.viewer.summary import summarize
from synthetic_recording import synthetic

HOSTILE = '</script><script>window.pwned=1</script><img src=x onerror="window.pwned=1">&"\'\ud800'


@pytest.fixture(scope="module")
def attempt():
    return synthetic()


@pytest.fixture(scope="module")
def stream(attempt):
    return unpack(pack(commands(attempt)))


@pytest.fixture(scope="module")
def document(attempt):
    return page(attempt)


def still(shapes, position=(0.0, 0.0, 0.0), role="object", frames=2, **changes):
    """One body at rest."""
    arguments = {
        "meta": {},
        "bodies": (Body("thing", role, tuple(shapes)),),
        "frame_time": np.arange(frames) / 30.0,
        "body_position": np.broadcast_to(position, (frames, 1, 3)),
        "body_quaternion": np.broadcast_to((1.0, 0.0, 0.0, 0.0), (frames, 1, 4)),
        "signal_time": [],
        "signals": {},
    }
    return Recording(**(arguments | changes))


def floats(extension, width):
    return np.frombuffer(extension.data, dtype="<f4").reshape(-1, width).astype(np.float64)


def tracks(stream):
    """The animation's tracks: path to property to (times, values)."""
    (animation,) = [command for command in stream if command["type"] == "set_animation"]
    widths = {"quaternion": 4}
    return {
        entry["path"]: {
            track["name"]: (floats(track["times"], 1)[:, 0], floats(track["values"], widths.get(track["type"], 3)))
            for track in entry["clip"]["tracks"]
        }
        for entry in animation["animations"]
    }


def of_type(stream, name, path=""):
    return [command for command in stream if command["type"] == name and command["path"].startswith(path)]


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


def test_boxes_and_cylinders_are_those_of_meshcat():
    body = Body("b", "arm", (Shape("box", (0.1, 0.2, 0.3)), Shape("cylinder", (0.05, 0.4))))
    ours = body_object(body)["geometries"]
    for mine, theirs in zip(ours, (Box([0.2, 0.4, 0.6]).lower({}), Cylinder(0.8, 0.05).lower({})), strict=True):
        shared = mine.keys() & theirs.keys() - {"uuid", "radialSegments"}
        assert {key: mine[key] for key in shared} == pytest.approx({key: theirs[key] for key in shared})
        assert len(shared) >= 4


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


def vertices(mesh, geometry):
    """Extreme points of a round geometry in its body's frame, as three.js would place them."""
    matrix = np.reshape(mesh["matrix"], (4, 4)).T
    match geometry["type"]:
        case "SphereGeometry":
            local = geometry["radius"] * np.concatenate([np.eye(3), -np.eye(3)])
        case "LatheGeometry":
            local = np.array([[s * p["x"], p["y"], 0.0] for p in geometry["points"] for s in (-1, 1)])
            local = np.concatenate([local, local[:, [2, 1, 0]]])
        case "CylinderGeometry":
            r, h = geometry["radiusTop"], geometry["height"] / 2
            local = np.array([[r, h, 0], [-r, -h, 0], [0, h, r], [0, -h, -r]])
    return (matrix @ np.c_[local, np.ones(len(local))].T).T[:, :3]


@pytest.mark.parametrize(
    "shape",
    [
        Shape("sphere", (0.03,), (0.1, 0.2, 0.3)),
        Shape("ellipsoid", (0.01, 0.02, 0.03), (0.1, 0.0, 0.0)),
        Shape("capsule", (0.01, 0.05), (0.0, 0.1, 0.0)),
        Shape("cylinder", (0.02, 0.05), (0.0, 0.0, 0.3)),
    ],
    ids=lambda shape: shape.kind,
)
def test_round_shapes_have_the_extent_that_mujoco_gives_them(shape):
    for role in ("arm", "object"):
        drawn = body_object(Body("b", role, (shape,)))
        by_name = {geometry["uuid"]: geometry for geometry in drawn["geometries"]}
        points = np.concatenate([vertices(m, by_name[m["geometry"]]) for m in drawn["object"]["children"]])
        np.testing.assert_allclose(points.max(axis=0) - shape.position, shape.half_extents(), atol=1e-9)
        np.testing.assert_allclose(points.min(axis=0) - shape.position, -np.array(shape.half_extents()), atol=1e-9)


def test_a_shape_turns_with_its_quaternion():
    half = np.sqrt(0.5)
    lying = Shape("capsule", (0.01, 0.05), quaternion=(half, 0.0, half, 0.0))  # z of the shape onto x of the body
    drawn = body_object(Body("b", "arm", (lying,)))
    points = vertices(drawn["object"]["children"][0], drawn["geometries"][0])
    np.testing.assert_allclose(points.max(axis=0), (0.06, 0.01, 0.01), atol=1e-9)


def test_equal_shapes_share_their_geometry_and_two_tones_show_rolling():
    ball = Shape("sphere", (0.03,))
    drawn = body_object(Body("b", "object", (ball, replace(ball, position=(0.1, 0, 0)))))
    assert (len(drawn["geometries"]), len(drawn["materials"]), len(drawn["object"]["children"])) == (2, 2, 4)
    halves = [(g["phiStart"], g["phiLength"]) for g in drawn["geometries"]]
    np.testing.assert_allclose(halves, [(0.0, np.pi), (np.pi, np.pi)])


def colors(recording):
    return [c["object"]["materials"][0]["color"] for c in of_type(commands(recording), "set_object", "/Objects/")]


def test_objects_of_one_colour_are_told_apart_and_others_keep_theirs():
    assert set(colors(synthetic(objects=9, frames=2))) == set(PALETTE[:9])
    shapes = [Shape("sphere", (0.03,), rgba=(1, 0, 0, 1)), Shape("sphere", (0.03,), rgba=(0, 0, 1, 1))]
    assert colors(still(shapes)) == [0xFF0000]


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


def test_the_camera_looks_from_where_no_wall_stands():
    tall = Shape("box", (0.4, 0.01, 0.5), (0.0, 0.0, 0.5))
    for side in (-1.0, 1.0):
        walled = still([Shape("sphere", (0.03,))])
        walled = replace(
            walled,
            bodies=(*walled.bodies, Body("wall", "support", (tall,))),
            body_position=np.array([[[0.0, 0.0, 0.03], [0.0, 0.2 * side, 0.0]]] * 2),
            body_quaternion=np.broadcast_to((1.0, 0.0, 0.0, 0.0), (2, 2, 4)),
        )
        assert best_direction(walled)[1] * side < -0.5
        glass = replace(walled.bodies[1], shapes=(replace(tall, rgba=(1, 1, 1, 0.0)),))
        through = replace(walled, bodies=(walled.bodies[0], glass))
        np.testing.assert_array_equal(best_direction(through), directions()[0])


def beside(*others, frames=2, **changes):
    """A ball at rest and other bodies of one box each: role, half sizes, opacity and place at each frame."""
    bodies = [Body("ball", "object", (Shape("sphere", (0.03,)),))]
    places = [np.tile([0.0, 0.0, 0.03], (frames, 1))]
    for index, (role, half, opacity, place) in enumerate(others):
        bodies.append(Body(f"box {index}", role, (Shape("box", half, rgba=(1, 1, 1, opacity)),)))
        places.append(np.broadcast_to(place, (frames, 3)))
    return still(
        [Shape("sphere", (0.03,))],
        frames=frames,
        bodies=tuple(bodies),
        body_position=np.stack(places, axis=1),
        body_quaternion=np.broadcast_to((1.0, 0.0, 0.0, 0.0), (frames, len(bodies), 4)),
        **changes,
    )


def test_the_camera_would_rather_look_through_glass_than_at_an_arm():
    half = (0.8, 0.01, 0.8)
    arm, glass = ("arm", half, 1.0, (0.0, -0.2, 0.0)), ("support", half, 0.45, (0.0, 0.2, 0.0))
    assert best_direction(beside(arm, glass))[1] > 0.5
    assert best_direction(beside(glass))[1] < -0.5


def test_the_camera_leaves_its_preferred_view_for_one_that_hides_a_hundredth_less():
    preferred, second = directions()[:2]
    np.testing.assert_allclose(preferred, (0.0, -np.cos(np.deg2rad(24)), np.sin(np.deg2rad(24))), atol=1e-12)
    np.testing.assert_allclose(second, (0.0, -np.cos(np.deg2rad(42)), np.sin(np.deg2rad(42))), atol=1e-12)
    # A small pane that stands in the preferred view alone hides the square of its opacity.
    pane = ((0.03, 0.005, 0.03), (0.0, -0.2, 0.03 + 0.2 * np.tan(np.deg2rad(24))))
    for hidden, chosen in ((0.008, preferred), (0.012, second)):
        scene = beside(("support", pane[0], np.sqrt(hidden), pane[1]))
        np.testing.assert_array_equal(best_direction(scene), chosen)


def test_the_camera_heeds_the_ends_of_the_primitives():
    passing = np.tile([0.0, -0.2, 0.0], (90, 1))
    passing[:] += 5.0
    passing[44:48] -= 5.0
    arm = ("arm", (0.8, 0.01, 0.8), 1.0, passing)
    np.testing.assert_array_equal(best_direction(beside(arm, frames=90)), directions()[0])
    outcomes = [{"name": "push", "status": "ended", "start": 0.0, "end": 45 / 30}]
    assert best_direction(beside(arm, frames=90, meta={"outcomes": outcomes}))[1] > 0.5


def test_the_picture_holds_hand_and_pile_but_not_a_runaway(attempt):
    low, high = action_box(attempt)
    hand = attempt.body_position[:, [b.role == "hand" for b in attempt.bodies]].reshape(-1, 3)
    assert ((hand > low) & (hand < high)).all(axis=1).mean() > 0.95
    runaway = np.array(attempt.body_position)
    runaway[200:, [b.name for b in attempt.bodies].index("light_sphere_17")] += (30.0, 0.0, 0.0)
    assert action_box(replace(attempt, body_position=runaway))[1][0] < 1.5


def test_a_page_of_sixty_bodies_is_small():
    for frames, duration in ((300, 10.0), (600, 20.0)):
        recording = synthetic(objects=25, frames=frames, duration=duration)
        assert len(recording.bodies) >= 60
        assert len(page(recording).encode()) <= 1.2e6


def test_a_page_of_ninety_objects_is_small():
    assert len(page(synthetic(objects=90, frames=300, duration=10.0)).encode()) <= 3e6


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


def test_the_page_asks_for_nothing(document):
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


def text_of(document):
    visible = re.sub(r"<(script|style)\b.*?</\1>", "", document, flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]+>", " ", visible).split())


def test_the_head_says_what_happened_when_and_why():
    words = text_of(page(synthetic(success=False, frames=30)))
    assert "spheres_wall seed 0 Failed push: travel limit of 0.36 m before 17 N, at 6.4 s" in words
    assert "failed: travel limit of 0.36 m 2.20–6.40 360 11.2" in words
    words = text_of(page(synthetic(frames=30)))
    assert "Success: 2 objects held after 10.0 s hand rbo_hand2 object light_sphere count 18" in words
    assert "push grasp force 2.20–6.40 360 17.3" in words
    assert "mujoco 4.0.0" in words


def timeline_of(document):
    return document[document.index('<figure class="timeline">') : document.index("</figure>")]


def lane_of(document, title):
    """The HTML of one lane of the timeline."""
    (lane,) = [part for part in timeline_of(document).split('<div class="lane"')[1:] if f"<b>{title} [" in part]
    return lane


def curve_of(lane, style):
    (points,) = re.findall(rf'class="{style}" points="([^"]+)"', lane)
    return np.array([point.split(",") for point in points.split()], dtype=float)


def test_the_timeline_has_bands_curves_and_the_threshold():
    document = page(synthetic(frames=30))
    bands = re.findall(r'class="band (p\d)" style="left:([\d.]+)%;width:([\d.]+)%"', timeline_of(document))
    assert bands == [
        ("p0", "0.00", "22.00"),
        ("p1", "22.00", "42.00"),
        ("p2", "64.00", "12.00"),
        ("p3", "76.00", "24.00"),
    ]
    lane = lane_of(document, "force")
    curve = curve_of(lane, "c0")
    highest = curve[np.argmin(curve[:, 1])]
    (line,) = re.findall(r'class="threshold" x1="0" x2="1000" y1="([\d.]+)"', lane)
    # The push force passes 17 N shortly before 6.4 of 10 s and falls to zero there.
    assert 620 < highest[0] < 640
    assert highest[1] < float(line)
    assert "F_grasp 17 N" in lane
    assert len(curve_of(lane, "c1")) > 100


def test_every_lane_shows_its_signal_in_its_unit():
    document = page(synthetic(frames=30))
    titles = re.findall(r'<p class="legend"><b>([^<]+)</b>', timeline_of(document))
    assert titles == [
        "force [N]",
        "tracking error [mm]",
        "joint torques, of their limits [%]",
        "closure [%]",
        "orientation error [°]",
    ]
    torques = lane_of(document, "joint torques, of their limits")
    heights = {f"j{k}": curve_of(torques, f"j{k}")[:, 1] for k in range(7)}
    # 0.2 + 0.1 sin: every joint passes 10 % and 30 % of a lane that reaches from 0 to 100 %.
    for height in heights.values():
        assert np.ptp(height) == pytest.approx(20.0 * 44.0 / 56.0, abs=1.0)
    closure = curve_of(lane_of(document, "closure"), "c0")
    assert closure[0, 1] - closure[-1, 1] == pytest.approx(100.0 * 24.0 / 36.0, abs=1.0)
    error = curve_of(lane_of(document, "tracking error"), "c0")
    assert np.ptp(error[:, 1]) == pytest.approx(100.0 * 32.0 / 44.0, abs=1.0)


def test_the_timeline_marks_the_events():
    saturated = np.zeros(1000)
    saturated[731:] = 1.0
    plain = synthetic(success=True, frames=30, motion={"separated": {"object": "light_sphere_01", "time": 4.5}})
    plain = replace(plain, signals=dict(plain.signals) | {"sensor_saturated": saturated})
    marks = re.findall(r'<i class="mark (\w+)" style="left:([\d.]+)%" title="([^"]+)"', page(plain))
    assert marks == [
        ("end", "22.00", "2.20 s: approach: touch force"),
        ("separation", "45.00", "4.50 s: light_sphere_01 separates from the pile"),
        ("end", "64.00", "6.40 s: push: grasp force"),
        ("saturation", "73.10", "7.31 s: the wrist sensor is at its range"),
        ("end", "76.00", "7.60 s: grasp: closed"),
        ("end", "100.00", "10.00 s: lift: lifted"),
    ]
    failed = page(synthetic(success=False, frames=30))
    assert '<i class="mark failure" style="left:100.00%" title="6.40 s: push: travel limit of 0.36 m"' in failed


def flat(force, **config):
    """A recording of two seconds with one force signal."""
    time = np.linspace(0.0, 2.0, 50)
    return still(
        [Shape("sphere", (0.03,))],
        signal_time=time,
        signals={"push_force": force * np.sin(20.0 * time), "tracking_error": 1e-3 * time},
        meta={"config": config},
    )


def test_the_sensors_noise_does_not_fill_the_lane():
    heights = {force: np.ptp(curve_of(lane_of(page(flat(force)), "force"), "c0")[:, 1]) for force in (0.05, 40.0)}
    assert heights[0.05] < 6.0
    assert heights[40.0] > 80.0


def test_a_failed_primitive_is_marked():
    document = page(synthetic(success=False, frames=30))
    assert 'class="band p1 failed"' in document
    assert 'class="band p0 failed"' not in document


def test_thinning_a_signal_keeps_its_peak():
    time = np.linspace(0.0, 10.0, 5000)
    value = np.sin(time)
    value[3217] = 80.0
    short_time, short_value = thinned(time, value)
    assert len(short_time) <= 502
    assert (np.diff(short_time) > 0.0).all()
    assert short_value.max() == 80.0
    assert short_time[np.argmax(short_value)] == time[3217]
    few_time, few_value = thinned(time, value, 0.02)
    assert len(few_time) < 60
    assert np.abs(np.interp(short_time, few_time, few_value) - short_value).max() <= 0.02


def test_ticks_are_round_numbers():
    assert nice_ticks(0.0, 10.0, 10) == [float(k) for k in range(11)]
    assert nice_ticks(-21.0, 23.0, 4) == [-20.0, 0.0, 20.0]
    assert nice_ticks(0.0, 0.23, 4) == pytest.approx([0.0, 0.1, 0.2])
    assert nice_ticks(1.0, 1.0, 4) == []


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
    assert document.count("</script>") == 5
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


def test_the_summary_reads_what_is_there():
    summary = summarize(
        {"config": {"strategy": {"grasp_force": 8, "alpha_deg": 0.0, "beta_deg": 15.0}}, "success": True}
    )
    assert summary.grasp_force == 8.0
    assert ("F_grasp", "8 N") in summary.facts
    assert ("beta", "15°") in summary.facts
    assert "alpha" not in dict(summary.facts)
    assert summary.verdict == "Success"
    line = summarize(
        {"config": {"program": "line", "hand": "shovel", "strategy": {"grasp_force": 8}}, "grasp_force": 8}
    )
    assert line.grasp_force is None
    assert line.facts == (("hand", "shovel"),)


def test_the_summary_leaves_out_what_played_no_part():
    config = {
        "program": "line",
        "pile": {"object": "cube", "count": 0},
        "line": {"speed": 0.2},
        "strategy": {"speed": 0.1},
    }
    assert dict(summarize({"config": config}).facts) == {"count": "0", "line speed": "0.2 m/s"}
    config |= {"program": "grasp", "pile": {"object": "cube", "count": 3}}
    assert dict(summarize({"config": config}).facts) == {"object": "cube", "count": "3", "speed": "0.1 m/s"}


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
