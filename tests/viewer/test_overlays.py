"""The overlays of the page, without a browser: contacts, fingers, the push's funnel, the wrist wrench."""

from __future__ import annotations

import base64
import json
import re
import struct
import zlib
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import umsgpack
from scipy.spatial.transform import Rotation

from odd_recordings import ODD_RECORDINGS
from pilegrasp_ctrl import cli
from pilegrasp_ctrl.analysis.motion import annotate
from pilegrasp_ctrl.analysis.motion_field import Funnel, MotionField
from pilegrasp_ctrl.analysis.push_motion import PushMotion
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.recording import Body, Recording, Shape
from pilegrasp_ctrl.recording_parts import Contacts
from pilegrasp_ctrl.sim.readout import MIN_FORCE, ContactForces
from pilegrasp_ctrl.viewer import page, write, write_html
from pilegrasp_ctrl.viewer.page.limits import MAX_FRAMES
from pilegrasp_ctrl.viewer.page.motion import forward, push_frame
from pilegrasp_ctrl.viewer.scene.commands import commands, node_path, unpack
from pilegrasp_ctrl.viewer.scene.overlays import contact_block
from pilegrasp_ctrl.viewer.scene.shapes import fingers, tubes
from pushed_pile import FRONT, HALF_WIDTH, RESTLESS, SPEED, crowd, push_recording
from synthetic_recording import PHASES, synthetic


@pytest.fixture(scope="module")
def attempt():
    return synthetic(frames=60)


def read_block(block):
    """Contacts as the page's script reads them: count of each frame, positions, forces, bodies, kinds."""
    (frames,) = struct.unpack_from("<I", block)
    count = np.frombuffer(block, "<u2", frames, 4)
    total, at = int(count.sum()), 4 + 2 * frames
    position = np.frombuffer(block, "<i2", 3 * total, at).reshape(-1, 3) * 1e-4
    force = np.frombuffer(block, "<i2", 3 * total, at + 6 * total).reshape(-1, 3) * 1e-2
    bodies = np.frombuffer(block, "<u2", 2 * total, at + 12 * total).reshape(-1, 2)
    return count, position, force, bodies, np.frombuffer(block, "u1", total, at + 16 * total)


def test_the_block_of_contacts_holds_them_to_a_tenth_of_a_millimeter(attempt):
    count, position, force, bodies, kind = read_block(contact_block(attempt))
    np.testing.assert_array_equal(count, np.diff(attempt.contacts.start))
    np.testing.assert_allclose(position, attempt.contacts.position, atol=0.51e-4)
    np.testing.assert_allclose(force, attempt.contacts.force, atol=0.51e-2)
    np.testing.assert_array_equal(bodies, attempt.contacts.bodies)
    assert kind[:3].tolist() == [0, 2, 1]


def test_contacts_that_do_not_fit_the_block_are_left_out_or_cut(attempt):
    first = int(np.flatnonzero(np.diff(attempt.contacts.start))[0])
    position, force = (np.array(getattr(attempt.contacts, name)) for name in ("position", "force"))
    position[0, 0], force[1] = 1e30, (0.0, -1e30, 2.0)
    wild = Contacts(attempt.contacts.start, attempt.contacts.bodies, position, force)
    count, _, found, *_ = read_block(contact_block(replace(attempt, contacts=wild)))
    assert count[first] == 2
    np.testing.assert_allclose(found[0], (0.0, -327.67, 2.0))


def test_a_recording_without_contacts_has_a_page(attempt):
    assert contact_block(replace(attempt, contacts=None)) == b""
    assert "<html" in page(replace(attempt, contacts=None))


