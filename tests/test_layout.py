"""Every pile of the paper's grids lies where the arm can push it; the usual ones stand where they always stood."""

import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.config_sections import PileConfig, SupportConfig
from pilegrasp_ctrl.preparation import prepare
from pilegrasp_ctrl.sim.layout import ARM_FOOT, NEAREST, make_layout

KINDS = ("none", "wall", "corner")


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("touch", [(0.61, 0.0), (0.3, 0.1), (0.0, 0.0), (-0.2, 0.3)])
def test_the_arm_stands_just_so_far_back_that_the_hand_can_touch_down(kind, touch):
    layout = make_layout(SupportConfig(kind=kind), PileConfig(), 0.054)
    back = layout.standing_back(np.array(touch), np.zeros((0, 2)))
    axis = back.transform_base_to_world.translation[:2]
    distance = np.hypot(*(np.array(touch) - axis))
    assert NEAREST <= distance < NEAREST + 0.011
    assert back.transform_base_to_world.translation[2] == layout.transform_base_to_world.translation[2]
    assert back.walls is layout.walls


def test_a_pile_within_reach_leaves_the_arm_where_it_is():
    layout = make_layout(SupportConfig(), PileConfig(), 0.054)
    assert layout.standing_back(np.array([0.63, 0.0]), np.array([[0.1, 0.0]])).back == 0.0


def test_the_arm_never_stands_on_an_object():
    layout = make_layout(SupportConfig(), PileConfig(), 0.054)
    strays = np.array([[-0.2, 0.05], [-0.35, -0.1]])
    back = layout.standing_back(np.array([0.45, 0.0]), strays)
    axis = back.transform_base_to_world.translation[:2]
    assert np.linalg.norm(strays - axis, axis=1).min() >= ARM_FOOT
    assert np.hypot(0.45 - axis[0], axis[1]) >= NEAREST


@pytest.mark.parametrize("kind", KINDS)
def test_a_wide_frame_keeps_clear_of_the_arm(kind):
    for size in (0.1, 0.25, 0.33, 0.83):
        layout = make_layout(SupportConfig(kind=kind), PileConfig(frame_size=size), 0.054)
        reach = size / np.sqrt(2.0) if kind == "corner" else 0.5 * size
        assert layout.frame_center[0] - reach > ARM_FOOT
        usual = make_layout(SupportConfig(kind=kind), PileConfig(), 0.054)
        for wall, other in zip(layout.walls, usual.walls, strict=True):
            assert (wall.center[0] > other.center[0]) == (size > 0.8)


@pytest.mark.parametrize(
    ("kind", "count", "mass"), [*((kind, n, 0.06) for kind in KINDS for n in (3, 30)), ("corner", 60, 0.06)]
)
def test_spheres_of_any_number_are_within_reach(kind, count, mass):
    attempt = prepare(load_scenario("spheres_wall", {"support.kind": kind, "pile.count": count, "pile.mass": mass}), 0)
    assert attempt.plan.primitives[1].travel > 0.1


@pytest.mark.parametrize("ratio", [0.3, 1.5])
def test_balls_of_any_size_are_within_reach_of_the_shovel(ratio):
    scale = ratio * 0.12 / 0.054
    keys = {"support.kind": "corner", "pile.scale": scale, "pile.frame_size": 0.25 * scale, "hand": "shovel"}
    assert prepare(load_scenario("spheres_wall", keys), 0).plan.primitives[1].travel > 0.15
