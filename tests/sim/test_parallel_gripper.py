"""The parallel-jaw gripper has the published opening, speed and force of the Franka Hand."""

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.planning.push_goal import PushGoal
from pilegrasp_ctrl.sim.contact import OBJECT_RANK, Surface, add_pair, combine, pair_parameters
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.scene import new_spec

TIPS = ("hand_left_tip", "hand_right_tip")
PERIOD = 0.002
BALL = Surface(0.25, 0.001, 0.001, 0.72, OBJECT_RANK)


class Bench:
    """The gripper on a fixed flange without gravity, with a ball of 54 mm and 60 g between its jaws if asked for."""

    def __init__(self, ball=False, aside=0.0):
        self.hand = Hand.load("parallel_gripper")
        spec = new_spec(0.001)
        spec.option.gravity = [0.0, 0.0, 0.0]
        spec.option.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        self.hand.add_to(spec, spec.worldbody.add_site(name="flange"))
        if ball:
            body = spec.worldbody.add_body(name="ball", pos=[0.0, aside, 0.049 + 0.1036])
            body.add_freejoint()
            body.add_geom(name="ball", size=[0.027, 0.0, 0.0], mass=0.06, contype=0, conaffinity=0)
            for tip in TIPS:
                add_pair(spec, tip, "ball", pair_parameters(combine(self.hand.surface, BALL, "paper"), 0.001))
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.closure = 0.0
        mujoco.mj_forward(self.model, self.data)

    def run(self, closure, duration):
        """Hold the command for a time; return the times (n,) and positions (n, 2) of the jaws."""
        times, jaws = [], []
        for _ in range(round(duration / PERIOD)):
            self.closure = self.hand.drive.next_closure(self.closure, closure, PERIOD)
            self.data.ctrl[:] = self.hand.drive.command(self.closure)
            mujoco.mj_step(self.model, self.data, 2)
            times.append(self.data.time)
            jaws.append(self.data.qpos[:2].copy())
        return np.array(times), np.array(jaws)

    def forces(self):
        """Return the normal force of each tip on the ball [N]."""
        found = dict.fromkeys(TIPS, 0.0)
        for index, contact in enumerate(self.data.contact):
            force = np.zeros(6)
            mujoco.mj_contactForce(self.model, self.data, index, force)
            (tip,) = {self.model.geom(int(geom)).name for geom in contact.geom} & set(TIPS)
            found[tip] += force[0]
        return list(found.values())


def test_the_open_jaws_are_80_mm_apart_and_meet_when_they_are_closed():
    bench = Bench()
    gap = [abs(bench.data.geom(tip).xpos[1]) - 0.0076 for tip in TIPS]
    assert sum(gap) == pytest.approx(0.08, abs=1e-6)
    _, jaws = bench.run(1.0, 1.2)
    np.testing.assert_allclose(jaws[-1], 0.04, atol=2e-4)
    _, jaws = bench.run(0.0, 1.2)
    np.testing.assert_allclose(jaws[-1], 0.0, atol=2e-4)


def test_each_jaw_moves_at_the_stated_speed():
    times, jaws = Bench().run(1.0, 1.0)
    middle = (jaws.mean(axis=1) > 0.01) & (jaws.mean(axis=1) < 0.03)
    speed = np.diff(jaws[middle], axis=0) / np.diff(times[middle])[:, None]
    np.testing.assert_allclose(speed, 0.05, rtol=0.02)


def test_each_jaw_presses_with_the_stated_force():
    bench = Bench(ball=True)
    bench.run(1.0, bench.hand.use.closing_time)
    assert bench.hand.description.use.closing_force == 70.0
    np.testing.assert_allclose(bench.forces(), 70.0, rtol=0.02)


def test_the_belt_moves_a_ball_into_the_middle_of_the_jaws():
    bench = Bench(ball=True, aside=0.008)
    _, jaws = bench.run(1.0, 1.2)
    assert np.abs(jaws[:, 0] - jaws[:, 1]).max() < 1e-3
    assert abs(bench.data.body("ball").xpos[1]) < 1e-3


def test_friction_of_both_tips_holds_a_pull():
    bench = Bench(ball=True)
    bench.run(1.0, 1.2)
    limit = 2.0 * bench.hand.surface.lateral * 70.0
    ball = bench.model.body("ball").id
    for share, held in ((0.8, True), (1.2, False)):
        bench.data.xfrc_applied[ball, 2] = share * limit
        before = bench.data.body("ball").xpos[2]
        bench.run(1.0, 0.2)
        # Friction of the contact model creeps under a load.
        assert (abs(bench.data.body("ball").xpos[2] - before) < 0.006) == held


def test_closing_and_opening_are_what_it_can():
    use = Hand.load("parallel_gripper").use
    assert use.closes
    assert use.scoop_angle == 0.0
    # Two open jaws of 80 mm and the fingers' thickness.
    assert use.half_width == pytest.approx(0.055, abs=1e-3)


def test_a_push_line_in_a_bin_runs_through_the_middle_of_a_ball():
    use, goal = Hand.load("parallel_gripper").use, PushGoal("wall", np.zeros(2), 0.0, (-0.03, 0.03))
    row = np.array([[-0.027, y] for y in (-0.081, -0.026, 0.028, 0.083)])
    line, count = goal.best_line(row, use.aim_half_width)
    assert count == 1
    assert np.abs(row[:, 1] - line.anchor[1]).min() <= 0.01
    # As wide as the open jaws, the middle line counts two balls and passes between them.
    assert np.abs(row[:, 1] - goal.best_line(row, use.half_width)[0].anchor[1]).min() > 0.015
