"""A compiled MuJoCo model of boxes, spheres and a plane, built again in PyBullet; for compare_pybullet.py alone."""

from __future__ import annotations

import time
from typing import Any

import mujoco
import numpy as np

from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.sim.contact import SUPPORT, Surface
from pilegrasp_ctrl.sim.object_model import ObjectModel
from pilegrasp_ctrl.validation.physics.plate_push import PLATE, SPEED

try:
    import pybullet
except ImportError:
    raise ConfigurationError("PyBullet is not installed; run: pip install 'pilegrasp[pybullet]'") from None

SHAPES = {
    int(mujoco.mjtGeom.mjGEOM_BOX): pybullet.GEOM_BOX,
    int(mujoco.mjtGeom.mjGEOM_SPHERE): pybullet.GEOM_SPHERE,
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): pybullet.GEOM_CYLINDER,
    int(mujoco.mjtGeom.mjGEOM_PLANE): pybullet.GEOM_PLANE,
}


class BulletWorld:
    """Bullet's default solver (50 iterations) on the same shapes, masses and coefficients, which it multiplies."""

    def __init__(self, model: mujoco.MjModel, kind: ObjectModel) -> None:
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
                self.objects.append(_add(model, geom, kind.surface, *place, mass=float(model.body_mass[body])))
                inertia = model.body_inertia[body].tolist()
                pybullet.changeDynamics(self.objects[-1], -1, localInertiaDiagonal=inertia)
            else:
                static = _add(model, geom, SUPPORT, *place)
                if model.body_mocapid[body] >= 0:
                    self._frame.append((static, *place))

    def place(self, poses: np.ndarray, plate: float = 0.0) -> None:
        """Put the objects at poses (n, 7) at rest, and the plate at x [m]."""
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
        """Advance, and return the seconds that it took."""
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
        """Return what the plate exerts along x [N]: its normal forces and its friction."""
        total = 0.0
        for contact in pybullet.getContactPoints(bodyA=self._plate):
            total -= contact[9] * contact[7][0] + contact[10] * contact[11][0] + contact[12] * contact[13][0]
        return total

    def close(self) -> None:
        """Leave Bullet."""
        pybullet.disconnect(self._client)


def _shape(model: mujoco.MjModel, geom: int) -> int:
    size = model.geom_size[geom]
    kind = SHAPES[int(model.geom_type[geom])]
    if kind == pybullet.GEOM_BOX:
        return int(pybullet.createCollisionShape(kind, halfExtents=size.tolist()))
    if kind == pybullet.GEOM_PLANE:
        return int(pybullet.createCollisionShape(kind, planeNormal=[0, 0, 1]))
    return int(pybullet.createCollisionShape(kind, radius=float(size[0]), height=2.0 * float(size[1])))


def _add(model: mujoco.MjModel, geom: int, surface: Surface, position: Any, orientation: Any, mass: float = 0.0) -> int:
    body = int(pybullet.createMultiBody(mass, _shape(model, geom), -1, position, orientation))
    _dress(body, -1, surface)
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
    _dress(plate, 0, PLATE)
    return int(plate)


def _dress(body: int, link: int, surface: Surface) -> None:
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
