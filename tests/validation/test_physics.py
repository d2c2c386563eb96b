"""The fast checks of the physics, their parts, and the page that shows all checks."""

import json
import math

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.cli import main
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import OBJECT_MODELS
from pilegrasp_ctrl.validation.physics import restitution, suite
from pilegrasp_ctrl.validation.physics.contact_rig import ContactRig, bouncing
from pilegrasp_ctrl.validation.physics.energy import bounce_gain, fall_drift, gain
from pilegrasp_ctrl.validation.physics.friction import roll, slip
from pilegrasp_ctrl.validation.physics.hung_weight import reading
from pilegrasp_ctrl.validation.physics.penetration import impact_depth
from pilegrasp_ctrl.validation.physics.physics_check import PhysicsCheck, markdown
from pilegrasp_ctrl.validation.physics.plant import added_gravity, plant_checks
from pilegrasp_ctrl.validation.physics.restitution import drops, rebound
from places import DOCS, ROOT

PAGE = DOCS / "physics.md"


@pytest.fixture(scope="module")
def rig():
    return ContactRig.build(OBJECT_MODELS["light_sphere"], Hand.load("shovel"))


@pytest.mark.parametrize(
    ("relation", "measured", "ok"),
    [
        ("=", 1.1, True),
        ("=", 1.3, False),
        ("=", 0.7, False),
        ("<=", 0.0, True),
        ("<=", 1.3, False),
        (">=", 9.0, True),
        (">=", 0.7, False),
        ("=", math.nan, False),
        ("<=", -math.inf, False),
    ],
)
def test_a_verdict_follows_from_the_numbers(relation, measured, ok):
    assert PhysicsCheck("x", 1.0, measured, 0.2, "-", relation).ok is ok


def test_a_measurement_that_is_not_finite_is_still_json():
    document = PhysicsCheck("x", 1.0, math.nan, 0.2, "-").as_dict()
    assert json.loads(json.dumps(document, allow_nan=False))["measured"] is None


@pytest.mark.parametrize("where", ["table", "wall", "object", "shovel floor", "shovel back"])
def test_restitution_on_every_spot(rig, where):
    result = drops(rig, where)
    assert result.requested == (0.8 if "shovel" in where else 0.72)
    assert result.worst_mean == pytest.approx(result.requested, abs=0.03)


def test_a_drop_touches_nothing_but_its_spot(rig):
    for spot in rig.spots.values():
        data = rig.place(spot, 0.1)
        for _ in range(300):
            mujoco.mj_step(rig.model, data)
            touched = {rig.model.geom(int(geom)).name for pair in data.contact.geom for geom in pair}
            assert touched <= {spot.geom, "object_1"}


def test_the_measured_contact_has_the_requested_parameters(rig):
    dull = ContactRig.build(bouncing(OBJECT_MODELS["light_sphere"], 0.4), Hand.load("shovel"))
    assert rebound(dull, dull.spots["table"], 0.3) < 0.5 < rebound(rig, rig.spots["table"], 0.3)
    assert rebound(dull, dull.spots["shovel floor"], 0.3) > 0.7


def test_a_cube_slips_within_a_degree_and_a_ball_rolls_by_the_formula(rig):
    cube = ContactRig.build(OBJECT_MODELS["cube"], Hand.load("shovel"))
    friction = cube.object_model.surface.lateral
    angle = slip(cube, cube.spots["table"], friction).angle
    assert math.degrees(angle) == pytest.approx(math.degrees(math.atan(friction)), abs=1.0)
    result = roll(rig)
    assert result.deceleration == pytest.approx(result.formula, rel=0.05)
    # mu_r g / (R (1 + k)) of a hollow ball, by hand.
    assert result.formula == pytest.approx(0.002 * 9.81 / (0.027 * 1.55))


def test_an_object_that_does_not_slip_has_no_angle():
    rig = ContactRig.build(OBJECT_MODELS["cube"], Hand.load("shovel"))
    assert math.isnan(slip(rig, rig.spots["table"], 0.05).angle)


def test_energy_is_kept_in_the_air_and_not_gained_on_the_table(rig):
    # Semi-implicit Euler loses m g² dt t / 2.
    assert fall_drift(rig) == pytest.approx(0.5 * 9.81 * 1e-3 * math.sqrt(2 * 0.5 / 9.81) / 0.5, rel=0.05)
    assert bounce_gain(rig, "table") < 1e-3


def test_a_gain_is_found_between_blocks_and_not_within_them():
    falling = np.linspace(1.0, 0.0, 1000)
    assert gain(list(falling), 1e-3) < 0.0
    spring = falling - 0.2 * (np.arange(1000) % 10 == 0)
    assert gain(list(spring), 1e-3) < 0.0
    falling[600:] += 0.3
    assert gain(list(falling), 1e-3) == pytest.approx(0.3 - 0.05, abs=0.01)


