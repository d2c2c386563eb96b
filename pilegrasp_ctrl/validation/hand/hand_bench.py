"""A hand on a fixed flange in the posture of an attempt, and a ball that it may hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import mujoco
import numpy as np

from ...planning.strategy import tool_rotation
from ...sim.contact import add_pair, combine, pair_parameters
from ...sim.hand import Hand
from ...sim.object_model import ObjectModel
from ...sim.scene import add_objects, new_spec
from ...types import Array, Pose

TIMESTEP = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class HandBench:
    """A compiled hand in still air, made by the functions that make an attempt's scene.

    Attributes:
        hand: the end-effector.
        model: of it, without gravity; the ball is the body `object_0`.
        transform_tool_to_world: the tool frame of the straight hand, sloping as in an attempt.
    """

    hand: Hand
    model: mujoco.MjModel
    transform_tool_to_world: Pose

    @classmethod
    def build(cls, hand: Hand, ball: ObjectModel | None = None) -> Self:
        """Compile the hand, with a free ball where one is given."""
        spec = new_spec(TIMESTEP)
        tool = Pose(np.zeros(3), tool_rotation(0.0, hand.theta))
        flange = tool @ hand.transform_tool_to_flange.inverse()
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, flange.rotation.ravel())
        hand.add_to(spec, spec.worldbody.add_site(name="flange", pos=flange.translation, quat=quaternion))
        if ball is not None:
            add_objects(spec, ball, 1, [], "paper")
            contact = pair_parameters(combine(hand.surface, ball.surface, "paper"), TIMESTEP)
            for geom in hand.contact_geoms:
                add_pair(spec, geom, "object_0", contact)
        model = spec.compile()
        model.opt.gravity[:] = 0.0
        # What rests without gravity would sleep on when its weight sets in.
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
        """Let `force` (3,), in world axes [N], act on a fingertip where it is now, instead of the last one."""
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
