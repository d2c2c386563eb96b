"""The camera looks from the side from which the scene is hidden least."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from page_parts import still
from pilegrasp_ctrl.recording import Body, Shape
from pilegrasp_ctrl.viewer.scene.camera import action_box, best_direction, directions
from synthetic_recording import synthetic


@pytest.fixture(scope="module")
def attempt():
    return synthetic()


def test_the_camera_looks_from_the_side_without_a_wall():
    tall = Shape("box", (0.4, 0.01, 0.5), (0.0, 0.0, 0.5))
    for side in (-1.0, 1.0):
        walled = still([Shape("sphere", (0.03,))])
        walled = replace(
            walled,
            bodies=(*walled.bodies, Body("wall", "support", (tall,))),
            body_position=np.array([[[0.0, 0.0, 0.03], [0.0, 0.2 * side, 0.0]]] * 2),
            body_quaternion=np.broadcast_to((1.0, 0.0, 0.0, 0.0), (2, 2, 4)),
        )
        assert best_direction(walled)[1] * side < -0.5
        glass = replace(walled.bodies[1], shapes=(replace(tall, rgba=(1, 1, 1, 0.0)),))
        through = replace(walled, bodies=(walled.bodies[0], glass))
        np.testing.assert_array_equal(best_direction(through), directions()[0])


def beside(*others, frames=2, **changes):
    """A ball at rest and other bodies of one box each: role, half sizes, opacity and place at each frame."""
    bodies = [Body("ball", "object", (Shape("sphere", (0.03,)),))]
    places = [np.tile([0.0, 0.0, 0.03], (frames, 1))]
    for index, (role, half, opacity, place) in enumerate(others):
        bodies.append(Body(f"box {index}", role, (Shape("box", half, rgba=(1, 1, 1, opacity)),)))
        places.append(np.broadcast_to(place, (frames, 3)))
    return still(
        [Shape("sphere", (0.03,))],
        frames=frames,
        bodies=tuple(bodies),
        body_position=np.stack(places, axis=1),
        body_quaternion=np.broadcast_to((1.0, 0.0, 0.0, 0.0), (frames, len(bodies), 4)),
        **changes,
    )


def test_the_camera_prefers_a_view_through_glass_to_a_view_of_an_arm():
    half = (0.8, 0.01, 0.8)
    arm, glass = ("arm", half, 1.0, (0.0, -0.2, 0.0)), ("support", half, 0.45, (0.0, 0.2, 0.0))
    assert best_direction(beside(arm, glass))[1] > 0.5
    assert best_direction(beside(glass))[1] < -0.5


def test_the_camera_leaves_its_preferred_view_for_one_that_hides_a_hundredth_less():
    preferred, second = directions()[:2]
    np.testing.assert_allclose(preferred, (0.0, -np.cos(np.deg2rad(24)), np.sin(np.deg2rad(24))), atol=1e-12)
    np.testing.assert_allclose(second, (0.0, -np.cos(np.deg2rad(42)), np.sin(np.deg2rad(42))), atol=1e-12)
    # A small pane in the preferred view hides the square of its opacity.
    pane = ((0.03, 0.005, 0.03), (0.0, -0.2, 0.03 + 0.2 * np.tan(np.deg2rad(24))))
    for hidden, chosen in ((0.008, preferred), (0.012, second)):
        scene = beside(("support", pane[0], np.sqrt(hidden), pane[1]))
        np.testing.assert_array_equal(best_direction(scene), chosen)


def test_the_camera_considers_the_ends_of_the_primitives():
    passing = np.tile([0.0, -0.2, 0.0], (90, 1))
    passing[:] += 5.0
    passing[44:48] -= 5.0
    arm = ("arm", (0.8, 0.01, 0.8), 1.0, passing)
    np.testing.assert_array_equal(best_direction(beside(arm, frames=90)), directions()[0])
    outcomes = [{"name": "push", "status": "ended", "start": 0.0, "end": 45 / 30}]
    assert best_direction(beside(arm, frames=90, meta={"outcomes": outcomes}))[1] > 0.5


def test_the_picture_holds_hand_and_pile_but_not_a_runaway(attempt):
    low, high = action_box(attempt)
    hand = attempt.body_position[:, [b.role == "hand" for b in attempt.bodies]].reshape(-1, 3)
    assert ((hand > low) & (hand < high)).all(axis=1).mean() > 0.95
    runaway = np.array(attempt.body_position)
    runaway[200:, [b.name for b in attempt.bodies].index("light_sphere_17")] += (30.0, 0.0, 0.0)
    assert action_box(replace(attempt, body_position=runaway))[1][0] < 1.5
