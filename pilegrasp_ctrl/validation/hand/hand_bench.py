"""A bench for the soft hand: fixed flange, posture of an attempt, measurements of a finger, and a ball to hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import mujoco
import numpy as np
from scipy.optimize import brentq

from ...planning.strategy import tool_rotation
from ...sim.contact import add_pair
from ...sim.hand import Hand
from ...sim.object_model import ObjectModel
from ...sim.scene import add_hand_pairs, add_objects, hand_contact, new_spec
from ...types import Array, Pose

TIMESTEP = 1e-3
"""Physics step of the shipped scenarios [s]."""

FINGER = "middle"
"""Finger that is measured by default."""

SETTLING = 1.5
"""Time after which a loaded finger is at rest [s]; chosen."""

LOAD_PERIOD = 0.01
"""Period at which a load follows the fingertip [s]; chosen."""

SMALL_FORCE = 0.1
"""Load that bends a finger by a few millimetres [N]; chosen."""

FAR = 0.1
"""Distance beyond which geoms are not compared [m]; chosen."""

CLOSED = 0.9
"""Share of the tip's travel at which a finger counts as closed [-]; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class HandBench:
    """A compiled hand without gravity, made by the functions that make an attempt's scene.

    Attributes:
        hand: Hand.
        model: Compiled model without gravity; the ball is the body `object_0`.
        transform_tool_to_world: Tool frame of the straight hand, with the slope of an attempt.
    """

    hand: Hand
    model: mujoco.MjModel
    transform_tool_to_world: Pose

    @classmethod
    def build(cls, hand: Hand, ball: ObjectModel | None = None) -> Self:
        """Compile the hand, and a free ball if one is given."""
        spec = new_spec(TIMESTEP)
        tool = Pose(np.zeros(3), tool_rotation(0.0, hand.theta))
        flange = tool @ hand.transform_tool_to_flange.inverse()
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, flange.rotation.ravel())
        hand.add_to(spec, spec.worldbody.add_site(name="flange", pos=flange.translation, quat=quaternion))
        add_hand_pairs(spec, hand, "paper")
        if ball is not None:
            add_objects(spec, ball, 1, [], "paper")
            for geom in hand.contact_geoms:
                add_pair(spec, geom, "object_0", hand_contact(spec, hand, geom, ball.surface, 1.0 / ball.mass, "paper"))
        model = spec.compile()
        model.opt.gravity[:] = 0.0
        # A ball at rest without gravity would stay asleep when its weight sets in.
        model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        return cls(hand, model, tool)

    def start(self, ball_at: Array | None = None) -> mujoco.MjData:
        """Return a state at rest, the ball's centre at `ball_at` (3,) in the tool frame [m]."""
        data = mujoco.MjData(self.model)
        if ball_at is not None:
            data.qpos[-7:-4] = self.transform_tool_to_world.rotation @ ball_at
        mujoco.mj_forward(self.model, data)
        return data

    def advance(self, data: mujoco.MjData, duration: float) -> None:
        """Simulate for `duration` [s]."""
        mujoco.mj_step(self.model, data, round(duration / self.model.opt.timestep))

    def fingertip(self, data: mujoco.MjData, finger: str) -> Array:
        """Return the position (3,) of the outermost point of a finger or the thumb [m]."""
        shape, base, tip = self._finger(finger)
        body = data.body(f"{finger}_{shape}")
        return np.array(body.xpos + body.xmat.reshape(3, 3)[:, 0] * np.linalg.norm(tip - base) / shape)

    def load(self, data: mujoco.MjData, finger: str, force: Array) -> None:
        """Apply `force` (3,), world axes [N], at the present position of a fingertip, in place of the last force."""
        data.qfrc_applied[:] = 0.0
        body = self.model.body(f"{finger}_{self._finger(finger)[0]}").id
        point = self.fingertip(data, finger)
        mujoco.mj_applyFT(self.model, data, force, np.zeros(3), point, body, data.qfrc_applied)

    def ball_in_tool(self, data: mujoco.MjData) -> Array:
        """Return the position (3,) of the ball in the tool frame [m]."""
        return np.array(self.transform_tool_to_world.rotation.T @ data.body("object_0").xpos)

    def _finger(self, name: str) -> tuple[int, Array, Array]:
        parameters = self.hand.parameters
        if name == "thumb":
            shape = parameters["thumb"]
            return shape["segments"], np.array(shape["base"]), np.array(shape["tip"])
        shape = parameters["fingers"]
        return shape["segments"], np.array(shape["base"][name]), np.array(shape["tip"][name])


