"""Shipped objects: Table I in its variants, inertia, mixes, and contacts of ellipsoids."""

import re

import mujoco
import numpy as np
import pytest

from object_table import table
from object_worlds import compile_objects
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.scenarios import object_files
from pilegrasp_ctrl.sim.contact import pair_parameters, restitution_for_mass
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import OBJECT_MODELS, object_model, objects_of
from pilegrasp_ctrl.sim.scene import build_scene
from places import DOCS

# Table I, and a prism for a null model: diameter or width, height [m] and mass [kg]
TABLE = {
    ("light_sphere", "real"): (0.054, 0.054, 0.060),
    ("light_sphere", "sim"): (0.056, 0.056, 0.060),
    ("light_sphere", "literal"): (0.112, 0.112, 0.060),
    ("heavy_sphere", "real"): (0.054, 0.054, 0.180),
    ("heavy_sphere", "sim"): (0.056, 0.056, 0.180),
    ("heavy_sphere", "literal"): (0.112, 0.112, 0.180),
    ("cylinder", "real"): (0.040, 0.050, 0.045),
    ("cylinder", "sim"): (0.045, 0.050, 0.045),
    ("cylinder", "literal"): (0.090, 0.050, 0.045),
    ("cube", "real"): (0.045, 0.045, 0.065),
    ("cube", "sim"): (0.050, 0.050, 0.065),
    ("cube", "literal"): (0.050, 0.050, 0.065),
    ("apple", "real"): (0.070, 0.064, 0.168),
    ("apple", "literal"): (0.140, 0.064, 0.168),
    ("lime", "real"): (0.049, 0.068, 0.029),
    ("lime", "literal"): (0.098, 0.068, 0.029),
    ("lime_net", "real"): (0.049, 0.068, 0.029),
    ("lime_net", "literal"): (0.098, 0.068, 0.029),
    ("prism", "real"): (0.040, 0.020, 0.0228),
}


@pytest.mark.parametrize(("name", "variant"), TABLE)
def test_sizes_and_masses_are_those_of_table_one(name, variant):
    objects = object_model(name, variant=variant)
    width, height, mass = TABLE[name, variant]
    model = compile_objects(objects, 3)
    lower, upper = model.geom_aabb[0, :3] - model.geom_aabb[0, 3:], model.geom_aabb[0, :3] + model.geom_aabb[0, 3:]
    np.testing.assert_allclose(upper - lower, [width, width, height], rtol=1e-9)
    assert objects.mass == model.body_mass[1] == mass
    assert objects.surface.restitution == restitution_for_mass(mass)
    felt = name in ("light_sphere", "heavy_sphere") or variant == "sim"
    skin = (0.5, 0.001, 0.002) if felt else (0.25, 0.001, 0.001)
    assert (objects.surface.lateral, objects.surface.spinning, objects.surface.rolling) == skin


def test_every_object_and_variant_of_table_one_ships():
    assert {name for name, _ in TABLE} == set(OBJECT_MODELS) == set(object_files())
    for name in ("apple", "lime", "lime_net"):
        with pytest.raises(ConfigurationError, match=r"no variant 'sim'; pile\.variant can be 'real' or 'literal'$"):
            object_model(name, variant="sim")


@pytest.mark.parametrize("name", OBJECT_MODELS)
def test_moments_of_inertia_follow_the_closed_formulas(name):
    objects = OBJECT_MODELS[name]
    model = compile_objects(objects, 3)
    m, size = objects.mass, objects.half_size
    match objects.shape:
        case "sphere":
            # A tennis ball is hollow, I = 0.55 m r² (Cross 2002); one full of sand is solid.
            expected = [(0.55 if name == "light_sphere" else 0.4) * m * size[0] ** 2] * 3
        case "cylinder":
            across = m * (size[0] ** 2 / 4.0 + (2.0 * size[1]) ** 2 / 12.0)
            expected = [across, across, m * size[0] ** 2 / 2.0]
        case "box":
            a, b, c = size
            expected = [m * (b * b + c * c) / 3.0, m * (a * a + c * c) / 3.0, m * (a * a + b * b) / 3.0]
        case "ellipsoid":
            a, b, c = size
            expected = [m * (b * b + c * c) / 5.0, m * (a * a + c * c) / 5.0, m * (a * a + b * b) / 5.0]
    np.testing.assert_allclose(np.sort(model.body_inertia[1]), np.sort(expected), rtol=1e-12)


