"""Collisions with a crate: hands may touch its walls below the rim, and nothing else may touch them."""

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.planning.walls import Wall
from pilegrasp_ctrl.sim.hand_drive import HandDrive
from pilegrasp_ctrl.sim.monitors import RimCheck
from pilegrasp_ctrl.sim.scene import Scene

CENTER, HALF_SIZE = np.array([1.0, 0.0, 0.08]), np.array([0.01, 0.2, 0.08])
WALL = Wall(name="bin_far", center=CENTER, half_size=HALF_SIZE, yaw=np.pi, crate="bin")
PARTS = ("sensor", "finger", "link5", "object_0")


STILL = HandDrive(np.zeros(0), np.zeros(0))


@pytest.fixture(scope="module")
def scene():
    """A wall 160 mm high, and four balls of 10 mm that may be put anywhere."""
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(name=WALL.name, type=mujoco.mjtGeom.mjGEOM_BOX, pos=WALL.center, size=WALL.half_size)
    for part in PARTS:
        body = spec.worldbody.add_body(name=part)
        body.add_freejoint()
        body.add_geom(name=part, size=[0.01, 0.0, 0.0])
    model = spec.compile()
    ids = {part: model.body(part).id for part in PARTS}
    return Scene(
        model, 0, objects=(ids["object_0"],), hand_bodies=(ids["sensor"], ids["finger"]), object_qpos=0, drive=STILL
    )


def touching(scene, part, height):
    """Return the state in which `part` touches the wall at `height`; the other parts are far away."""
    data = mujoco.MjData(scene.model)
    positions = data.qpos.reshape(len(PARTS), 7)[:, :3]
    positions[:] = np.arange(4.0)[:, None] + 5.0
    positions[PARTS.index(part)] = 0.981, 0.0, height
    data.time = 1.0
    mujoco.mj_forward(scene.model, data)
    assert data.ncon == 1
    return data


@pytest.mark.parametrize(
    ("part", "height", "collides"),
    [
        ("finger", 0.03, False),
        ("finger", 0.135, False),
        ("finger", 0.145, True),
        ("sensor", 0.03, True),
        ("link5", 0.03, True),
        ("object_0", 0.145, False),
    ],
)
def test_the_hand_may_touch_a_wall_up_to_twenty_millimeters_below_its_edge(scene, part, height, collides):
    found = RimCheck(scene, [WALL]).find_collision(touching(scene, part, height))
    assert found == (f"collision with the bin's rim: {part} at bin_far" if collides else None)


def test_contacts_are_checked_every_ten_milliseconds(scene):
    check, data = RimCheck(scene, [WALL]), touching(scene, "sensor", 0.03)
    assert check.find_collision(data)
    data.time += 0.008
    assert check.find_collision(data) is None
    data.time += 0.002
    assert check.find_collision(data)


def test_a_wall_without_a_crate_has_no_rim(scene):
    wall = Wall(name="bin_far", center=CENTER, half_size=HALF_SIZE, yaw=np.pi)
    assert RimCheck(scene, [wall]).find_collision(touching(scene, "link5", 0.145)) is None
