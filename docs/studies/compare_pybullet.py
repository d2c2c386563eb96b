"""Compare the same piles in MuJoCo and in PyBullet: settled height and spread, push force, cost of a step.

Usage: python docs/studies/compare_pybullet.py [SEEDS]

The script needs `pip install 'pilegrasp[pybullet]'`; the library itself never imports PyBullet.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.planning.layout import Layout, make_layout
from pilegrasp_ctrl.sections import PileConfig, SupportConfig
from pilegrasp_ctrl.sim.contact import SUPPORT, Rule, Surface
from pilegrasp_ctrl.sim.drop import FRAME_HEIGHT, drop_poses, pile_model
from pilegrasp_ctrl.sim.object_model import ObjectModel
from pilegrasp_ctrl.sim.objects import OBJECT_MODELS
from pilegrasp_ctrl.sim.pile import LIFT_SPEED, settle_pile
from pilegrasp_ctrl.statistics import markdown_row, markdown_table
from pilegrasp_ctrl.validation.physics.plate_push import PLATE, SPEED, push, push_model, start_of_plate
from script import run_script

try:
    import pybullet  # type: ignore[import-not-found,import-untyped,unused-ignore]
except ImportError:
    pybullet = None

COUNTS = (18, 30, 60, 90)
"""Numbers of balls in the timing of a step; chosen."""

STEP = 1e-3
"""Physics step of the shipped scenarios [s]."""

BALL = OBJECT_MODELS["light_sphere"]
"""Object of every pile."""

SETTLE_TIME = 2.0
"""Time to settle in the frame, and again after it is lifted [s]; chosen."""

DISTANCE = 0.12
"""Travel of the plate [m]; chosen."""

F_GRASP = 17.0
"""Push force at which the paper's hand closes [N]."""


class BulletWorld:
    """A compiled MuJoCo model of boxes, spheres and a plane, built again in PyBullet.

    Bullet's default solver (50 iterations) gets the same shapes, masses and coefficients. It multiplies the
    coefficients of two bodies.
    """

    def __init__(self, model: mujoco.MjModel, object_model: ObjectModel) -> None:
        self.timestep = model.opt.timestep
        self._client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(*model.opt.gravity)
        pybullet.setPhysicsEngineParameter(fixedTimeStep=self.timestep, numSubSteps=0)
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        self.objects: list[int] = []
        self._frame: list[tuple[int, Any, Any]] = []
        self._plate = -1
        for geom in range(model.ngeom):
            name, body = model.geom(geom).name, int(model.geom_bodyid[geom])
            place = data.geom_xpos[geom].tolist(), _xyzw(data.geom_xmat[geom])
            if name == "plate":
                self._plate = _add_plate(model, geom, *place)
            elif name.startswith("object"):
                self.objects.append(_add(model, geom, object_model.surface, *place, mass=float(model.body_mass[body])))
                inertia = model.body_inertia[body].tolist()
                pybullet.changeDynamics(self.objects[-1], -1, localInertiaDiagonal=inertia)
            else:
                static = _add(model, geom, SUPPORT, *place)
                if model.body_mocapid[body] >= 0:
                    self._frame.append((static, *place))

    def place(self, poses: np.ndarray, plate: float = 0.0) -> None:
        """Put the objects to rest at poses (n, 7), and the plate at x [m]."""
        for body, pose in zip(self.objects, poses, strict=True):
            pybullet.resetBasePositionAndOrientation(body, pose[:3].tolist(), [*pose[4:].tolist(), float(pose[3])])
        if self._plate >= 0:
            pybullet.resetJointState(self._plate, 0, plate, SPEED)
            pybullet.setJointMotorControl2(self._plate, 0, pybullet.VELOCITY_CONTROL, targetVelocity=SPEED, force=1e4)

    def lift(self, height: float) -> None:
        """Put the frame at a height [m]."""
        for body, (x, y, z), orientation in self._frame:
            pybullet.resetBasePositionAndOrientation(body, [x, y, z + height], orientation)

    def step(self) -> float:
        """Advance by one step, and return its wall-clock time [s]."""
        start = time.perf_counter()
        pybullet.stepSimulation()
        return time.perf_counter() - start

    def poses(self) -> np.ndarray:
        """Return the objects' poses (n, 7), wxyz."""
        rows = [pybullet.getBasePositionAndOrientation(body) for body in self.objects]
        return np.array([[*position, w, x, y, z] for position, (x, y, z, w) in rows])

    def speed(self) -> float:
        """Return the largest speed of an object [m/s]."""
        return max(float(np.linalg.norm(pybullet.getBaseVelocity(body)[0])) for body in self.objects)

    def force(self) -> float:
        """Return the force of the plate along x [N]: its normal forces and its friction."""
        total = 0.0
        for contact in pybullet.getContactPoints(bodyA=self._plate):
            total -= contact[9] * contact[7][0] + contact[10] * contact[11][0] + contact[12] * contact[13][0]
        return total

    def close(self) -> None:
        """Disconnect from Bullet."""
        pybullet.disconnect(self._client)


