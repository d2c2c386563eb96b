"""Does the engine do what was asked? Restitution from a drop, friction from an incline, energy of a bounce."""

import math

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.sim.contact import add_pair, combine, damping_ratio_for, pair_parameters, restitution_of
from pilegrasp_ctrl.sim.objects import KINDS, TENNIS_BALL, object_kind, restitution_for_mass
from pilegrasp_ctrl.sim.scene import new_spec
from pilegrasp_ctrl.sim.surface import SUPPORT, Surface

GRAVITY = 9.81


def on_a_plane(kind, surface, timestep=1e-3):
    spec = new_spec(timestep)
    spec.worldbody.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1], contype=0, conaffinity=0)
    kind.add_to(spec, 0, (1, 1, 1, 1))
    add_pair(spec, "object_0", "table", pair_parameters(surface))
    return spec.compile()


def rebound(kind, surface, height, timestep=1e-3):
    """Drop from `height` and return the speed after the bounce over the speed before it."""
    model = on_a_plane(kind, surface, timestep)
    data = mujoco.MjData(model)
    radius = kind.half_size[0]
    data.qpos[:3] = 0.0, 0.0, radius + height
    while data.qpos[2] > radius or data.qvel[2] < 0.0:
        mujoco.mj_step(model, data)
    while data.qpos[2] < radius:
        mujoco.mj_step(model, data)
    after = math.sqrt(data.qvel[2] ** 2 + 2.0 * GRAVITY * (data.qpos[2] - radius))
    return after / math.sqrt(2.0 * GRAVITY * height)


@pytest.mark.parametrize("name", ["light_sphere", "heavy_sphere"])
@pytest.mark.parametrize("height", [0.1, 0.3, 0.5])
def test_a_dropped_ball_rebounds_with_the_restitution_asked_for(name, height):
    kind = object_kind(name)
    asked = combine(kind.surface, SUPPORT, "paper").restitution
    # The impact falls anywhere between two steps; the mean over phases is what a pile sees.
    got = [rebound(kind, kind.surface, height + phase) for phase in np.linspace(0.0, 0.004, 9)]
    assert np.mean(got) == pytest.approx(asked, abs=0.04)
    assert max(got) < 1.0


@pytest.mark.parametrize("asked", [0.3, 0.5, 0.8, 0.9])
def test_restitution_over_the_whole_range(asked):
    surface = Surface(0.6, 0.001, 0.001, asked, rank=1)
    got = [rebound(KINDS["light_sphere"], surface, 0.3 + phase) for phase in np.linspace(0.0, 0.004, 9)]
    assert np.mean(got) == pytest.approx(asked, abs=0.04)


def test_damping_ratio_inverts_the_restitution_law():
    for asked in np.linspace(0.06, 0.99, 25):
        assert restitution_of(damping_ratio_for(asked)) == pytest.approx(asked, abs=1e-9)
    assert restitution_of(1.0) == pytest.approx(restitution_of(1.0 - 1e-9), abs=1e-6)
    assert restitution_of(1.0) == pytest.approx(restitution_of(1.0 + 1e-9), abs=1e-6)
    with pytest.raises(ValueError, match="restitution"):
        damping_ratio_for(1.2)


def slide(angle, mu):
    """Return how far a cube slides down an incline in half a second, starting at rest on it [m]."""
    cube = object_kind("cube")
    model = on_a_plane(cube, Surface(mu, 0.001, 0.001, 0.1, rank=1))
    model.opt.gravity[:] = GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle)
    data = mujoco.MjData(model)
    data.qpos[2] = cube.half_size[2]
    for _ in range(500):
        mujoco.mj_step(model, data)
    return data.qpos[0]


@pytest.mark.parametrize("mu", [0.3, 0.6])
def test_a_cube_slips_at_the_friction_angle(mu):
    angle = math.atan(mu)
    free = 0.5 * 0.5**2 * GRAVITY
    assert slide(angle - math.radians(1.0), mu) < 0.004
    faster = slide(angle + math.radians(5.0), mu)
    expected = free * (math.sin(angle + math.radians(5.0)) - mu * math.cos(angle + math.radians(5.0)))
    assert faster == pytest.approx(expected, rel=0.1)


def test_a_rolling_ball_slows_down_as_rolling_friction_says():
    ball = object_kind("heavy_sphere")
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
    model = on_a_plane(object_kind("light_sphere"), TENNIS_BALL)
    data = mujoco.MjData(model)
    data.qpos[2] = 0.1
    for _ in range(4000):
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel).max() < 1e-3


def test_the_three_rules_differ_as_their_names_say():
    hand = Surface(0.5, 0.001, 0.001, 0.8, rank=2)
    ball = TENNIS_BALL
    assert combine(hand, ball, "paper") == hand
    assert combine(ball, SUPPORT, "paper") == ball
    product = combine(hand, ball, "product")
    assert (product.lateral, product.restitution) == pytest.approx((0.30, 0.576))
    assert product.rolling == pytest.approx(0.001 * 0.6 + 0.001 * 0.5)
    assert combine(hand, ball, "maximum").lateral == 0.6
    for rule in ("paper", "product", "maximum"):
        assert combine(hand, ball, rule) == combine(ball, hand, rule)
        assert combine(hand, SUPPORT, rule).restitution == 0.0


def test_restitution_is_the_papers_line_in_the_mass():
    assert restitution_for_mass(0.060) == pytest.approx(0.72)
    assert restitution_for_mass(0.180) == pytest.approx(0.37)
    assert restitution_for_mass(0.720) == 0.0
    assert object_kind("light_sphere", mass=0.180).surface.restitution == pytest.approx(0.37)
