"""The object-based strategy: the object that it aims at, from poses alone."""

import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.planning.object_choice import choose_object
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sim.hand import Hand

RADIUS = 0.027
PUSH = np.array([1.0, 0.0])
UP, ALONG, ACROSS = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])


def on_table(*plane):
    return np.array([[x, y, RADIUS] for x, y in plane])


def choose(pile, push=PUSH, axes=None):
    return choose_object(pile, push, RADIUS, np.median(pile[:, :2], axis=0), axes)


def test_the_front_object_that_moves_toward_the_centre_is_chosen():
    pile = on_table((0.8, -0.12), (0.8, 0.0), (0.8, 0.12), (0.9, -0.06), (0.9, 0.06), (0.9, 0.0), (0.95, 0.0))
    assert choose(pile) == 1


@pytest.mark.parametrize(("center", "expected"), [((0.95, 0.0), 0), ((0.95, 0.1), 1)])
def test_the_choice_depends_on_the_given_centre(center, expected):
    assert choose_object(on_table((0.8, 0.0), (0.8, 0.1)), PUSH, RADIUS, np.array(center)) == expected


def test_an_object_behind_another_one_is_not_chosen():
    pile = on_table((0.90, 0.0), (0.80, 0.01), (1.0, -0.1), (1.0, 0.1))
    assert choose(pile) == 1


def test_an_object_on_others_is_not_chosen():
    pile = np.vstack([on_table((0.9, -0.02), (0.9, 0.06), (0.95, 0.02)), [0.85, 0.02, 0.07]])
    assert choose(pile) in (0, 1)


@pytest.mark.parametrize(("diameters", "expected"), [(1.0, 1), (1.1, 1), (1.2, 0), (1.5, 0)])
def test_an_object_that_would_slide_away_along_the_neighbour_that_it_touches_loses(diameters, expected):
    # The first one is nearer to the centre's line; a neighbour that it touches turns it outwards.
    first, second = (0.8, -0.05), (0.8, 0.06)
    neighbour = (0.8 + 0.045 * diameters, -0.05 + 0.03 * diameters)
    pile = on_table(first, second, neighbour, (0.95, 0.02), (0.95, 0.0))
    assert choose(pile) == expected


@pytest.mark.parametrize("alpha", [0.0, 0.5, -1.2])
def test_the_choice_turns_with_the_push(alpha):
    pile = on_table((0.8, -0.12), (0.8, 0.01), (0.8, 0.12), (0.9, -0.06), (0.9, 0.06), (0.95, 0.0))
    turn = np.array([[np.cos(alpha), -np.sin(alpha)], [np.sin(alpha), np.cos(alpha)]])
    turned = pile.copy()
    turned[:, :2] = pile[:, :2] @ turn.T
    assert choose(turned, turn @ PUSH) == choose(pile) == 1


@pytest.mark.parametrize("axis", [UP, ACROSS, -UP, -ACROSS])
def test_a_cylinder_that_can_roll_or_is_upright_is_preferred(axis):
    pile = on_table((0.8, 0.0), (0.8, 0.1), (0.9, 0.0), (0.9, -0.05))
    axes = np.array([ALONG, axis, ALONG, ALONG])
    assert choose(pile, axes=axes) == 1


@pytest.mark.parametrize(
    ("axis", "expected"),
    [
        ((np.sin(np.radians(19.0)), 0.0, np.cos(np.radians(19.0))), 1),
        ((np.sin(np.radians(21.0)), 0.0, np.cos(np.radians(21.0))), 0),
        ((np.sin(np.radians(29.0)), np.cos(np.radians(29.0)), 0.0), 1),
        ((np.sin(np.radians(31.0)), np.cos(np.radians(31.0)), 0.0), 0),
    ],
    ids=["upright", "leaning", "broadside", "askew"],
)
def test_a_cylinder_within_20_deg_of_upright_or_30_deg_of_broadside_is_preferred(axis, expected):
    pile = on_table((0.8, 0.0), (0.8, 0.1), (0.9, 0.0), (0.9, -0.05))
    axes = np.array([ALONG, axis, ALONG, ALONG])
    assert choose(pile, axes=axes) == expected


def test_among_cylinders_that_all_point_along_the_push_the_place_decides():
    pile = on_table((0.8, 0.0), (0.8, 0.1), (0.9, 0.0), (0.9, -0.05))
    assert choose(pile, axes=np.tile(ALONG, (4, 1))) == 0


def test_one_object_alone_is_chosen():
    assert choose(on_table((0.8, 0.3))) == 0


def test_the_tool_frame_is_the_gap_that_is_centred_on_the_object():
    hand = Hand.load("rbo_hand2")
    tips = hand.parameters["fingers"]["tip"]
    gap = 0.5 * (np.array(tips["middle"]) + np.array(tips["ring"]))
    inside = hand.transform_tool_to_flange.inverse()
    assert abs((inside.rotation @ gap + inside.translation)[1]) < 1e-3


@pytest.mark.parametrize("name", ["light_sphere", "cylinder"])
def test_the_push_goes_through_the_chosen_object(name, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    keys = {"strategy.kind": "object", "pile.object": name, "pile.count": 6, "strategy.alpha_deg": 20.0}
    attempt = prepare(load_scenario("spheres_corner", keys), 3)
    touch, direction = attempt.plan.waypoints[1].translation[:2], attempt.plan.direction[:2]
    offset = attempt.pile.poses[:, :2] - touch
    aside = np.abs(offset @ np.array([-direction[1], direction[0]]))
    nearest = int(np.argmin(aside))
    assert aside[nearest] < 1e-9
    assert not np.allclose(np.median(offset, axis=0) @ np.array([-direction[1], direction[0]]), 0.0, atol=1e-6)


def test_the_object_based_strategy_needs_an_object():
    with pytest.raises(ConfigurationError, match="count is 0"):
        prepare(load_scenario("push_wall", {"strategy.kind": "object"}), 0)
