"""Clocks, targets, memory and peers of the benchmark."""

import numpy as np
import pytest

from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.tasks.pose_task import pose_error
from pilegrasp_ctrl.validation.bench import peers
from pilegrasp_ctrl.validation.bench.clock import Timing, Work, garbage_kept, time_in_turns
from pilegrasp_ctrl.validation.bench.judgement import judge
from pilegrasp_ctrl.validation.bench.motion import ARMS, RATE, record_line
from pilegrasp_ctrl.validation.bench.result import LoopRow, Row
from pilegrasp_ctrl.validation.bench.ticks import allocations, impedance, operational_space

NAMES = [source.name for source in ARMS]


@pytest.fixture(scope="module")
def lines():
    return {source.name: record_line(source, source.load()) for source in ARMS}


def tick_row(key: str, ratio: float | None, table: str = "peer") -> Row:
    return Row(key=key, table=table, count=1, median_us=10.0, p99_us=55.0, worst_us=60.0, tail=2.5, ratio=ratio)


def test_targets_are_judged_by_what_was_measured():
    loop = {"phase": "push", "chunks": 1, "ratio_p10": 1.0, "ratio_p90": 2.0, "period_us": 1.0, "bare_us": 1.0}
    rows = [
        tick_row("wam7 operational space", 2.0, "tick"),
        tick_row("wam7 mink", 6.1),
        tick_row("wam7 pink", 5.9),
        tick_row("wam7 tsid", 0.5),
        tick_row("panda operational space", 2.0, "tick"),
    ]
    lines = [
        LoopRow(**loop | {"phase": phase}, ratio=ratio, control_us=1.0, glue_us=1.0, realtime_factor=7.5)
        for phase, ratio in (("push", 1.4), ("attempt", 1.5))
    ]
    verdicts = {target.name: (target.value, target.met) for target in judge(rows, lines)}
    assert verdicts["wam7: mink's tick over the project's"] == (6.1, True)
    assert verdicts["wam7: pink's tick over the project's"] == (5.9, False)
    assert verdicts["wam7: tick over tsid's"] == (2.0, False)
    assert verdicts["panda: tick over tsid's"] == (None, None)
    assert verdicts["closed loop over bare physics, push"] == (1.4, False)
    assert verdicts["closed loop over bare physics, attempt"] == (1.5, True)
    assert verdicts["real-time factor of an attempt, by processor time"] == (7.5, True)


def test_works_take_turns():
    order = []
    works = [Work(key, lambda index, key=key: order.append((key, index))) for key in "ab"]
    rounds = []
    with garbage_kept():
        timings = time_in_turns(works, 3, 1e-9, lambda: rounds.append(len(order)))
    turns = [key for position, (key, _) in enumerate(order) if position == 0 or order[position - 1][0] != key]
    # First each is warmed up, then there are three rounds.
    assert turns == ["a", "b"] * 4
    assert len(rounds) == 3
    assert all(timing.calls == 15 and len(timing.blocks) == 3 for timing in timings.values())


def test_the_statistics_are_those_of_the_durations():
    timing = Timing.of([np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 60.0])])
    assert timing.median == 3.5
    assert timing.worst == 60.0
    assert timing.blocks == (2.0, 5.0)


def test_one_long_break_does_not_make_a_tail():
    quiet, disturbed = np.ones(200), np.ones(200)
    disturbed[100] = 400.0
    assert Timing.of([disturbed, disturbed, quiet]).tail == 1.0
    assert Timing.of([np.linspace(1.0, 3.0, 201)] * 3).tail == pytest.approx(2.98 / 2.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("make", [operational_space, impedance])
def test_a_tick_leaves_no_memory_behind(lines, make, name):
    memory = allocations(make(lines[name]), 1000)
    # One float that every tick leaves would be 24,000 bytes; what the last tick keeps for the next differs a little.
    assert memory.growth_bytes < 12_000
    assert memory.growth_blocks < 200
    assert 0 < memory.kept_bytes <= memory.peak_bytes


def test_a_tick_that_keeps_memory_is_found():
    hoard = []
    memory = allocations(lambda index: hoard.append(np.zeros(10)), 100)
    assert memory.growth_bytes > 100 * 80
    assert memory.growth_blocks >= 100


@pytest.mark.parametrize("solver", ["daqp", "osqp"])
def test_the_naive_tick_solves_the_project_s_problem(lines, solver):
    """The Panda's line has no friction, singular postures or active limits, which would make the two differ."""
    line = lines["panda"]
    controller = OperationalSpaceController(line.arm, posture=line.source.posture, rate=RATE)
    naive = peers.naive_tick(line, solver)
    for index in range(0, len(line.observations), 50):
        torque = controller.step(line.observations[index], line.references[index]).command.torque
        # OSQP's default tolerance is 1e-3, and the posture's weight is small against it.
        np.testing.assert_allclose(naive(index), torque, atol=1e-6 if solver == "daqp" else 1.0)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("peer", ["mink", "pink"])
def test_the_kinematic_peers_move_the_same_arm(lines, name, peer):
    """Without an active limit, their step is the least-squares step with the project's Jacobian and pose error."""
    line = lines[name]
    # On the line itself the error is too small for a comparison, and much farther ahead the speed limits are active.
    ahead = line._replace(references=line.references[3:], observations=line.observations[:-3])
    (tick,) = [item.tick(ahead) for item in peers.PEERS if item.key == peer]
    if isinstance(tick, str):
        pytest.skip(tick)
    for index in (200, 400):
        q = ahead.observations[index].q
        state = line.arm.update(q, np.zeros(line.arm.nv))
        error = pose_error(state, ahead.references[index])
        assert np.linalg.norm(error) > 5e-4
        posture = 1e-4 * (line.source.posture - q)
        step = np.linalg.solve(state.J.T @ state.J + 1e-4 * np.eye(len(q)), state.J.T @ error + posture)
        np.testing.assert_allclose(np.asarray(tick(index)) / RATE, step, atol=1e-3 * np.abs(step).max())
