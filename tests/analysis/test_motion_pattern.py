"""The motion pattern: known ways give known numbers, and every outcome of an attempt gives some."""

import json
import runpy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import pilegrasp_ctrl
from motion_figure import BLUE, RED, pattern_figure
from pilegrasp_ctrl.analysis.force_chains import force_chains
from pilegrasp_ctrl.analysis.funnel import Funnel
from pilegrasp_ctrl.analysis.motion import annotate, measure
from pilegrasp_ctrl.analysis.motion_field import X_EDGES, Y_EDGES, MotionField
from pilegrasp_ctrl.analysis.motion_pattern import MotionPattern, markdown
from pilegrasp_ctrl.analysis.push_motion import PushMotion
from pilegrasp_ctrl.analysis.verdict import verdict
from pilegrasp_ctrl.contacts import Contacts
from pilegrasp_ctrl.episode import run
from pilegrasp_ctrl.recording import Body, Recording, Shape
from pilegrasp_ctrl.study.attempt import load_measure
from places import STUDIES
from pushed_pile import (
    BEGIN,
    END,
    FRONT,
    HALF_WIDTH,
    RADIUS,
    SPEED,
    at_rest,
    moving,
    push_recording,
    pushed,
    yaw_quaternion,
)
from synthetic_recording import synthetic

SCRIPT = STUDIES / "motion_pattern.py"

RESTLESS = moving(0.3, 0.3, 0.02, 0.0)
"""Far from the hand; it moves from the begin of the push on, so that the pile counts as moving."""


def crowd(vx: float, slope: float = 0.0) -> dict:
    """Rows of objects over the whole width; they move along the push at vx and away from its middle by slope * y."""
    ways = {"far": RESTLESS}
    for i, x in enumerate(np.arange(0.01, 0.4, 0.03)):
        for j, y in enumerate(np.arange(-0.12, 0.121, 0.03)):
            ways[f"o{i}_{j}"] = moving(x, y, vx, slope * y)
    return ways


@pytest.mark.parametrize("alpha", [0.0, 0.6])
def test_approach_is_how_fast_the_hand_gains_on_what_lies_before_it(alpha):
    standing = measure(push_recording({"far": RESTLESS, "a": at_rest(0.21, 0.02)}, alpha=alpha))
    carried = measure(push_recording({"a": moving(0.05, 0.02, SPEED, 0.0)}, alpha=alpha))
    half = measure(push_recording({"a": moving(0.11, -0.04, 0.5 * SPEED, 0.0)}, alpha=alpha))
    assert standing["approach_speed"] == pytest.approx(SPEED, rel=1e-4)
    assert carried["approach_speed"] == pytest.approx(0.0, abs=1e-6)
    assert half["approach_speed"] == pytest.approx(0.5 * SPEED, rel=1e-4)
    assert half["hand_speed"] == pytest.approx(SPEED, rel=1e-4)


def test_what_is_far_ahead_or_under_way_in_the_hand_does_not_count_as_approaching():
    found = measure(push_recording({"a": moving(0.5, 0.0, 0.01, 0.0), "b": moving(-0.02, 0.0, SPEED, 0.0)}))
    assert found["approach_speed"] is None


@pytest.mark.parametrize("alpha", [0.0, -0.4])
def test_spread_is_the_way_off_the_nearer_end_of_the_leading_edge(alpha):
    # It keeps its place relative to the hand, so that the direction from the edge's end stays (3, 4) / 5.
    ways = {"a": moving(0.03, HALF_WIDTH + 0.04, SPEED, 0.0), "b": moving(0.03, -HALF_WIDTH - 0.04, SPEED, 0.0)}
    found = measure(push_recording(ways, alpha=alpha))
    assert found["spread_speed"] == pytest.approx(0.6 * SPEED, rel=1e-4)
    assert found["spread_forward"] == pytest.approx(SPEED, rel=1e-4)
    assert found["spread_sideways"] == pytest.approx(0.0, abs=1e-6)
    assert found["approach_speed"] is None