def axes(bench: HandBench, finger: str = FINGER) -> tuple[Array, Array]:
    """Return unit vectors (3,) across a straight finger, world axes: the closing direction, and sideways."""
    body = bench.start().body(f"{finger}_1")
    rotation = body.xmat.reshape(3, 3)
    return rotation[:, 2].copy(), rotation[:, 1].copy()


def displacement(bench: HandBench, force: Array, closure: float = 0.0, finger: str = FINGER) -> Array:
    """Return the displacement (3,) of the fingertip at rest under `force` (3,) [N], from the straight finger [m]."""
    data = bench.start()
    before = bench.fingertip(data, finger)
    data.ctrl[:] = closure
    # The finger is inflated at once; `closing_time` measures how long that takes.
    data.act[:] = closure
    while data.time < SETTLING:
        bench.load(data, finger, force)
        bench.advance(data, LOAD_PERIOD)
    return bench.fingertip(data, finger) - before


def deflection(bench: HandBench, force: float, finger: str = FINGER) -> float:
    """Return the deflection of a straight, vented finger's tip under a load [N] against the closing direction [m]."""
    closing, _ = axes(bench, finger)
    return float(-displacement(bench, -force * closing, 0.0, finger) @ closing)


def stiffness(bench: HandBench, closure: float = 0.0, finger: str = FINGER) -> float:
    """Return the stiffness at the tip against a small load along its present normal, in the plane of closing [N/m]."""
    closing, sideways = axes(bench, finger)
    at_rest = displacement(bench, np.zeros(3), closure, finger)
    turn = free_bend(bench, closure, finger)
    normal = np.cos(turn) * closing - np.sin(turn) * np.cross(sideways, closing)
    loaded = displacement(bench, SMALL_FORCE * normal, closure, finger)
    return float(SMALL_FORCE / ((loaded - at_rest) @ normal))


def lateral_stiffness(bench: HandBench, finger: str = FINGER) -> float:
    """Return the stiffness at the tip of a straight finger against a small load from the side [N/m]."""
    _, sideways = axes(bench, finger)
    return float(SMALL_FORCE / (displacement(bench, SMALL_FORCE * sideways, 0.0, finger) @ sideways))


def blocked_force(bench: HandBench, closure: float = 1.0, finger: str = FINGER) -> float:
    """Return the force that holds the closing finger's tip at the height of the straight finger's tip [N]."""
    closing, _ = axes(bench, finger)

    def rise(force: float) -> float:
        return float(displacement(bench, -force * closing, closure, finger) @ closing)

    # A load several times as large folds the finger over.
    return float(brentq(rise, 0.0, 15.0, xtol=1e-3))


def closing_time(bench: HandBench, finger: str = FINGER) -> float:
    """Return the time from the command until the tip has covered the share `CLOSED` of its travel in free space [s]."""
    final = np.linalg.norm(displacement(bench, np.zeros(3), 1.0, finger))
    data = bench.start()
    before = bench.fingertip(data, finger)
    data.ctrl[:] = 1.0
    while np.linalg.norm(bench.fingertip(data, finger) - before) < CLOSED * final:
        bench.advance(data, bench.model.opt.timestep)
    return float(data.time)


def free_bend(bench: HandBench, closure: float = 1.0, finger: str = FINGER) -> float:
    """Return the angle by which the tip of a finger turns when it closes in free space [rad]."""
    data = bench.start()
    data.ctrl[:] = closure
    data.act[:] = closure
    bench.advance(data, SETTLING)
    segments = bench.hand.parameters["thumb" if finger == "thumb" else "fingers"]["segments"]
    return float(sum(data.joint(f"{finger}_bend_{i + 1}").qpos[0] for i in range(segments)))


def touch_depth(bench: HandBench, force: float, finger: str = FINGER) -> float:
    """Return the deepest overlap of a finger with its neighbours while `force` [N] pushes its tip to the side [m].

    It is the overlap of the shapes, whether or not the model lets them touch.
    """
    _, sideways = axes(bench, finger)
    geoms = bench.hand.contact_geoms
    others = [geom for geom in geoms if geom.split("_")[0] not in (finger, "palm", "sensor")]
    pairs = [
        (bench.model.geom(own).id, bench.model.geom(other).id)
        for own in geoms
        if own.split("_")[0] == finger
        for other in others
    ]
    deepest = 0.0
    for direction in (sideways, -sideways):
        data = bench.start()
        while data.time < SETTLING:
            bench.load(data, finger, force * direction)
            bench.advance(data, LOAD_PERIOD)
            closest = min(mujoco.mj_geomDistance(bench.model, data, *pair, FAR, None) for pair in pairs)
            deepest = max(deepest, -float(closest))
    return deepest
