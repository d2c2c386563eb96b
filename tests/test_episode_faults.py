"""Faults: impossible attempts are rejected before anything moves, and faults stop an attempt at once."""

import gc
import json
import tempfile

import numpy as np
import pytest

from pilegrasp_ctrl.analysis.motion import measure_attempt
from pilegrasp_ctrl.cli import main
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.episode import run
from pilegrasp_ctrl.exceptions import ConfigurationError, PileError, SimulationError, UnreachablePoseError
from pilegrasp_ctrl.robots import path
from pilegrasp_ctrl.sim import monitors
from pilegrasp_ctrl.sim.simulation import Simulation
from pilegrasp_ctrl.viewer.page.document import page

CONTROL_PERIOD = 0.002
ONE_ORDER = {"bin_picking": {"order.max_attempts": 1, "pile.count": 3}}


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory):
    """Give these tests an empty cache of piles of their own."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder))
        yield folder


# --- impossible attempts ----------------------------------------------------------------------------------------------


@pytest.fixture
def still(monkeypatch):
    def moved(_):
        pytest.fail("something moved")

    monkeypatch.setattr(Simulation, "step", moved)


@pytest.mark.parametrize(
    ("scenario", "overrides", "error", "words"),
    [
        (
            "free_space_line",
            {"line.start": [1.5, 0.0, 0.3]},
            UnreachablePoseError,
            ["(1.50, 0.00, 0.30) m", "line.start"],
        ),
        ("free_space_line", {"line.displacement": [0.0, 1.5, 0.0]}, UnreachablePoseError, ["(0.55, 1.35, 0.25) m"]),
        ("spheres_wall", {"strategy.theta_deg": 0.0}, UnreachablePoseError, ["theta_deg"]),
        ("push_wall", {"controller.rate": 300.0}, ConfigurationError, ["controller.rate", "300 Hz", "sim.timestep"]),
        ("push_wall", {"controller.rate": 2000.0}, ConfigurationError, ["2000 Hz", "0.001 s"]),
        ("push_wall", {"controller.gains": "nowhere.toml"}, ConfigurationError, ["nowhere.toml"]),
        ("push_wall", {"pile.object": "light_spere"}, ConfigurationError, ["light_sphere"]),
        ("push_wall", {"pile.cout": 3}, ConfigurationError, ["pile.count"]),
        ("spheres_wall", {"pile.scale": 4.0, "pile.count": 10}, PileError, ["216 mm", "150 mm", "pile.scale"]),
    ],
)
def test_an_impossible_attempt_is_rejected_before_anything_moves(still, scenario, overrides, error, words):
    with pytest.raises(error) as caught:
        run(scenario, overrides=overrides)
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("controller", "given"), [("operational_space", "impedance"), ("impedance", "operational_space")]
)
def test_gains_of_the_other_controller_are_rejected(still, controller, given):
    overrides = {"controller.kind": controller, "controller.gains": str(path("wam7", f"{given}.toml"))}
    with pytest.raises(ConfigurationError, match=f"{given}.toml.*controller.kind = '{controller}'"):
        run("push_wall", overrides=overrides)


def test_a_negative_seed_and_overrides_without_a_file_are_rejected(still):
    with pytest.raises(ConfigurationError, match="seed = -1"):
        run("push_wall", seed=-1)
    with pytest.raises(ConfigurationError, match="load_scenario"):
        run(load_scenario("push_wall"), overrides={"pile.count": 3})


# --- faults during an attempt -----------------------------------------------------------------------------------------


@pytest.fixture
def last_states(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_the_watchdog_stops_an_attempt_and_the_collector_runs_again(last_states, monkeypatch):
    monkeypatch.setattr(monitors, "MAX_PENETRATION", dict.fromkeys(monitors.MAX_PENETRATION, 1e-6))
    with pytest.raises(SimulationError, match="overlap") as caught:
        run("push_wall", record=True)
    assert gc.isenabled()
    (file,) = last_states.iterdir()
    assert str(file) in str(caught.value)
    assert load_scenario("push_wall").config_hash() in file.name
    with np.load(file) as states:
        assert states["time"][-1] > 2.0


@pytest.mark.parametrize("when", [0.2, 1.0])
def test_a_simulation_that_diverges_is_stopped_at_once(last_states, monkeypatch, when):
    """MuJoCo alone would start again from time zero if a state is not finite."""
    step = Simulation.step
    monkeypatch.chdir(last_states)

    def diverge(simulation):
        if abs(simulation.data.time - when) < 0.5 * CONTROL_PERIOD:
            simulation.data.qvel[0] = np.nan
        step(simulation)

    monkeypatch.setattr(Simulation, "step", diverge)
    with pytest.raises(SimulationError, match="not finite") as caught:
        run("push_wall")
    assert f"at {when:.1f}" in str(caught.value)
    assert gc.isenabled()


def test_another_error_restores_the_collector(monkeypatch):
    def fail(*_):
        raise ZeroDivisionError

    monkeypatch.setattr(monitors.Watchdog, "check", fail)
    gc.disable()
    try:
        with pytest.raises(ZeroDivisionError):
            run("push_wall")
        assert not gc.isenabled()
    finally:
        gc.enable()
    with pytest.raises(ZeroDivisionError):
        run("push_wall")
    assert gc.isenabled()


def test_the_collector_is_off_while_the_arm_moves_and_on_afterwards(monkeypatch):
    states = []
    step = Simulation.step

    def note(simulation):
        states.append(gc.isenabled())
        step(simulation)

    monkeypatch.setattr(Simulation, "step", note)
    run("push_wall")
    assert not any(states)
    assert gc.isenabled()


# --- nothing happened -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scenario", ["free_space_line", "push_wall", "bin_picking"])
def test_a_sensor_that_is_saturated_at_the_start_is_the_reason_of_a_result_like_any_other(scenario):
    result = run(scenario, record=True, overrides={"sensor.torque_noise": 10.0, **ONE_ORDER.get(scenario, {})})
    facts = json.loads(json.dumps(result.as_dict(), allow_nan=False))
    assert (facts["success"], facts["grasped"]) == (False, 0)
    assert facts["outcomes"][0]["trigger"].startswith("wrist sensor saturated: ")
    if scenario != "bin_picking":
        assert facts["reason"] == f"{facts['outcomes'][0]['name']}: {facts['outcomes'][0]['trigger']}"
        assert facts["controller"] == {"ticks": 0, "median_us": None, "p99_us": None, "limited": 0, "fallbacks": 0}
    assert json.loads(json.dumps(measure_attempt(result.recording), allow_nan=False))["table_force"] is None
    assert "wrist sensor saturated" in page(result.recording)


def test_the_command_line_tells_of_an_attempt_without_a_tick(capsys):
    assert main(["run", "free_space_line", "--set", "sensor.torque_noise=10"]) == 0
    out, err = capsys.readouterr()
    assert "no control tick" in out
    assert "wrist sensor saturated" in out
    assert err == ""
