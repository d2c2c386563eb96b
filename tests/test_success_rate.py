"""Success rate: nearly 1 beside a wall, 0 without a support; `docs/results` has the rates of many attempts."""

import pytest

from pilegrasp_ctrl.episode import run


def attempts(scenario, seeds):
    """Return the number of objects held, and how the push ended, for each seed."""
    results = [run(scenario, seed=seed) for seed in seeds]
    return [
        (result.grasped, *[outcome.trigger for outcome in result.outcomes if outcome.name == "push"])
        for result in results
    ]


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


@pytest.mark.slow
def test_beside_a_wall_nearly_every_attempt_holds_an_object():
    results = attempts("spheres_wall", range(6))
    assert sum(held >= 1 for held, *_ in results) >= 5, results
    assert all(held == 0 for held, *pushes in results if pushes != ["grasp force"])


@pytest.mark.slow
def test_without_a_support_the_force_is_never_reached():
    for held, push in attempts("spheres_alone", range(2)):
        assert held == 0
        assert push.startswith("travel limit")
