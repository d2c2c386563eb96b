"""The environment for gymnasium: it passes the checker, repeats a run exactly, and lets an agent push again."""

import gc

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.learning import BACK_OFF, FIELDS, GRASP, LIFT, PUSH, GraspEnvironment

FEW = {"pile.count": 3}
"""Keys of a small pile."""


@pytest.fixture
def environment():
    found = GraspEnvironment("spheres_wall", overrides=FEW)
    yield found
    found.close()


@pytest.mark.slow
def test_the_environment_passes_the_checker():
    check_env(gymnasium.make("pilegrasp/Grasp-v0", overrides=FEW).unwrapped)


@pytest.mark.slow
def test_push_grasp_and_lift_repeat_a_run_to_the_last_bit(environment):
    collects = gc.isenabled()
    observation, told = environment.reset(seed=0)
    assert gc.isenabled() == collects
    assert environment.observation_space.contains(observation)
    outcomes, rewards = [], []
    for action in (PUSH, GRASP, LIFT):
        observation, reward, terminated, truncated, info = environment.step(action)
        outcomes.append(info)
        rewards.append(reward)
        assert (terminated, truncated) == (action == LIFT, False)
    run = pg.run("spheres_wall", seed=0, overrides=FEW)
    assert told["config_hash"] == run.config_hash
    for info, outcome in zip(outcomes, run.outcomes[1:], strict=True):
        expected = outcome.as_dict()
        assert info["primitive"] == expected.pop("name")
        assert {key: info[key] for key in expected} == expected
    assert rewards == [0.0, 0.0, float(run.success)]
    assert info["grasped"] == run.grasped
    with pytest.raises(ConfigurationError, match="call reset first"):
        environment.step(PUSH)


@pytest.mark.slow
def test_a_failed_push_can_be_repeated_and_the_agent_feels_that_it_failed():
    environment = GraspEnvironment("spheres_wall", overrides=FEW | {"support.kind": "none"}, max_steps=3)
    environment.reset(seed=1)
    names = [name for name, *_ in FIELDS]
    failed = names.index("whether the last primitive failed")
    way = names.index("way along the push")
    pushed, _, over, _, info = environment.step(PUSH)
    assert (info["primitive"], info["status"], over) == ("push", "failed", False)
    assert pushed[failed] == 1.0
    back, _, _, _, info = environment.step(BACK_OFF)
    assert info["primitive"] == "back_off"
    assert back[way] == pytest.approx(pushed[way] - 0.06, abs=0.005)
    _, reward, over, truncated, _ = environment.step(PUSH)
    assert (reward, over, truncated) == (0.0, False, True)
    environment.close()


def test_a_seed_gives_the_same_episode_and_none_draws_one(environment):
    first, told = environment.reset(seed=7)
    again, _ = environment.reset(seed=7)
    np.testing.assert_array_equal(first, again)
    assert told["seed"] == 7
    _, drawn = environment.reset()
    assert drawn["seed"] not in (0, 7)


def test_what_cannot_be_used_is_one_sentence(environment):
    with pytest.raises(ConfigurationError, match="must be 'grasp'"):
        GraspEnvironment("free_space_line")
    with pytest.raises(ConfigurationError, match="call reset first"):
        environment.step(PUSH)
    environment.reset(seed=0)
    with pytest.raises(ConfigurationError, match="must be 0 to 3"):
        environment.step(7)
