"""Contacts in the engine: restitution of a drop, friction on an incline, energy of a bounce."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.sections import PileConfig, SupportConfig
from pilegrasp_ctrl.sim.contact import (
    CONTACT_STEPS,
    SUPPORT,
    Surface,
    add_pair,
    combine,
    damping_ratio_for,
    largest_timestep,
    natural_frequency,
    pair_parameters,
    restitution_for_mass,
    restitution_of,
)
from pilegrasp_ctrl.sim.object_model import SMOOTH
from pilegrasp_ctrl.sim.objects import OBJECT_MODELS, object_model
from pilegrasp_ctrl.sim.scene import add_objects, add_support, new_spec

GRAVITY = 9.81


def on_a_plane(objects, surface, timestep=1e-3):
    spec = new_spec(timestep)
    spec.worldbody.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1], contype=0, conaffinity=0)
    objects.add_to(spec, 0, (1, 1, 1, 1))
    add_pair(spec, "object_0", "table", pair_parameters(surface, timestep))
    return spec.compile()


def rebounds(objects, surface, height, timestep=1e-3):
    """Drop upright from `height` at 16 phases of a step; return the speeds after the bounce over those before it."""
    model = on_a_plane(objects, surface, timestep)
    rest = objects.half_size[{"cylinder": 1, "box": 2, "ellipsoid": 2}.get(objects.shape, 0)]
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
def test_a_dropped_object_rebounds_with_its_restitution(name, height, timestep):
    objects = object_model(name)
    # An impact can happen at any moment between two steps, so the mean over the phases counts.
    got = rebounds(objects, objects.surface, height, timestep)
    assert np.mean(got) == pytest.approx(objects.surface.restitution, abs=0.03)
    assert max(got) < 1.0


@pytest.mark.parametrize("height", [0.1, 0.5])
@pytest.mark.parametrize("asked", [0.3, 0.5, 0.7, 0.9])
def test_a_dropped_ball_has_the_restitution_that_was_asked_for(asked, height):
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
    """Schwager & Pöschel (2007), eq. 18: the contact ends when the force, not the penetration, returns to zero."""
    root = math.sqrt(1.0 - zeta**2)
    law = math.exp(-zeta / root * (math.pi - math.atan2(2.0 * zeta * root, 1.0 - 2.0 * zeta**2)))
    assert restitution_of(zeta, 0.002) == pytest.approx(law, abs=1e-3)


def test_a_restitution_of_zero_does_not_reverse_the_velocity():
    """Beyond 0.5 / step the damper alone reverses the velocity within a step, and the bounce grows again."""
    for steps in (CONTACT_STEPS, 10, 20):
        step = math.pi / steps
        assert restitution_of(damping_ratio_for(0.0, step), step) < 0.21
    assert restitution_of(1.2, 0.6) > 0.5


def slide(angle, mu):
    """Return how far a cube slides down an incline in half a second, starting at rest on it [m]."""
    cube = object_model("cube")
    model = on_a_plane(cube, Surface(mu, 0.001, 0.001, 0.1, rank=1, flat=True))
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


def slide_on_the_table(angle, rule, mu):
    """Return how far a cube slides down the scene's own table in half a second, starting at rest on it [m]."""
    cube = object_model("cube")
    cube = replace(cube, surface=replace(cube.surface, lateral=mu, restitution=0.1))
    spec = new_spec(1e-3)
    layout = make_layout(SupportConfig(kind="none"), PileConfig(), cube.diameter)
    add_objects(spec, cube, 1, add_support(spec, layout), rule)
    model = spec.compile()
    model.opt.gravity[:] = GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle)
    data = mujoco.MjData(model)
    data.qpos[:3] = 0.5, 0.0, cube.half_size[2]
    for _ in range(500):
        mujoco.mj_step(model, data)
    return data.qpos[0] - 0.5


@pytest.mark.parametrize(
    ("rule", "mu", "expected"), [("paper", 0.4, 0.4), ("product", 0.8, 0.2), ("maximum", 0.1, 0.25)]
)
def test_objects_slip_on_the_table_at_the_friction_angle_of_smooth_wood(rule, mu, expected):
    """Cross (2002) measured the objects against smooth wood, whose sliding coefficient is 0.25."""
    angle = math.atan(expected) + math.radians(5.0)
    free = 0.5 * 0.5**2 * GRAVITY
    way = free * (math.sin(angle) - expected * math.cos(angle))
    assert slide_on_the_table(angle, rule, mu) == pytest.approx(way, rel=0.1)