def test_the_inertia_of_the_hollow_ball_is_between_those_of_a_solid_ball_and_a_shell():
    # Cross's 0.55 is a ball of 67 mm with a wall of 7 mm: 2/5 (R^5 - r^5) / (R^3 - r^3) / R^2.
    outer, inner = 0.0335, 0.0335 - 0.007
    thick = 0.4 * (outer**5 - inner**5) / (outer**3 - inner**3) / outer**2
    assert 0.4 < thick < 2.0 / 3.0
    ball = OBJECT_MODELS["light_sphere"]
    assert ball.inertia_factor * 0.4 == pytest.approx(0.55) == pytest.approx(thick, abs=0.01)


@pytest.mark.parametrize(("mass", "expected"), [(0.001, 0.892), (0.06, 0.72), (0.12, 0.545), (0.307, 0.0), (5.0, 0.0)])
def test_the_restitution_line_is_clipped(mass, expected):
    assert restitution_for_mass(mass) == pytest.approx(expected, abs=5e-4)
    assert object_model("cube", mass=mass).surface.restitution == restitution_for_mass(mass)


APPLES = (
    (
        0.8754882261265063,
        -0.001732984090922772,
        0.032003840340956505,
        -0.0437444151555225,
        0.07287487831583517,
        0.9962192273595564,
        -0.017970233506585536,
    ),
    (
        0.809712935254727,
        0.022103833570031768,
        0.032577505350394824,
        -0.9993791118306162,
        0.028279716995406205,
        0.015201364055538211,
        -0.014510926026931357,
    ),
)


def test_two_apples_that_touch_are_not_thrown_apart():
    # In this pose, from a push, MuJoCo's own search reports 14 mm of overlap instead of 0.015 mm.
    objects = OBJECT_MODELS["apple"]
    model = compile_objects(objects, 2)
    data = mujoco.MjData(model)
    data.qpos[:] = np.ravel(APPLES)
    mujoco.mj_forward(model, data)
    assert len(data.contact) == 1
    assert -2e-5 < data.contact[0].dist < 0.0


def test_the_page_of_objects_holds_the_table_and_an_object_that_loads(tmp_path):
    page = (DOCS / "objects.md").read_text(encoding="utf-8")
    assert table() in page
    (text,) = re.findall(r"^```text\n(.*?)^```", page, flags=re.MULTILINE | re.DOTALL)
    (tmp_path / "egg.toml").write_text(text)
    egg = object_model(str(tmp_path / "egg.toml"))
    assert (egg.shape, egg.surface.restitution, egg.surface.lateral, egg.surface.rolling) == (
        "ellipsoid",
        0.2,
        0.4,
        0.001,
    )


def test_a_pair_of_a_mix_has_the_coefficients_of_its_two_objects():
    scenario = load_scenario("spheres_wall", {"pile.object": "light_sphere+heavy_sphere", "pile.count": 3})
    objects = objects_of(scenario.pile)
    layout = make_layout(scenario.support, scenario.pile, objects.diameter)
    model = build_scene(scenario, Hand.load("shovel"), objects, layout).model
    solref = {
        frozenset(model.geom(int(geom)).name for geom in (model.pair_geom1[i], model.pair_geom2[i])): tuple(
            model.pair_solref[i]
        )
        for i in range(model.npair)
    }
    light, heavy = (pair_parameters(object_model(name).surface, 0.001) for name in ("light_sphere", "heavy_sphere"))
    assert solref[frozenset(("object_0", "table"))] == light.solref
    assert solref[frozenset(("object_1", "table"))] == heavy.solref
    assert solref[frozenset(("object_0", "object_1"))] == light.solref, "the bouncier of the two"