def test_sideways_means_away_from_the_middle_on_both_sides():
    found = measure(push_recording({"a": moving(0.3, 0.1, 0.0, 0.02), "b": moving(0.3, -0.1, 0.0, -0.02)}))
    assert found["spread_sideways"] == pytest.approx(0.02, rel=1e-4)


def test_the_clock_starts_when_the_pile_moves_and_stops_when_the_hand_does():
    late = push_recording({"a": lambda t: np.stack([0.2 + 0.05 * np.clip(t - 2.0, 0, 1), 0 * t], axis=-1)})
    push = PushMotion.of(late)
    assert push.time[0] == pytest.approx(2.0)
    assert push.time[-1] == pytest.approx(END)
    row = {"name": "push", "trigger": "travel limit: never", "start": BEGIN, "end": END + 0.5}
    waited = PushMotion.of(push_recording({"a": RESTLESS}, outcomes=[row]))
    assert waited.time[-1] == pytest.approx(END)
    assert not waited.triggered


def test_the_field_knows_each_cell_and_fields_add_up():
    push = PushMotion.of(push_recording({"a": moving(0.05, 0.0, SPEED, 0.0), "b": moving(0.05, 0.1, SPEED, 0.02)}))
    field = MotionField.of(push)
    cell = np.searchsorted(X_EDGES, 0.05) - 1, np.searchsorted(Y_EDGES, 0.0) - 1
    assert field.mean_absolute()[cell] == pytest.approx([SPEED, 0.0], abs=1e-6)
    assert field.mean_relative()[cell] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert field.time.sum() == pytest.approx(2 * (END - BEGIN))
    assert field.count.sum() == 2 * (push.time.size - 1)
    assert np.isnan(field.mean_absolute()[0, 0]).all()
    both = field + field
    assert both.attempts == 2
    assert both.half_width == pytest.approx(HALF_WIDTH)
    assert np.array_equal(both.count, 2 * field.count)
    assert both.mean_relative()[cell] == pytest.approx(field.mean_relative()[cell])


def test_a_pile_at_rest_flows_into_the_hand_over_its_own_width():
    assert measure(push_recording(crowd(0.0)))["funnel_width"] == pytest.approx(2 * HALF_WIDTH, rel=0.02)


@pytest.mark.parametrize("slope", [0.3, -0.3])
def test_objects_that_give_way_narrow_the_funnel_and_objects_that_come_together_widen_it(slope):
    # dy/dx = u_y / u_x = -slope y / SPEED: stream lines are exponentials; y itself grows meanwhile, by the factor g.
    field = MotionField.of(PushMotion.of(push_recording(crowd(0.0, slope))))
    width = Funnel.of(field).width_at(4 * RADIUS)
    assert (width - 2 * HALF_WIDTH) * slope < 0.0
    steeper = Funnel.of(MotionField.of(PushMotion.of(push_recording(crowd(0.0, 2 * slope))))).width_at(4 * RADIUS)
    assert (steeper - width) * slope < 0.0
    assert Funnel.of(field).width_at(0.0) == pytest.approx(2 * HALF_WIDTH)


def test_a_pile_that_is_carried_along_has_no_funnel():
    found = measure(push_recording(crowd(SPEED)))
    assert found["funnel_width"] is None
    assert found["mouth_width"] == pytest.approx(2 * HALF_WIDTH)


def sliding_in(x: float, y: float, stop: float):
    """Stand until the leading edge has passed by `stop` [m], then go with the hand."""
    return lambda t: np.stack([np.maximum(x, SPEED * pushed(t) - stop), y + 0 * t], axis=-1)