def _shape(model: mujoco.MjModel, geom: int) -> int:
    size = model.geom_size[geom]
    shapes = {
        int(mujoco.mjtGeom.mjGEOM_BOX): pybullet.GEOM_BOX,
        int(mujoco.mjtGeom.mjGEOM_SPHERE): pybullet.GEOM_SPHERE,
        int(mujoco.mjtGeom.mjGEOM_CYLINDER): pybullet.GEOM_CYLINDER,
        int(mujoco.mjtGeom.mjGEOM_PLANE): pybullet.GEOM_PLANE,
    }
    shape = shapes[int(model.geom_type[geom])]
    if shape == pybullet.GEOM_BOX:
        return int(pybullet.createCollisionShape(shape, halfExtents=size.tolist()))
    if shape == pybullet.GEOM_PLANE:
        return int(pybullet.createCollisionShape(shape, planeNormal=[0, 0, 1]))
    return int(pybullet.createCollisionShape(shape, radius=float(size[0]), height=2.0 * float(size[1])))


def _add(model: mujoco.MjModel, geom: int, surface: Surface, position: Any, orientation: Any, mass: float = 0.0) -> int:
    body = int(pybullet.createMultiBody(mass, _shape(model, geom), -1, position, orientation))
    _set_surface(body, -1, surface)
    return body


def _add_plate(model: mujoco.MjModel, geom: int, position: Any, orientation: Any) -> int:
    """Add the plate as the one link of a fixed body, sliding along x."""
    mass = float(model.body_mass[model.geom_bodyid[geom]])
    plate = pybullet.createMultiBody(
        baseMass=0.0,
        basePosition=position,
        baseOrientation=orientation,
        linkMasses=[mass],
        linkCollisionShapeIndices=[_shape(model, geom)],
        linkVisualShapeIndices=[-1],
        linkPositions=[[0, 0, 0]],
        linkOrientations=[[0, 0, 0, 1]],
        linkInertialFramePositions=[[0, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]],
        linkParentIndices=[0],
        linkJointTypes=[pybullet.JOINT_PRISMATIC],
        linkJointAxis=[[1, 0, 0]],
    )
    _set_surface(plate, 0, PLATE)
    return int(plate)


def _set_surface(body: int, link: int, surface: Surface) -> None:
    pybullet.changeDynamics(
        body,
        link,
        lateralFriction=surface.lateral,
        spinningFriction=surface.spinning,
        rollingFriction=surface.rolling,
        restitution=surface.restitution,
        linearDamping=0.0,
        angularDamping=0.0,
        jointDamping=0.0,
    )


def _xyzw(matrix: np.ndarray) -> list[float]:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, matrix)
    w, x, y, z = quaternion.tolist()
    return [x, y, z, w]


@dataclass(frozen=True)
class PileFacts:
    """Numbers of a settled pile and its push.

    Attributes:
        height: Mean height of the centres [m].
        top: Largest height of the centres [m].
        spread: Median distance from the middle [m].
        travel: Travel of the plate to 17 N [m]; NaN if 17 N is not reached.
        force: Mean force of the push [N].
    """

    height: float
    top: float
    spread: float
    travel: float
    force: float


def facts(poses: np.ndarray, travel: np.ndarray, force: np.ndarray) -> PileFacts:
    """Return the numbers of a settled pile (n, 7) and its push; F_grasp refers to the force smoothed over 20 ms."""
    offset = poses[:, :2] - np.median(poses[:, :2], axis=0)
    smooth = np.convolve(force, np.full(20, 0.05), "same")
    reached = np.flatnonzero(smooth > F_GRASP)
    first = float(travel[reached[0]]) if reached.size else np.nan
    spread = float(np.median(np.linalg.norm(offset, axis=1)))
    return PileFacts(float(poses[:, 2].mean()), float(poses[:, 2].max()), spread, first, float(force.mean()))