def test_the_contacts_of_a_simulation_carry_the_weight():
    xml = """<mujoco><option cone="elliptic" timestep="0.001"/><worldbody><geom type="plane" size="1 1 1"/>
      <body name="low" pos="0 0 0.03"><freejoint/><geom size="0.03" mass="0.2"/></body>
      <body name="high" pos="0 0 0.09"><freejoint/><geom size="0.03" mass="0.1"/></body>
      <body name="light" pos="1 0 0.03"><freejoint/><geom size="0.03" mass="0.001"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    for _ in range(300):
        mujoco.mj_step(model, data)
    roles = ("support", "object", "hand", "object")
    bodies = tuple(Body(model.body(k).name, role, ()) for k, role in enumerate(roles))
    pairs, position, force = ContactForces(model, bodies, np.arange(4)).read(data)
    by_pair = {tuple(pair): (f, p) for pair, f, p in zip(pairs.tolist(), force, position, strict=True)}
    # The hand comes before the object it lies on, and the object before the plane; 0.01 N is too little to show.
    assert by_pair.keys() == {(2, 1), (1, 0)}
    assert MIN_FORCE > 0.001 * 9.81
    np.testing.assert_allclose(by_pair[2, 1][0], (0.0, 0.0, 0.1 * 9.81), atol=0.02)
    np.testing.assert_allclose(by_pair[1, 0][0], (0.0, 0.0, 0.3 * 9.81), atol=0.03)
    assert by_pair[2, 1][1][2] == pytest.approx(0.06, abs=2e-3)


def test_a_finger_is_a_numbered_run_of_single_capsules():
    capsule, ball = Shape("capsule", (0.01, 0.02)), Shape("sphere", (0.01,))
    listed = [
        ("thumb_1", "hand", capsule),
        ("thumb_2", "hand", capsule),
        ("index_1", "hand", capsule),
        ("index_2", "hand", capsule),
        ("index_4", "hand", capsule),
        ("pad_1", "hand", ball),
        ("pad_2", "hand", ball),
        ("link_1", "arm", capsule),
        ("link_2", "arm", capsule),
        ("lone_1", "hand", capsule),
    ]
    bodies = tuple(Body(name, role, (shape,)) for name, role, shape in listed)
    assert fingers(bodies) == [[0, 1], [2, 3]]


@pytest.mark.parametrize("flip", [False, True])
def test_a_tube_runs_from_base_to_tip_for_either_direction_of_its_capsules(flip):
    turn = Rotation.from_euler("y", 90 if not flip else -90, degrees=True).as_quat(scalar_first=True)
    shape = Shape("capsule", (0.01, 0.02), (0.02, 0.0, 0.0), turn)
    bodies = tuple(Body(f"index_{k}", "hand", (shape,)) for k in (1, 2, 3))
    recording = Recording(
        {},
        bodies,
        [0.0],
        [[[0.0, 0.0, 0.0], [0.04, 0.0, 0.0], [0.08, 0.0, 0.0]]],
        np.tile([1.0, 0.0, 0.0, 0.0], (1, 3, 1)),
        [],
        {},
    )
    (finger,) = tubes(recording, ["a", "b", "c"])
    for segment in finger["segments"]:
        np.testing.assert_allclose(segment["ends"], [[0.0, 0.0, 0.0], [0.04, 0.0, 0.0]], atol=1e-5)
    assert [segment["path"] for segment in finger["segments"]] == ["a", "b", "c"]


def test_the_page_draws_the_leading_edge_and_the_funnel_that_were_measured(attempt):
    push = PushMotion.of(attempt)
    funnel = Funnel.of(MotionField.of(push))
    frame = push_frame(attempt)
    assert (frame["start"], frame["end"]) == (push.time[0], push.time[-1])
    assert PHASES[1][1] <= frame["start"] < frame["end"] <= PHASES[1][2]
    assert frame["half"] == pytest.approx(push.half_width, abs=1e-4)
    assert frame["length"] == pytest.approx(push.length, abs=1e-4)
    # The palm is 10 cm wide and the fingers' bases are 8 cm apart; their tips reach before the palm.
    assert 0.04 < frame["half"] < 0.06
    assert 0.0 < frame["edge"][0] < 0.1
    assert len(frame["funnel"]) == funnel.x.size > 10
    np.testing.assert_allclose(np.transpose(frame["funnel"]), [funnel.x, funnel.right, funnel.left], atol=1e-4)


@pytest.mark.parametrize("slope", [0.3, -0.3])
def test_the_funnel_on_the_page_is_the_exponential_of_the_motion(slope):
    # dy/dx = -slope y / SPEED at first, so the sides start at the edge's ends and lean by 3 times their distance.
    frame = push_frame(push_recording(crowd(0.0, slope)))
    x, right, left = np.transpose(frame["funnel"])
    assert (frame["edge"], frame["half"]) == (pytest.approx([FRONT, 0.0]), pytest.approx(HALF_WIDTH))
    assert (x[0], right[0], left[0]) == (0.0, -HALF_WIDTH, HALF_WIDTH)
    np.testing.assert_allclose(right, -left, atol=1e-3)
    lean = (left[4] - left[0]) / (x[4] - x[0])
    assert lean == pytest.approx(-slope * HALF_WIDTH / SPEED, rel=0.35)


def test_a_pile_that_is_carried_along_shows_no_funnel():
    frame = push_frame(push_recording(crowd(SPEED)))
    assert frame["funnel"] == [[0.0, -HALF_WIDTH, HALF_WIDTH]]


@pytest.mark.parametrize("alpha", [0.0, 90.0])
@pytest.mark.parametrize("beta", [0.0, 20.0, -30.0])
def test_the_page_looks_where_a_turned_hand_points(alpha, beta):
    recording = push_recording({"far": RESTLESS}, alpha=np.deg2rad(alpha), beta=np.deg2rad(beta))
    angle = np.arctan2(*reversed(forward(recording)))
    assert np.rad2deg(angle) == pytest.approx(alpha + beta, abs=1e-2)
    straight = push_frame(push_recording({"far": RESTLESS}, beta=np.deg2rad(beta)))
    assert push_frame(recording)["edge"] == pytest.approx(straight["edge"], abs=2e-4)


def test_a_recording_without_measured_motion_shows_no_funnel(attempt):
    assert push_frame(replace(attempt, meta={})) is None
    assert push_frame(replace(attempt, signals={})) is None
    bare = replace(attempt, bodies=tuple(replace(b, role="arm") if b.role == "hand" else b for b in attempt.bodies))
    assert push_frame(bare) is None
    still = np.tile(attempt.signals["tool_position"][:1], (len(attempt.signal_time), 1))
    assert push_frame(replace(attempt, signals=dict(attempt.signals) | {"tool_position": still})) is None
    assert forward(replace(attempt, meta={})) == [1.0, 0.0]


@pytest.mark.slow
@pytest.mark.parametrize("name", ODD_RECORDINGS)
def test_a_recording_that_the_analysis_cannot_read_is_still_a_page(name):
    assert "<html" in page(ODD_RECORDINGS[name])


def test_an_error_of_the_analysis_leaves_the_page_without_what_was_measured(attempt, monkeypatch):
    def fail(recording):
        raise ZeroDivisionError("odd")

    monkeypatch.setattr(PushMotion, "of", fail)
    with pytest.warns(RuntimeWarning, match="a measure that failed: ZeroDivisionError"):
        document = page(attempt)
    (data,) = json.loads(re.search(r'id="page-data">(.*?)</script>', document, flags=re.DOTALL)[1])
    assert [(one["push"], one["separated"]) for one in data["attempts"]] == [(None, None)]


def test_a_page_from_python_is_that_of_the_command(attempt, tmp_path):
    plain = replace(attempt, meta={key: value for key, value in attempt.meta.items() if key != "motion"})
    plain.save(tmp_path / "a.npz")
    write_html(plain, tmp_path / "python.html", sources=["a.npz"])
    assert cli.main(["export", str(tmp_path / "a.npz"), str(tmp_path / "command.html")]) == 0
    annotate(plain).save(tmp_path / "annotated.npz")
    write_html(Recording.load(tmp_path / "annotated.npz"), tmp_path / "annotated.html", sources=["a.npz"])
    pages = {(tmp_path / f"{name}.html").read_bytes() for name in ("python", "command", "annotated")}
    assert len(pages) == 1
    assert b'"separated":{"path":"/Objects/' in pages.pop()


def test_the_wrench_is_drawn_at_the_sensor_as_force_and_moment(attempt):
    signals = dict(attempt.signals) | {"wrench": np.tile([0, 0, 10.0, 0, 0.5, 0], (len(attempt.signal_time), 1))}
    stream = commands(replace(attempt, signals=signals))
    values = {
        (c["path"], c["property"]): c["value"]
        for c in stream
        if c["type"] == "set_property" and c["path"].startswith("/Overlays/wrench")
    }
    sensor = next(index for index, body in enumerate(attempt.bodies) if body.role == "sensor")
    for name, axis, length in (("force", (0.0, 0.0, 1.0), 0.10), ("moment", (0.0, 1.0, 0.0), 0.05)):
        root = f"/Overlays/wrench/{name}"
        np.testing.assert_allclose(values[root, "position"], attempt.body_position[0, sensor], atol=1e-6)
        turn = Rotation.from_quat(values[root, "quaternion"])
        np.testing.assert_allclose(turn.apply([0.0, 0.0, 1.0]), axis, atol=1e-6)
        assert values[f"{root}/shaft", "scale"][2] + values[f"{root}/head", "scale"][2] == pytest.approx(length)


def test_reference_and_tool_have_their_own_lines(attempt):
    lines = {c["path"]: c["object"] for c in commands(attempt) if c["path"].startswith("/Overlays/paths/")}
    ends = {}
    for path, document in lines.items():
        points = document["geometries"][0]["data"]["attributes"]["position"]["array"]
        ends[path.rpartition("/")[2]] = np.frombuffer(points.data, "<f4").reshape(-1, 3)[[0, -1]]
    for name in ("tool", "reference"):
        signal = attempt.signals[f"{name}_position"]
        np.testing.assert_allclose(ends[name][0], signal[0], atol=1e-4)
        np.testing.assert_allclose(ends[name][1], signal[-1], atol=5e-4)


def blocks_of(document, name):
    found = re.findall(rf'<script type="application/octet-stream" class="{name}">([^<]*)</script>', document)
    return [zlib.decompress(base64.b64decode(text)) for text in found]


def test_the_page_carries_stream_contacts_and_data_of_each_recording(attempt):
    other = synthetic(success=False, frames=40, objects=5)
    document = page(attempt, other)
    assert blocks_of(document, "contacts") == [contact_block(attempt), contact_block(other)]
    for block, shown in zip(blocks_of(document, "commands"), (attempt, other), strict=True):
        assert [umsgpack.packb(c) for c in unpack(block)[:5]]
        paths = [c["path"] for c in unpack(block) if c["type"] == "set_transform"]
        assert paths == [node_path(index, body) for index, body in enumerate(shown.bodies)]
    first, second = json.loads(re.search(r'id="page-data">(.*?)</script>', document, flags=re.DOTALL)[1])
    assert (first["end"], second["end"]) == (10.0, pytest.approx(6.4))
    # One clock: both timelines show the same window.
    assert re.findall(r'data-start="([\d.]+)" data-end="([\d.]+)"', document) == [("0.0000", "10.0000")] * 2
    assert document.count('class="panel"') == 2
    assert document.count("Arrows, marks and keys") == 1


@pytest.mark.slow
def test_the_separated_object_is_named_only_if_it_was_recorded(attempt):
    def told(motion):
        document = page(replace(attempt, meta={"motion": motion}))
        return json.loads(re.search(r'id="page-data">(.*?)</script>', document, flags=re.DOTALL)[1])[0]["attempts"][0][
            "separated"
        ]

    index = [body.name for body in attempt.bodies].index("light_sphere_03")
    found = told({"separated": {"object": "light_sphere_03", "time": 5.0}})
    assert found == {"path": node_path(index, attempt.bodies[index]), "time": 5.0}
    for motion in (None, 3, {"separated": None}, {"separated": {"object": "nobody", "time": 5.0}}):
        assert told(motion) is None


@pytest.mark.parametrize("config", [{"strategy": {"lift_height": 0.2}}, {"strategy": {"lift_height": "high"}}, None])
def test_the_command_finds_out_which_object_separated(attempt, tmp_path, config):
    replace(attempt, meta=dict(attempt.meta) | {"config": config}).save(tmp_path / "a.npz")
    assert cli.main(["export", str(tmp_path / "a.npz"), str(tmp_path / "a.html")]) == 0
    document = (tmp_path / "a.html").read_text(encoding="utf-8")
    found = json.loads(re.search(r'id="page-data">(.*?)</script>', document, flags=re.DOTALL)[1])[0]["attempts"][0][
        "separated"
    ]
    # Of the two balls in the hand before it closes, this one is nearer to its middle, 21 mm against 32 mm.
    index = [body.name for body in attempt.bodies].index("light_sphere_13")
    assert found["path"] == node_path(index, attempt.bodies[index])
    assert PHASES[1][1] < found["time"] < PHASES[1][2]


def test_a_recording_too_long_for_a_page_is_refused():
    frames = MAX_FRAMES + 1
    long = Recording(
        {},
        (Body("ball", "object", (Shape("sphere", (0.03,)),)),),
        np.arange(frames) / 30.0,
        np.zeros((frames, 1, 3)),
        np.tile([1.0, 0.0, 0.0, 0.0], (frames, 1, 1)),
        [],
        {},
    )
    with pytest.raises(ExportError, match=f"holds {frames} frames, and a page shows {MAX_FRAMES} at most"):
        page(long)


def test_two_recordings_go_into_a_page_only(attempt, tmp_path, capsys):
    for name in ("a.npz", "b.npz"):
        attempt.save(tmp_path / name)
    files = [str(tmp_path / name) for name in ("a.npz", "b.npz")]
    assert cli.main(["export", *files, str(tmp_path / "pair.html"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["beside"] == files[1]
    assert 'class="pair"' in (tmp_path / "pair.html").read_text(encoding="utf-8")
    for arguments in ([*files, str(tmp_path / "pair.png")], [*files, files[0], str(tmp_path / "pair.html")]):
        assert cli.main(["export", *arguments]) == 2
        assert "give one, or two for a page (.html)" in capsys.readouterr().err
    with pytest.raises(ExportError, match="only a page shows two recordings side by side"):
        write(attempt, tmp_path / "pair.gif", beside=attempt)