def test_the_object_in_the_middle_has_separated_since_the_hand_is_beneath_it():
    ways = {"far": RESTLESS, "edge": sliding_in(0.05, 0.03, 0.01), "deep": sliding_in(0.1, 0.0, 0.04)}
    found = measure(push_recording(ways, held=("deep",)))
    assert found["separated"]["object"] == "deep"
    assert found["separated"]["time"] == pytest.approx(BEGIN + 1.0, abs=0.02)
    assert found["separated"]["stabilised"] == pytest.approx(BEGIN + 1.4, abs=0.02)
    assert found["in_hand"] == ["edge", "deep"]
    assert found["held"] == ["deep"]
    assert found["agreed"] is True


@pytest.mark.parametrize("aside", [0.8 * HALF_WIDTH, -0.025])
def test_of_two_that_came_in_side_by_side_the_one_nearer_to_the_middle_has_separated(aside):
    ways = {"far": RESTLESS, "deeper": sliding_in(0.05, aside, 0.08), "middle": sliding_in(0.15, 0.02, 0.03)}
    found = measure(push_recording(ways))
    assert found["in_hand"] == ["deeper", "middle"]
    assert found["separated"]["object"] == "middle"


def test_a_rigid_hand_keeps_what_lies_deepest():
    ways = {"far": RESTLESS, "deeper": sliding_in(0.05, -0.025, 0.08), "middle": sliding_in(0.15, 0.02, 0.03)}
    found = measure(push_recording(ways, rigid=True))
    assert found["in_hand"] == ["deeper", "middle"]
    assert found["separated"]["object"] == "deeper"


@pytest.mark.parametrize("beta", [0.4, -0.4])
def test_the_middle_is_that_of_a_hand_that_is_turned_against_its_way(beta):
    x, y = np.array([np.cos(beta), np.sin(beta)]), np.array([-np.sin(beta), np.cos(beta)])
    own = np.array([0.2 - FRONT, 0.0]) + (FRONT - 0.09) * x
    beside = own + 0.03 * np.sign(beta) * y
    found = measure(push_recording({"far": RESTLESS, "own": at_rest(*own), "beside": at_rest(*beside)}, beta=beta))
    assert found["in_hand"] == ["own", "beside"]
    assert found["separated"]["object"] == "own"
    assert found["mouth_width"] == pytest.approx(2 * HALF_WIDTH)


@pytest.mark.parametrize("strategy", [{"beta_deg": "20"}, {"beta_deg": 10**400}, {}, None])
def test_an_angle_that_is_no_number_counts_as_none(strategy):
    ways = {"far": RESTLESS, "a": at_rest(0.17, 0.0)}
    found = measure(push_recording(ways, config={"strategy": strategy}))
    assert found == measure(push_recording(ways))


def tip_and_deep(pair: tuple[str, str], x: float, y: float, alpha: float = 0.0) -> dict:
    """Measure a push that leaves one object before the leading edge and one in the hand, 40 mm beside its middle.

    Args:
        pair: names of the bodies that touch in all frames.
        x: how far before the edge the former lies at the end [m].
        y: how far to the left [m].
        alpha: of the push [rad].
    """
    ways = {"far": RESTLESS, "tip": at_rest(0.2 + x, y), "deep": sliding_in(0.1, -0.04, 0.04)}
    recording = push_recording(ways, alpha=alpha, held=("tip",))
    number = {body.name: index for index, body in enumerate(recording.bodies)}
    frames = recording.frame_time.size
    contacts = Contacts(
        np.arange(frames + 1),
        np.tile([number[name] for name in pair], (frames, 1)),
        np.zeros((frames, 3)),
        np.ones((frames, 3)),
    )
    return measure(replace(recording, contacts=contacts))


@pytest.mark.parametrize("alpha", [0.0, 2.5])
@pytest.mark.parametrize("pair", [("tip", "palm"), ("palm", "tip")])
def test_an_object_on_the_fingertips_right_before_the_middle_comes_before_one_beside_it(pair, alpha):
    found = tip_and_deep(pair, 0.2 * RADIUS, 0.0, alpha)
    assert found["separated"]["object"] == "tip"
    assert found["separated"]["stabilised"] is None
    assert found["separated"]["time"] == pytest.approx(END - 0.8 * RADIUS / SPEED, abs=0.02)
    assert found["in_hand"] == ["tip", "deep"]
    assert found["agreed"] is True


