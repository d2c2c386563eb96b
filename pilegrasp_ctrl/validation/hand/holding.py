"""What the closed hand holds: the pull that takes a ball out of it, and the mass that it carries through a lift."""

from __future__ import annotations

import mujoco
import numpy as np

from ...planning.strategy import HOLD_TIME, LIFT_SPEED
from ...sim.hand import Hand
from ...sim.objects import object_model
from ...trajectories.straight_line import StraightLine
from ...types import Array
from .hand_bench import HandBench

BALL_AT = np.array([-0.06, 0.0, 0.042])
"""Of the ball's centre in the tool frame before the hand closes [m]: in front of the fingers, short of the palm."""
HOLDER = 200.0
"""Stiffness of the critically damped spring that keeps the ball there until the hand has closed [N/m]."""
SETTLING = 0.5
"""From the release of the ball to what is measured [s]."""
LOST = 0.06
"""A ball is out when it has moved this far from where the hand had closed on it [m]: more than its diameter."""
PULL_RATE = 5.0
"""Of the pull, which grows slowly enough for the ball's inertia not to count [N/s]."""
STRONGEST = 100.0
"""Pull at which a measurement gives up [N]."""
PULLS = {"along the fingers": (1.0, 0.0, 0.0), "out of the palm": (0.0, 0.0, 1.0)}
"""Directions in the tool frame; sideways the ball would leave between thumb and fingers or past the smallest one."""
GRAVITY = 9.81
RAMP = 0.5
"""Time in which the ball's weight sets in [s]."""
LIFT_HEIGHT = 0.2
HOLD = 3.0 * HOLD_TIME
"""How long a mass is held after the lift [s]."""
WEIGHT_PERIOD = 0.01
"""The weight follows the lift's acceleration in steps of this [s]."""
HEAVIEST = 4.0
RESOLUTION = 0.0625
"""Largest mass that is tried, and step of the search [kg]."""


def pull_out_force(hand: Hand, direction: str) -> float:
    """Return the pull that takes a light 54 mm ball out of the closed hand, without gravity [N].

    Args:
        hand: that closes.
        direction: a key of `PULLS`.
    """
    bench, data = _closed_on_ball(hand, object_model("light_sphere").mass)
    pull = bench.transform_tool_to_world.rotation @ PULLS[direction]
    before, force = bench.ball_in_tool(data), 0.0
    while force < STRONGEST and np.linalg.norm(bench.ball_in_tool(data) - before) < LOST:
        force += PULL_RATE * bench.model.opt.timestep
        data.xfrc_applied[bench.model.body("object_0").id, :3] = force * pull
        bench.advance(data, bench.model.opt.timestep)
    return force


def slip(hand: Hand, mass: float) -> float:
    """Return how far a 54 mm ball of `mass` [kg] has moved in the hand after lift and hold [m].

    The hand is lifted as in an attempt. In its own frame, which does not turn, that is a gravity which varies in time.
    """
    bench, data = _closed_on_ball(hand, mass)
    before = bench.ball_in_tool(data)
    lift = StraightLine(bench.transform_tool_to_world, [0.0, 0.0, LIFT_HEIGHT], LIFT_SPEED)
    start = float(data.time)
    while (time := float(data.time) - start) < RAMP + lift.duration + HOLD:
        rise = lift.at(max(0.0, time - RAMP)).acceleration[2]
        bench.model.opt.gravity[2] = -min(1.0, time / RAMP) * (GRAVITY + rise)
        bench.advance(data, WEIGHT_PERIOD)
    return float(np.linalg.norm(bench.ball_in_tool(data) - before))


def payload(hand: Hand) -> float:
    """Return the largest mass of a 54 mm ball that the hand keeps through lift and hold [kg], to `RESOLUTION`."""
    low, high = 0.0, HEAVIEST
    while high - low > RESOLUTION:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if slip(hand, middle) < LOST else (low, middle)
    return low


def ball_at_rest(hand: Hand) -> Array:
    """Return where the closed hand has drawn the light ball (3,), in the tool frame [m]."""
    bench, data = _closed_on_ball(hand, object_model("light_sphere").mass)
    return bench.ball_in_tool(data)


def _closed_on_ball(hand: Hand, mass: float) -> tuple[HandBench, mujoco.MjData]:
    bench = HandBench.build(hand, object_model("light_sphere", mass=mass))
    data = bench.start(BALL_AT)
    data.ctrl[:] = 1.0
    ball = bench.model.body("object_0").id
    place, damping = data.xpos[ball].copy(), 2.0 * np.sqrt(HOLDER * mass)
    while data.time < hand.parameters["use"]["closing_time"]:
        data.xfrc_applied[ball, :3] = HOLDER * (place - data.xpos[ball]) - damping * data.qvel[-6:-3]
        bench.advance(data, bench.model.opt.timestep)
    data.xfrc_applied[ball] = 0.0
    bench.advance(data, SETTLING)
    return bench, data