def test_a_ball_stays_before_the_wall(rig):
    assert 0.001 < impact_depth(rig, "wall", 0.7) < 0.004
    assert impact_depth(rig, "wall", 0.3) < impact_depth(rig, "wall", 0.7)


def test_a_hung_kilogram_is_read():
    np.testing.assert_allclose(reading("shovel", np.array([0.4, -1.1, 0.3])), [0.0, 0.0, -9.81], atol=0.05)


GOOD, BAD = PhysicsCheck("fine", 1.0, 1.0, 0.1, "-"), PhysicsCheck("off", 1.0, 2.0, 0.1, "mm")


@pytest.mark.parametrize(("checks", "status"), [((GOOD,), 0), ((GOOD, BAD), 2)])
def test_the_verb_prints_every_check_and_fails_if_one_fails(capsys, monkeypatch, checks, status):
    monkeypatch.setattr(suite, "SUITES", ((1.0, lambda: checks),))
    for flags in (["--json"], []):
        assert main(["doctor", "--physics", *flags]) == status
        out, err = capsys.readouterr()
        if flags:
            document = json.loads(out)
            assert document["ok"] is (status == 0)
            assert [check["name"] for check in document["checks"]] == [check.name for check in checks]
        else:
            assert all(check.name in out for check in checks)
        assert ("off" in err) is (status == 2)
        assert "Traceback" not in err


def test_the_page_shows_every_check():
    """A suite that costs seconds is run; of the others the page has rows of the same beginning."""
    rows = [line.split("|")[1].strip() for line in PAGE.read_text(encoding="utf-8").splitlines() if "| ok |" in line]
    names = [check.name for check in suite.step_halving_checks()]
    assert [row for row in rows if row.startswith("half step")] == names
    kinds = {row.partition(":")[0] for row in rows}
    assert kinds >= {"restitution", "slip", "rolling", "energy", "wrench", "depth", "passed through", "rest"}


def test_a_known_miss_is_reported_and_does_not_fail(capsys, monkeypatch):
    monkeypatch.setattr(suite, "SUITES", ((1.0, lambda: (GOOD, BAD)),))
    monkeypatch.setattr(suite, "KNOWN", {"off": "one contact on a flat end"})
    assert main(["doctor", "--physics", "--json"]) == 0
    assert [(row["ok"], row["known"]) for row in json.loads(capsys.readouterr().out)["checks"]] == [
        (True, ""),
        (False, "one contact on a flat end"),
    ]
    assert main(["doctor", "--physics"]) == 0
    assert "missed: one contact on a flat end" in capsys.readouterr().out


def test_known_misses_are_still_measured():
    rows = {line.split("|")[1].strip() for line in PAGE.read_text(encoding="utf-8").splitlines() if "| missed:" in line}
    assert rows == suite.KNOWN.keys()


def test_a_table_row_shows_the_requested_and_the_measured_number():
    assert markdown([BAD]).splitlines()[-1] == "| off | 1 mm | 2 mm | ±0.1 mm | failed |"


def test_the_library_never_imports_pybullet():
    root = ROOT / "pilegrasp_ctrl"
    own = [file for file in root.rglob("*.py") if "scenarios" not in file.parts]
    assert [file.name for file in own if "import pybullet" in file.read_text(encoding="utf-8")] == []


def test_a_measurement_that_came_from_numpy_is_still_json():
    row = json.loads(json.dumps(PhysicsCheck("x", 1.0, np.float64(1.1), np.float64(0.2), "-").as_dict()))
    assert (row["measured"], row["ok"]) == (1.1, True)


def test_the_simulated_arm_is_as_heavy_as_asked_for():
    assert [check for check in plant_checks() if not check.ok] == []
    # The arm of seed 0 is drawn as well, so its links are not those of the model.
    assert added_gravity(1.1) == pytest.approx(0.1, rel=0.03)
    assert added_gravity(1.0) == 0.0


def test_an_object_as_wide_as_the_tray_falls_onto_its_floor():
    rig = ContactRig.build(OBJECT_MODELS["apple"], Hand.load("shovel"))
    assert rebound(rig, rig.spots["shovel floor"], 0.1) == pytest.approx(0.8, abs=0.06)


def test_an_object_that_never_arrives_has_no_restitution(rig, monkeypatch):
    monkeypatch.setattr(restitution, "MAX_FALL_TIME", 0.01)
    assert math.isnan(rebound(rig, rig.spots["table"], 0.1))