@pytest.mark.parametrize(
    ("pair", "x", "y"),
    [
        (("tip", "far"), 0.2 * RADIUS, 0.0),
        (("tip", "deep"), 0.2 * RADIUS, 0.0),
        (("far", "palm"), 0.2 * RADIUS, 0.0),
        (("tip", "palm"), 1.2 * RADIUS, 0.0),
        (("tip", "palm"), 0.2 * RADIUS, HALF_WIDTH + 0.005),
    ],
    ids=["touches an object", "touches what is in the hand", "not touched", "before the hand", "beside the hand"],
)
def test_what_the_fingertips_do_not_touch_before_the_hand_is_not_caught(pair, x, y):
    found = tip_and_deep(pair, x, y)
    assert found["separated"]["object"] == "deep"
    assert found["in_hand"] == ["deep"]


def test_the_farther_an_object_lies_before_the_edge_the_nearer_to_the_middle_it_must_be():
    # |y| + 1.5 max(x + r / 2, 0): 45 against 40 mm; 15 against 20 and 5 mm.
    assert tip_and_deep(("tip", "palm"), 0.5 * RADIUS, 0.0)["separated"]["object"] == "deep"
    inside = {"far": RESTLESS, "edge": sliding_in(0.1, 0.0, 0.005), "deep": sliding_in(0.05, 0.02, 0.04)}
    assert measure(push_recording(inside))["separated"]["object"] == "edge"
    inside["deep"] = sliding_in(0.05, 0.005, 0.04)
    assert measure(push_recording(inside))["separated"]["object"] == "deep"


@pytest.mark.parametrize(
    ("slants", "kept"),
    [((20.0,), "right"), ((-20.0,), "left"), ((0.0,), "left"), ((45.0, -45.0), "left"), ((90.0, 20.0), "right")],
    ids=["nearer on the right", "nearer on the left", "square", "corner", "beside a wall along the way"],
)
@pytest.mark.parametrize("alpha", [0.0, 2.0])
def test_before_a_slanted_wall_the_hand_keeps_what_lies_where_it_is_nearer(slants, kept, alpha):
    ways = {"far": RESTLESS, "left": sliding_in(0.1, 0.015, 0.03), "right": sliding_in(0.1, -0.025, 0.03)}
    recording = push_recording(ways, alpha=alpha)
    frames = recording.frame_time.size
    walls, turns = [], []
    for slant in slants:
        # The hand points to the left of the wall's normal by the slant.
        walls.append(Body(f"wall_{slant}", "support", (Shape("box", (0.01, 1.0, 0.1)), Shape("plane", (1.0, 1.0)))))
        turns.append(np.tile(yaw_quaternion(alpha - np.radians(slant)), (frames, 1, 1)))
    found = measure(
        replace(
            recording,
            bodies=(*recording.bodies, *walls),
            body_position=np.concatenate([recording.body_position, np.zeros((frames, len(walls), 3))], axis=1),
            body_quaternion=np.concatenate([recording.body_quaternion, *turns], axis=1),
        )
    )
    assert found["in_hand"] == ["left", "right"]
    assert found["separated"]["object"] == kept


def test_a_thumb_above_the_objects_is_no_part_of_the_leading_edge():
    recording = push_recording({"far": RESTLESS, "a": at_rest(0.17, 0.0)})
    thumb = Body("thumb", "hand", (Shape("box", (0.03, 0.02, 0.01), (FRONT, -0.1, 2.5 * RADIUS)),))
    bodies = tuple(thumb if body.name == "thumb" else body for body in recording.bodies)
    found = measure(replace(recording, bodies=bodies))
    assert found == measure(recording)
    assert found["mouth_width"] == pytest.approx(2 * HALF_WIDTH)


