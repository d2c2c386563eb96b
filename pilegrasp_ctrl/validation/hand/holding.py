"""The grip of the closed hand: the pull that takes a ball out of it, and the mass that it carries through a lift."""

from __future__ import annotations

import mujoco
import numpy as np

from ...planning.strategy import HOLD_TIME, LIFT_SPEED
from ...sim.hand import Hand
from ...sim.objects import object_model
from ...trajectories.straight_line import StraightLine
from ..physics.contact_rig import GRAVITY
from .hand_bench import HandBench

BALL_POSITION = np.array([-0.06, 0.0, 0.042])
"""Position (3,) of the ball's centre in the tool frame before the hand closes [m]: between fingers and palm; chosen."""

HOLDER_STIFFNESS = 200.0
"""Stiffness of the critically damped spring that holds the ball in place until the hand has closed [N/m]; chosen."""

SETTLING = 0.5
"""Time from the release of the ball to the measurement [s]; chosen."""

LOSS_DISTANCE = 0.06
"""Displacement of the ball in the closed hand beyond which it is lost [m]; chosen above its diameter."""

PULL_RATE = 5.0
"""Rate of the pull [N/s]; chosen so small that the ball's inertia does not matter."""

MAX_PULL = 100.0
"""Pull at which a measurement ends without a loss of the ball [N]; chosen."""

PULLS = {"along the fingers": (1.0, 0.0, 0.0), "out of the palm": (0.0, 0.0, 1.0)}
"""Directions of the pull in the tool frame. Sideways the ball would leave between thumb and fingers or past
the smallest finger."""

RAMP = 0.5
"""Time in which the ball's weight sets in [s]; chosen."""

LIFT_HEIGHT = 0.2
"""Height of the lift [m]; chosen."""

HOLD = 3.0 * HOLD_TIME
"""Time for which a mass is held after the lift [s]; chosen."""

WEIGHT_PERIOD = 0.01
"""Period at which the weight follows the lift's acceleration [s]; chosen."""

MAX_MASS, RESOLUTION = 4.0, 0.0625
"""Largest mass that is tried, and resolution of the search [kg]; chosen."""


def pull_out_force(hand: Hand, direction: str) -> float:
    """Return the force that pulls a light 54 mm ball out of the closed hand, without gravity [N].

    Args:
        hand: Hand that closes on the ball.
        direction: Key of `PULLS`.
    """
    bench, data = _closed_on_ball(hand, object_model("light_sphere").mass)
    pull = bench.transform_tool_to_world.rotation @ PULLS[direction]
    before, force = bench.ball_in_tool(data), 0.0
    while force < MAX_PULL and np.linalg.norm(bench.ball_in_tool(data) - before) < LOSS_DISTANCE:
        force += PULL_RATE * bench.model.opt.timestep
        data.xfrc_applied[bench.model.body("object_0").id, :3] = force * pull
        bench.advance(data, bench.model.opt.timestep)
    return force


def slip(hand: Hand, mass: float) -> float:
    """Return the distance that a 54 mm ball of `mass` [kg] moves in the hand during lift and hold [m].

    The lift is that of an attempt. In the hand's frame, which does not rotate, it is a gravity that varies with time.
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
    low, high = 0.0, MAX_MASS
    while high - low > RESOLUTION:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if slip(hand, middle) < LOSS_DISTANCE else (low, middle)
    return low


def _closed_on_ball(hand: Hand, mass: float) -> tuple[HandBench, mujoco.MjData]:
    bench = HandBench.build(hand, object_model("light_sphere", mass=mass))
    data = bench.start(BALL_POSITION)
    data.ctrl[:] = 1.0
    ball = bench.model.body("object_0").id
    place, damping = data.xpos[ball].copy(), 2.0 * np.sqrt(HOLDER_STIFFNESS * mass)
    while data.time < hand.parameters["use"]["closing_time"]:
        data.xfrc_applied[ball, :3] = HOLDER_STIFFNESS * (place - data.xpos[ball]) - damping * data.qvel[-6:-3]
        bench.advance(data, bench.model.opt.timestep)
    data.xfrc_applied[ball] = 0.0
    bench.advance(data, SETTLING)
    return bench, data
