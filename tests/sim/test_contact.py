"""Does the engine do what was asked? Restitution from a drop, friction from an incline, energy of a bounce."""

import math

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.sim.contact import (
    NATURAL_FREQUENCY,
    SUPPORT,
    Surface,
    add_pair,
    combine,
    damping_ratio_for,
    pair_parameters,
    restitution_for_mass,
    restitution_of,
)
from pilegrasp_ctrl.sim.object_model import SMOOTH
from pilegrasp_ctrl.sim.objects import OBJECT_MODELS, object_model
from pilegrasp_ctrl.sim.scene import new_spec

GRAVITY = 9.81


def on_a_plane(kind, surface, timestep=1e-3):
    spec = new_spec(timestep)
    spec.worldbody.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1], contype=0, conaffinity=0)
    kind.add_to(spec, 0, (1, 1, 1, 1))
    add_pair(spec, "object_0", "table", pair_parameters(surface, timestep))
    return spec.compile()


def rebounds(kind, surface, height, timestep=1e-3):
    """Drop upright from `height` at 16 phases of a step; return the speeds after the bounce over those before it."""
    model = on_a_plane(kind, surface, timestep)
    rest = kind.half_size[{"cylinder": 1, "box": 2, "ellipsoid": 2}.get(kind.shape, 0)]
    got = []
    for phase in np.linspace(0.0, math.sqrt(2.0 * GRAVITY * height) * timestep, 16, endpoint=False):
        data = mujoco.MjData(model)
        data.qpos[:3] = 0.0, 0.0, rest + height + phase
        while data.qpos[2] > rest or data.qvel[2] < 0.0:
            mujoco.mj_step(model, data)
        while data.qpos[2] < rest:
            mujoco.mj_step(model, data)
        after = math.sqrt(data.qvel[2] ** 2 + 2.0 * GRAVITY * (data.qpos[2] - rest))
        got.append(after / math.sqrt(2.0 * GRAVITY * (height + phase)))
    return got


@pytest.mark.parametrize("timestep", [0.0005, 0.001])
@pytest.mark.parametrize("height", [0.1, 0.5])
@pytest.mark.parametrize("name", ["light_sphere", "heavy_sphere", "cube", "cylinder"])
def test_what_is_dropped_rebounds_with_the_restitution_asked_for(name, height, timestep):
    kind = object_model(name)
    # The impact falls anywhere between two steps; the mean over phases is what a pile sees.
    got = rebounds(kind, kind.surface, height, timestep)
    assert np.mean(got) == pytest.approx(kind.surface.restitution, abs=0.03)
    assert max(got) < 1.0


@pytest.mark.parametrize("height", [0.1, 0.5])
@pytest.mark.parametrize("asked", [0.3, 0.5, 0.7, 0.9])
def test_restitution_over_the_whole_range(asked, height):
    got = rebounds(OBJECT_MODELS["light_sphere"], Surface(0.6, 0.001, 0.001, asked, rank=1), height)
    assert np.mean(got) == pytest.approx(asked, abs=0.03)


@pytest.mark.parametrize("step", [0.15, 0.3, 0.6])
def test_damping_ratio_inverts_the_restitution_law(step):
    for asked in np.linspace(0.25, 0.99, 10):
        assert restitution_of(damping_ratio_for(asked, step), step) == pytest.approx(asked, abs=1e-9)
    assert damping_ratio_for(0.0, step) == pytest.approx(min(1.0, 0.5 / step))
    with pytest.raises(ValueError, match="restitution"):
        damping_ratio_for(1.2, step)


@pytest.mark.parametrize("zeta", [0.05, 0.2, 0.5, 0.9])
def test_small_steps_lead_to_the_law_of_the_continuous_contact(zeta):
    """Schwager & Pöschel (2007), eq. 18: the contact ends where the force, not the penetration, is back at zero."""
    root = math.sqrt(1.0 - zeta**2)
    law = math.exp(-zeta / root * (math.pi - math.atan2(2.0 * zeta * root, 1.0 - 2.0 * zeta**2)))
    assert restitution_of(zeta, 0.002) == pytest.approx(law, abs=1e-3)