def test_the_speed_is_that_of_the_slide_where_a_wall_stops_the_hand_at_the_end():
    recording = push_recording({"far": RESTLESS})
    tool = recording.signals["tool_position"].copy()
    tool[:, 0] = np.minimum(tool[:, 0], tool[0, 0] + 0.7 * (tool[-1, 0] - tool[0, 0]))
    stopped = replace(recording, signals=recording.signals | {"tool_position": tool})
    assert measure(stopped)["hand_speed"] == pytest.approx(SPEED, rel=1e-4)


def test_an_object_that_still_slides_in_has_not_stabilised():
    found = measure(push_recording({"far": RESTLESS, "a": at_rest(0.17, 0.0)}))
    assert found["separated"]["object"] == "a"
    assert found["separated"]["stabilised"] is None


@pytest.mark.parametrize(("x", "y"), [(0.0, HALF_WIDTH + 0.01), (0.25, 0.0), (-0.13 + 0.2, HALF_WIDTH * 2)])
def test_beside_or_before_the_hand_nothing_has_separated(x, y):
    found = measure(push_recording({"far": RESTLESS, "a": moving(x, y, SPEED * (x < 0.1), 0.0)}, held=("a",)))
    assert found["separated"] is None
    assert found["agreed"] is False


def test_nothing_after_the_push_decides_what_separated():
    ways = {"far": RESTLESS, "edge": sliding_in(0.05, 0.03, 0.01), "deep": sliding_in(0.1, 0.0, 0.04)}
    recording = push_recording(ways, held=("deep",))
    position = recording.body_position.copy()
    later = recording.frame_time > END + 1e-9
    position[later, 1:] += [0.3, -0.2, 0.0]
    changed = measure(replace(recording, body_position=position))
    assert changed["held"] == []
    assert {k: v for k, v in changed.items() if k not in ("held", "agreed")} == {
        k: v for k, v in measure(recording).items() if k not in ("held", "agreed")
    }


def one_frame(recording: Recording) -> Recording:
    return replace(
        recording,
        frame_time=recording.frame_time[:1],
        body_position=recording.body_position[:1],
        body_quaternion=recording.body_quaternion[:1],
        contacts=None,
    )


EMPTY = {
    "synthetic": synthetic(success=False),
    "no objects": synthetic(objects=0),
    "failed approach": synthetic(outcomes=[{"name": "approach", "status": "failed", "start": 0.5, "end": 2.0}]),
    "no outcomes": synthetic(outcomes=None),
    "garbled outcomes": synthetic(outcomes=["push", {"name": "push", "start": None, "end": "soon"}]),
    "push without a trigger": synthetic(outcomes=[{"name": "push", "start": 2.2, "end": 6.4}]),
    "push of no length": synthetic(outcomes=[{"name": "push", "start": 2.2, "end": 2.2}]),
    "push beyond the recording": synthetic(outcomes=[{"name": "push", "start": 90.0, "end": 99.0}]),
    "one frame": one_frame(synthetic()),
    "no signals": replace(synthetic(), signals={}),
    "no signal rows": replace(
        synthetic(),
        signal_time=np.zeros(0),
        signals={name: np.zeros((0, 3)) for name in ("tool_position", "reference_position")},
    ),
    "pile at rest": push_recording({"a": at_rest(0.5, 0.0)}),
    "no config": push_recording({"a": RESTLESS}, held=("a",), config=None),
    "no hand": replace(
        push_recording({"a": RESTLESS}),
        bodies=tuple(replace(body, role="object") for body in push_recording({"a": RESTLESS}).bodies),
    ),
}


@pytest.mark.parametrize("recording", EMPTY.values(), ids=EMPTY.keys())
def test_every_outcome_gives_the_same_keys(recording):
    found = measure(recording)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found.keys() - {"force_chains"} == measure(push_recording(crowd(0.0))).keys()
    assert isinstance(found["triggered"], bool)


