"""Net-bags: free within their length, taut beyond it, never pushing, and a pile of them."""

import math

import mujoco
import numpy as np
import pytest

from object_worlds import compile_objects, settled_poses
from pilegrasp_ctrl.config import PileConfig
from pilegrasp_ctrl.episode import run
from pilegrasp_ctrl.exceptions import ConfigurationError, PileError
from pilegrasp_ctrl.sim.objects import OBJECT_MODELS, object_model, objects_of
from pilegrasp_ctrl.sim.scene import add_objects, new_spec


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def bag(positions, gravity=0.0):
    """Three limes of one net, upright, at `positions` (3, 3); nothing else."""
    objects = OBJECT_MODELS["lime_net"]
    model = compile_objects(objects, 3)
    model.opt.gravity[2] = -gravity
    data = mujoco.MjData(model)
    data.qpos.reshape(3, 7)[:, :3] = positions
    mujoco.mj_forward(model, data)
    return model, data


def loop_of(data):
    x = data.qpos.reshape(-1, 7)[:, :3]
    return sum(np.linalg.norm(x[i] - x[i - 1]) for i in range(3))


def triangle(side):
    return side / math.sqrt(3.0) * np.array([[math.cos(a), math.sin(a), 0.0] for a in (0.0, 2.0944, 4.1888)])


def test_within_the_nets_length_a_lime_is_free():
    model, data = bag(triangle(0.079))
    data.qvel[0:3] = 0.0, 0.0, 0.01
    for _ in range(200):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.qvel[:3], [0.0, 0.0, 0.01], atol=1e-12)
    np.testing.assert_allclose(data.qvel[6:], 0.0, atol=1e-12)


def test_beyond_its_length_the_net_is_taut():
    model, data = bag(triangle(0.079))
    data.qvel[0] = 0.5
    longest = 0.0
    for _ in range(400):
        mujoco.mj_step(model, data)
        longest = max(longest, loop_of(data))
    assert 0.24 < longest < 0.242
    velocity = data.qvel.reshape(3, 6)
    assert velocity[0, 0] < 0.4
    assert velocity[1:, 0].min() > 0.02
    # Internal forces do not change the momentum.
    np.testing.assert_allclose(velocity[:, :3].sum(axis=0), [0.5, 0.0, 0.0], atol=1e-6)


def test_a_lime_that_moves_inward_does_not_push_another():
    model, data = bag(triangle(0.079))
    data.qvel[0] = -0.1  # toward the middle between the others, which it does not reach in this time
    for _ in range(150):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.qvel.reshape(3, 6)[1:], 0.0, atol=1e-12)
    assert data.qvel[0] == pytest.approx(-0.1, abs=1e-12)


def test_lifting_one_lime_lifts_the_others_after_the_slack():
    objects = OBJECT_MODELS["lime_net"]
    spec = new_spec(1e-3)
    spec.worldbody.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1], contype=0, conaffinity=0)
    add_objects(spec, objects, 3, ["table"], "paper")
    model = spec.compile()
    data = mujoco.MjData(model)
    poses = data.qpos.reshape(3, 7)
    # Lying down, so that they rest.
    poses[:, :3] = [[0.0, 0.0, 0.0245], [0.0, 0.06, 0.0245], [0.0, -0.06, 0.0245]]
    poses[:, 3:] = math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0
    for _ in range(1000):
        mujoco.mj_step(model, data)
    heights = []
    grip = poses[0, :3].copy()
    for step in range(1500):
        # A hand that draws one lime up at 0.1 m/s.
        target = grip + np.array([0.0, 0.0, 1e-4 * step])
        data.xfrc_applied[1, :3] = 300.0 * (target - poses[0, :3]) + 5.0 * ([0, 0, 0.1] - data.qvel[:3])
        mujoco.mj_step(model, data)
        heights.append(poses[:, 2].copy())
    heights = np.array(heights)
    assert heights[:200, 1:].max() < 0.03  # 20 mm up: slack
    assert heights[-1, 0] > 0.15
    assert heights[-1, 1:].min() > 0.06  # both hang
    assert loop_of(data) == pytest.approx(0.24, abs=0.0005)


@pytest.mark.slow
def test_a_pile_of_nets_settles_within_their_length():
    objects = OBJECT_MODELS["lime_net"]
    poses = settled_poses(objects, 6)
    for first in (0, 3):
        x = poses[first : first + 3, :3]
        assert sum(np.linalg.norm(x[i] - x[i - 1]) for i in range(3)) < 0.2405
    assert poses[:, 2].min() > 0.0235


def test_pile_count_is_the_number_of_single_limes():
    with pytest.raises(ConfigurationError, match=r"pile.count = 7 counts single objects, .* holds 3; make it 6 or 9$"):
        objects_of(PileConfig(object="lime_net", count=7))
    with pytest.raises(ConfigurationError, match=r"make it 3$"):
        objects_of(PileConfig(object="lime_net", count=1))
    assert objects_of(PileConfig(object="lime_net", count=15)).net.members == 3
    with pytest.raises(PileError, match=r"3 tied objects need 107 mm side by side .* raise pile.frame_size"):
        settled_poses(OBJECT_MODELS["lime_net"], 3)
    assert settled_poses(OBJECT_MODELS["lime_net"], 3, frame_size=0.12).shape == (3, 7)


def test_a_net_grows_with_its_objects():
    assert object_model("lime_net", scale=0.5).net.loop == pytest.approx(0.12)


@pytest.mark.slow
def test_an_attempt_on_nets_of_limes_runs():
    result = run("spheres_wall", overrides={"pile.object": "lime_net", "pile.count": 6}, record=True)
    assert result.reason in ("", "nothing was in the hand after the lift")
    assert sum(body.role == "object" for body in result.recording.bodies) == 6
