"""An error names an allowed value, and this value is then accepted."""

import re
from pathlib import Path

import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError, ModelError, RecordingError
from pilegrasp_ctrl.files import cache_folder
from pilegrasp_ctrl.programs.attempt import check, prepare
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.sim.objects import OBJECT_MODELS, object_model


@pytest.mark.parametrize("name", ["Cube", "light_spere"])
def test_the_error_of_a_misspelt_object_suggests_its_name(name):
    with pytest.raises(
        ConfigurationError, match=rf"pile\.object = '{name}' is not known; did you mean '(\w+)'\?$"
    ) as e:
        object_model(name)
    assert object_model(str(e.value).split("'")[-2])


def test_the_error_of_an_unknown_object_lists_the_objects():
    with pytest.raises(ConfigurationError, match=f"choose from {', '.join(OBJECT_MODELS)}$"):
        object_model("zzz")


@pytest.mark.parametrize("settings", [{"controller.rate": 333.0}, {"controller.rate": 2000.0}, {"sim.timestep": 3e-4}])
def test_the_error_of_a_rate_that_does_not_fit_suggests_one_that_does(settings):
    with pytest.raises(ConfigurationError, match="whole number of physics steps, as at ") as e:
        prepare(load_scenario("push_wall", settings), seed=0)
    rate = float(re.search(r"as at ([\d.]+) Hz", str(e.value))[1])
    prepare(load_scenario("push_wall", settings | {"controller.rate": rate}), seed=0)


def test_a_step_that_is_too_long_for_a_bounce_is_refused_with_the_longest():
    coarse = {"sim.timestep": 0.002}
    with pytest.raises(ConfigurationError, match=r"0\.002 s is too long: a bounce of light_sphere lasts 0\.005 s") as e:
        check(load_scenario("spheres_wall", coarse))
    assert str(e.value).endswith("make it 0.001 or less")
    # Wood has no time of its own, and the hand's rubber is soft.
    check(load_scenario("cubes_wall", coarse))


def test_the_error_of_an_unknown_robot_lists_the_robots():
    with pytest.raises(ModelError, match=r"no robot 'pr2'; choose from panda, wam7"):
        prepare(load_scenario("push_wall", {"robot": "pr2"}), seed=0)


def test_a_recording_must_be_a_regular_file():
    with pytest.raises(RecordingError, match="not a regular file"):
        Recording.load("/dev/zero")


def test_the_cache_needs_no_home_folder(monkeypatch):
    def homeless():
        raise RuntimeError

    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setattr(Path, "home", homeless)
    assert cache_folder().is_absolute()