def test_where_there_was_no_push_there_is_no_pattern():
    found = measure(EMPTY["failed approach"])
    assert found["triggered"] is False
    assert {found[name] for name in ("approach_speed", "spread_speed", "funnel_width", "separated")} == {None}


def test_annotating_adds_the_pattern_and_nothing_else():
    recording = push_recording({"far": RESTLESS, "a": at_rest(0.17, 0.0)})
    annotated = annotate(recording)
    assert annotated.meta["motion"] == measure(recording)
    assert {**annotated.meta, "motion": None} == {**recording.meta, "motion": None}
    assert np.array_equal(annotated.body_position, recording.body_position)
    assert annotate(EMPTY["failed approach"]) is EMPTY["failed approach"]


def with_contacts(bodies: list[tuple[int, int]], forces: list[list[float]], walls: int = 0) -> dict:
    """Force chains of four objects (bodies 1 to 4) with the same contacts in each frame."""
    ways = {f"o{k}": moving(0.05 + 0.06 * k, 0.0, 0.02, 0.0) for k in range(1, 5)}
    recording = push_recording(ways, rigid=True)
    wall = replace(recording.bodies[0], name="wall", role="support")
    frames = recording.frame_time.size
    contacts = SimpleNamespace(
        start=np.arange(frames + 1) * len(bodies),
        bodies=np.tile(np.array(bodies, dtype=np.int32).reshape(-1, 2), (frames, 1)),
        force=np.tile(np.array(forces, dtype=np.float32).reshape(-1, 3), (frames, 1)),
    )
    scene = SimpleNamespace(contacts=contacts, bodies=(*recording.bodies, wall), frame_time=recording.frame_time)
    return force_chains(scene, PushMotion.of(recording))


def test_a_chain_follows_the_strong_contacts_from_the_hand_to_the_wall():
    pairs = [(0, 1), (1, 2), (2, 3), (3, 4), (3, 5)]
    strong = [[-5.0, 0, 0], [-5.0, 0, 0], [-5.0, 0, 0], [0.1, 0, 0], [-5.0, 0, 1.0]]
    found = with_contacts(pairs, strong)
    assert found == {"objects": 3.0, "to_support": 1.0, "at_end": ["o1", "o2", "o3"]}
    resting = [*strong[:4], [0.1, 0.0, 5.0]]
    assert with_contacts(pairs, resting)["to_support"] == 0.0


def test_a_weak_contact_ends_a_chain():
    found = with_contacts([(0, 1), (1, 2), (3, 4)], [[-5.0, 0, 0], [0.1, 0, 0], [9.0, 0, 0]])
    assert found["at_end"] == ["o1"]
    untouched = with_contacts([(3, 4)], [[9.0, 0, 0]])
    assert untouched == {"objects": None, "to_support": None, "at_end": []}


def test_without_contacts_there_are_no_chains():
    recording = replace(push_recording({"a": RESTLESS}))
    assert force_chains(recording, PushMotion.of(recording)) is None
    assert "force_chains" not in measure(recording)


def rows(approach: list[float], spread: list[float], agreed: list[bool | None]) -> list[dict]:
    return [
        {"approach_speed": a, "spread_speed": s, "held": [] if g is None else ["a"], "agreed": g}
        for a, s, g in zip(approach, spread, agreed, strict=True)
    ]


def test_the_verdict_follows_the_numbers():
    fast, wide, narrow = [0.05, 0.06, 0.055], [0.03, 0.031, 0.032], [0.02, 0.021, 0.022]
    good = {"none": rows(fast, wide, [None] * 3), "wall": rows(fast, narrow, [True] * 3)}
    answer = verdict(good | {"corner": rows(fast, narrow, [True] * 3)})
    assert {name: part["verdict"] for name, part in answer.items()} == dict.fromkeys(answer, "holds")
    swapped = {"none": good["wall"], "wall": good["none"], "corner": rows([-x for x in fast], wide, [False] * 3)}
    worse = verdict(swapped)
    assert worse["wall"]["verdict"] == "fails"
    assert worse["approach"]["verdict"] == "fails"
    assert worse["separation"]["agreed"] == 3
    assert worse["separation"]["verdict"] == "fails"
    assert worse["separation"]["ci_low"] < 0.5 < worse["separation"]["ci_high"]
    nothing = verdict(dict.fromkeys(("none", "wall", "corner"), rows([None], [None], [None])))
    assert {part["verdict"] for part in nothing.values()} == {"not decided"}