def test_a_restitution_of_nothing_is_not_turned_into_a_kick():
    """Beyond 0.5 / step the damper alone reverses the velocity within a step, and the bounce grows again."""
    for timestep in (5e-4, 1e-3, 2e-3):
        step = NATURAL_FREQUENCY * timestep
        assert restitution_of(damping_ratio_for(0.0, step), step) < 0.2
    assert restitution_of(1.2, 0.6) > 0.5


def slide(angle, mu):
    """Return how far a cube slides down an incline in half a second, starting at rest on it [m]."""
    cube = object_model("cube")
    model = on_a_plane(cube, Surface(mu, 0.001, 0.001, 0.1, rank=1))
    model.opt.gravity[:] = GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle)
    data = mujoco.MjData(model)
    data.qpos[2] = cube.half_size[2]
    for _ in range(500):
        mujoco.mj_step(model, data)
    return data.qpos[0]


@pytest.mark.parametrize("mu", [0.25, 0.6])
def test_a_cube_slips_at_the_friction_angle(mu):
    angle = math.atan(mu)
    free = 0.5 * 0.5**2 * GRAVITY
    assert slide(angle - math.radians(1.0), mu) < 0.004
    faster = slide(angle + math.radians(5.0), mu)
    expected = free * (math.sin(angle + math.radians(5.0)) - mu * math.cos(angle + math.radians(5.0)))
    assert faster == pytest.approx(expected, rel=0.1)


def test_a_rolling_ball_slows_down_as_rolling_friction_says():
    ball = object_model("heavy_sphere")
    model = on_a_plane(ball, Surface(0.6, 0.001, 0.001, 0.1, rank=1))
    data = mujoco.MjData(model)
    radius = ball.half_size[0]
    data.qpos[2] = radius
    data.qvel[0], data.qvel[4] = 0.5, 0.5 / radius
    for _ in range(200):
        mujoco.mj_step(model, data)
    before, start = data.qvel[0], data.time
    for _ in range(500):
        mujoco.mj_step(model, data)
    # m a R = mu_r m g - I a / R with I = 0.4 m R² for the solid ball
    assert (before - data.qvel[0]) / (data.time - start) == pytest.approx(0.001 * GRAVITY / (1.4 * radius), rel=0.05)


def test_a_ball_comes_to_rest():
    model = on_a_plane(object_model("light_sphere"), SMOOTH)
    data = mujoco.MjData(model)
    data.qpos[2] = 0.1
    for _ in range(4000):
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel).max() < 1e-3


def test_the_three_rules_differ_as_their_names_say():
    hand = Surface(0.5, 0.001, 0.001, 0.8, rank=2)
    ball = SMOOTH
    assert combine(hand, ball, "paper") == hand
    assert combine(ball, SUPPORT, "paper") == ball
    product = combine(hand, ball, "product")
    assert (product.lateral, product.restitution) == pytest.approx((0.125, 0.576))
    assert product.rolling == pytest.approx(0.001 * 0.25 + 0.001 * 0.5)
    assert combine(hand, ball, "maximum").lateral == 0.5
    for rule in ("paper", "product", "maximum"):
        assert combine(hand, ball, rule) == combine(ball, hand, rule)
        assert combine(hand, SUPPORT, rule).restitution == 0.0


def test_restitution_is_the_papers_line_in_the_mass():
    assert restitution_for_mass(0.060) == pytest.approx(0.72)
    assert restitution_for_mass(0.180) == pytest.approx(0.37)
    assert restitution_for_mass(0.720) == 0.0
    assert object_model("light_sphere", mass=0.180).surface.restitution == pytest.approx(0.37)