def row(name: str, piles: list[PileFacts]) -> str:
    """Return one line of the table: means over the seeds; the travel is the mean of those that reach 17 N."""
    height, top, spread = (1e3 * np.mean([getattr(p, key) for p in piles]) for key in ("height", "top", "spread"))
    travels = [1e3 * pile.travel for pile in piles if np.isfinite(pile.travel)]
    reached = f"{np.mean(travels):.0f} mm ({len(travels)} of {len(piles)})" if travels else f"0 of {len(piles)}"
    force = np.mean([pile.force for pile in piles])
    return markdown_row((name, f"{height:.1f}", f"{top:.1f}", f"{spread:.0f}", reached, f"{force:.2f}"))


def in_mujoco(count: int, seed: int, rule: Rule) -> PileFacts:
    """Settle and push with the library's own functions."""
    layout = _layout(count)
    poses = settle_pile(BALL, count, layout, seed, rule, STEP).poses
    result = push(push_model(BALL, count, layout, rule, STEP), poses, BALL.bounding_radius, DISTANCE)
    return facts(poses, result.travel, result.force)


def in_bullet(count: int, seed: int) -> PileFacts:
    """Drop from the same poses into the same frame, lift the frame and push as in MuJoCo."""
    layout = _layout(count)
    poses = settle_in_bullet(count, seed)
    world = BulletWorld(push_model(BALL, count, layout, "product", STEP), BALL)
    world.place(poses, start_of_plate(poses, BALL.bounding_radius))
    travel: list[float] = []
    force: list[float] = []
    while not travel or travel[-1] < DISTANCE:
        world.step()
        own = world.force()
        if own > 0.0 or travel:
            travel.append((travel[-1] if travel else 0.0) + SPEED * STEP)
            force.append(own)
    world.close()
    return facts(poses, np.array(travel), np.array(force))


def settle_in_bullet(count: int, seed: int) -> np.ndarray:
    """Return the settled poses (count, 7)."""
    layout = _layout(count)
    world = BulletWorld(pile_model(BALL, count, layout, "product", STEP), BALL)
    world.place(drop_poses(BALL, count, layout, np.random.default_rng(seed)))
    for step in range(round((2.0 * SETTLE_TIME + FRAME_HEIGHT / LIFT_SPEED) / STEP)):
        world.lift(min(max(step * STEP - SETTLE_TIME, 0.0) * LIFT_SPEED, FRAME_HEIGHT))
        world.step()
    poses = world.poses()
    world.close()
    return poses


def step_costs(count: int, steps: int = 600) -> tuple[float, float]:
    """Return the median seconds of a step in MuJoCo and in Bullet while the same pile is pushed, in turns."""
    layout = _layout(count)
    poses = settle_pile(BALL, count, layout, 0, "product", STEP).poses
    model = push_model(BALL, count, layout, "product", STEP)
    data, world = mujoco.MjData(model), BulletWorld(model, BALL)
    data.qpos[0] = start_of_plate(poses, BALL.bounding_radius)
    data.qpos[1:] = poses.ravel()
    world.place(poses, float(data.qpos[0]))
    own, other = [], []
    for _ in range(steps):
        data.qvel[0] = SPEED
        start = time.perf_counter()
        mujoco.mj_step(model, data)
        own.append(time.perf_counter() - start)
        other.append(world.step())
    world.close()
    return float(np.median(own)), float(np.median(other))


def _layout(count: int) -> Layout:
    return make_layout(SupportConfig(), PileConfig(count=count), BALL.diameter)


def main(seeds: int = 5) -> None:
    """Print both tables."""
    if pybullet is None:
        raise ConfigurationError("PyBullet is not installed; run: pip install 'pilegrasp[pybullet]'")
    print(markdown_table(("18 balls", "mean height [mm]", "top", "spread [mm]", "17 N after", "mean force [N]")))
    print(row("MuJoCo, rule `paper`", [in_mujoco(18, seed, "paper") for seed in range(seeds)]))
    print(row("MuJoCo, rule `product`", [in_mujoco(18, seed, "product") for seed in range(seeds)]))
    print(row("PyBullet", [in_bullet(18, seed) for seed in range(seeds)]))
    print()
    print(markdown_table(("balls", "MuJoCo [us]", "PyBullet [us]", "PyBullet / MuJoCo")))
    for count in COUNTS:
        own, other = step_costs(count)
        print(markdown_row((count, f"{1e6 * own:.0f}", f"{1e6 * other:.0f}", f"{other / own:.1f}")))


if __name__ == "__main__":
    run_script(main)