@pytest.mark.parametrize("surface", [SUPPORT, SMOOTH])
def test_wood_and_bare_objects_have_the_coefficients_of_the_sources(surface):
    # Cross (2002, Tables I-II) for sliding; the paper (V-A) for the rest.
    assert (surface.lateral, surface.spinning, surface.rolling, surface.restitution) == (0.25, 0.001, 0.001, 0.72)


@pytest.mark.parametrize(
    ("stated", "timestep", "lasts"), [(0.005, 1e-4, 0.005), (0.005, 1e-3, 0.005), (0.0, 1e-4, 5e-4), (0.01, 1e-4, 0.01)]
)
def test_a_bounce_lasts_as_stated_or_five_steps(stated, timestep, lasts):
    assert math.pi / natural_frequency(Surface(0.25, 0.0, 0.0, 0.9, 1, stated), timestep) == pytest.approx(lasts)
    if timestep > 2e-4:
        return
    ball = object_model("light_sphere")
    model = on_a_plane(ball, Surface(0.25, 0.001, 0.001, 0.99, rank=1, contact_time=stated), timestep=timestep)
    data = mujoco.MjData(model)
    data.qpos[2] = ball.half_size[0] + 0.1
    touching = 0
    for _ in range(4000):
        mujoco.mj_step(model, data)
        touching += data.qpos[2] < ball.half_size[0]
    assert timestep * touching == pytest.approx(lasts, rel=0.21 if stated == 0.0 else 0.03)


def test_balls_bounce_as_long_as_tennis_balls_and_the_softer_body_counts():
    ball, cube = object_model("light_sphere").surface, object_model("cube").surface
    assert 0.004 <= ball.contact_time <= 0.005  # Cross (2002)
    assert (cube.contact_time, SUPPORT.contact_time) == (0.0, 0.0)
    for rule in ("paper", "product", "maximum"):
        assert combine(ball, cube, rule).contact_time == combine(SUPPORT, ball, rule).contact_time == ball.contact_time
        assert combine(cube, SUPPORT, rule).contact_time == 0.0


def test_the_largest_step_leaves_five_in_the_shortest_stated_bounce():
    ball, cube = object_model("light_sphere").surface, object_model("cube").surface
    assert largest_timestep(ball, cube) == pytest.approx(1e-3)
    assert largest_timestep(cube) == math.inf


def test_a_point_of_a_flat_face_bounces_twice_as_long_as_the_face():
    light, cube, lime = (object_model(name).surface for name in ("light_sphere", "cube", "lime"))
    assert [surface.flat for surface in (light, cube, lime)] == [False, True, False]
    assert natural_frequency(lime, 1e-3) >= 2.0 * natural_frequency(combine(lime, cube, "paper"), 1e-3)


def test_a_resting_ball_sags_by_twelve_micrometers():
    ball = object_model("heavy_sphere")
    model = on_a_plane(ball, ball.surface)
    data = mujoco.MjData(model)
    data.qpos[2] = ball.half_size[0]
    for _ in range(3000):
        mujoco.mj_step(model, data)
    assert ball.half_size[0] - data.qpos[2] == pytest.approx(12.3e-6, rel=0.1)


def test_a_pressed_fingertip_sinks_by_two_millimeters():
    """A tip of 5 g under 20 N; with the contact of an object it would be 8 mm."""
    tip = replace(object_model("light_sphere"), mass=0.005, half_size=(0.0035,))
    for rank, depth in ((2, 0.0018), (1, 0.0081)):
        model = on_a_plane(tip, Surface(0.8, 0.001, 0.001, 0.0, rank=rank, contact_time=0.01))
        data = mujoco.MjData(model)
        data.qpos[2] = 0.0035
        data.xfrc_applied[1, 2] = -20.0
        for _ in range(3000):
            mujoco.mj_step(model, data)
        assert 0.0035 - data.qpos[2] == pytest.approx(depth, rel=0.05)


def test_a_rolling_ball_slows_down_by_the_rolling_friction():
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


def test_the_three_rules_combine_coefficients_as_documented():
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


def test_the_restitution_is_the_papers_linear_function_of_the_mass():
    assert restitution_for_mass(0.060) == pytest.approx(0.72)
    assert restitution_for_mass(0.180) == pytest.approx(0.37)
    assert restitution_for_mass(0.720) == 0.0
    assert object_model("light_sphere", mass=0.180).surface.restitution == pytest.approx(0.37)
