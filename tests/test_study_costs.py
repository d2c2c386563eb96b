"""What a study costs: the stages of an attempt, and what the parent adds."""

import mujoco
import pytest
from study_tasks import PoolHere, short_attempt

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.experiments.study import scaling, stages


def test_the_stages_of_an_attempt_add_up(monkeypatch):
    monkeypatch.setattr(stages, "SEEDS", (0,))
    monkeypatch.setattr(stages, "REPEATS", 1)
    monkeypatch.setattr(stages, "_start", lambda: 1.0)
    step = mujoco.mj_step
    found = stages.stages(load_scenario("push_wall", {"pile.count": 3, "strategy.grasp_force": 1.0}))
    assert mujoco.mj_step is step
    parts = [stage for stage in found if stage not in (stages.START, stages.SETTLED, stages.ATTEMPT)]
    assert found[stages.ATTEMPT] == pytest.approx(sum(found[stage] for stage in parts))
    assert all(found[stage] > 0.0 for stage in parts)
    # The second time it is in the cache.
    assert found[stages.SETTLED] > 3.0 * found[stages.LOADED]
    assert found[stages.START] == 1.0


def test_only_attempts_after_the_first_of_each_worker_count():
    begun = []

    def attempt(order):
        begun.append(order.seed)
        return short_attempt(order)

    cost = scaling.measure(PoolHere(), 2, attempt, load_scenario("spheres_wall"), each=3)
    assert begun == list(range(8))
    assert (cost.workers, cost.attempts) == (2, 6)
    assert cost.per_minute == pytest.approx(60.0 * 6 / cost.wall)
    assert cost.wall > 6 * 0.005


def test_a_projection_ends_where_the_parent_is_busy():
    assert scaling.projected(10, attempt=3.0, parent=0.01) == pytest.approx(200.0)
    assert scaling.projected(1000, attempt=3.0, parent=0.01) == pytest.approx(6000.0)