def test_a_condition_is_summed_up_and_drawn(tmp_path):
    recordings = (push_recording(crowd(0.02, 0.1), held=("o1_4",)) for _ in range(2))
    pattern = MotionPattern.of("wall", recordings)
    bare = MotionPattern.of("none", [EMPTY["failed approach"]])
    summary = pattern.summary()
    assert (summary["attempts"], summary["triggered"], summary["held"]) == (2, 2, 2)
    assert summary["approach_speed"]["mean"] == pytest.approx(0.08, rel=1e-3)
    assert pattern.field.attempts == 2
    assert bare.field is None
    assert "chain_objects" not in summary
    chained = [row | {"force_chains": {"objects": 2.5, "to_support": 0.4, "at_end": []}} for row in pattern.measures]
    assert "| chains at a wall [% of the time] | 40 ± 0 |" in markdown([replace(pattern, measures=tuple(chained))])
    table = markdown([pattern, bare])
    assert "| approach speed [mm/s] | 80 ± 0 | none |" in table.splitlines()
    figure = pattern_figure([pattern, bare])
    figure.savefig(tmp_path / "pattern.png")
    assert (tmp_path / "pattern.png").stat().st_size > 10_000
    before, beside = figure.axes[0].collections[:2]
    assert len(before.U) > 20
    assert (before.U < 0.0).all()
    assert (beside.U > 0.0).all()
    assert [line.get_color() for line in figure.axes[0].lines] == [RED, RED]
    assert BLUE != RED
    assert not figure.axes[1].collections


def test_a_study_finds_the_measure_by_its_name():
    assert load_measure("pilegrasp_ctrl.analysis.motion.measure") is measure


def test_the_script_measures_three_conditions(tmp_path, monkeypatch, capsys):
    asked = []

    def attempted(name, *, seed, record, overrides):
        asked.append((name, seed, overrides["support.kind"]))
        recording = push_recording(crowd(0.01 * seed, 0.1), held=("o1_4",))
        return SimpleNamespace(recording=recording if record else None)

    monkeypatch.setattr(pilegrasp_ctrl, "run", attempted)
    monkeypatch.setattr("sys.argv", ["motion_pattern.py", "1", "3", str(tmp_path)])
    runpy.run_path(str(SCRIPT), run_name="__main__")
    assert asked == [("spheres_wall", seed, kind) for kind in ("none", "wall", "corner") for seed in (1, 2)]
    written = json.loads((tmp_path / "motion_pattern.json").read_text())
    assert [row["condition"] for row in written["conditions"]] == ["none", "wall", "corner"]
    assert written["verdict"]["approach"]["verdict"] == "holds"
    assert (tmp_path / "motion_pattern.png").exists()
    assert "| attempts | 2 | 2 | 2 |" in capsys.readouterr().out


@pytest.fixture(scope="module")
def attempt():
    return run("spheres_wall", seed=0, record=True, overrides={"pile.count": 5})


def test_a_real_attempt_shows_the_pattern(attempt):
    found = measure(attempt.recording)
    push = next(outcome for outcome in attempt.outcomes if outcome.name == "push")
    assert found["triggered"] is (push.trigger == "grasp force")
    assert len(found["held"]) == attempt.grasped
    assert 0.09 < found["hand_speed"] < 0.11
    assert 0.09 < found["mouth_width"] < 0.12
    assert 0.0 < found["approach_speed"] < found["hand_speed"] * 1.5
    assert found["separated"] is not None
    assert push.start < found["separated"]["time"] <= push.end
