"""Where the processor time of one attempt goes, from the start of the process to the verdict.

`python docs/studies/attempt_profile.py [NAME [KEY=VALUE]...]` prints it as a table.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from time import thread_time
from typing import Any
from unittest.mock import patch

from pilegrasp_ctrl.config import Scenario, load_scenario, parse_overrides
from pilegrasp_ctrl.statistics import markdown_table

SEEDS = (0, 1)
REPEATS = 2
"""Of each seed; the least time of a stage is told, since whatever else runs on the machine only adds to it."""

START, SETTLED = "process start and imports, once a worker", "pile settled, not in the cache, once a seed"
LOADED, SEARCHED, BUILT = "pile from the cache", "start posture and reach (mink)", "scene and models"
PHYSICS, SENSOR, WATCHDOG = "physics (mj_step)", "wrist sensor", "watchdog"
STATE, CONTROL, REST = "arm's terms (Pinocchio)", "controller", "primitives and the loop itself"
ATTEMPT = "attempt, pile in the cache"


def stages(scenario: Scenario) -> dict[str, float]:
    """Return the processor time of each stage of an attempt [s], the mean over a few seeds; `ATTEMPT` is its sum.

    Raises:
        PilegraspError: where the scenario cannot be run.
    """
    least: dict[str, list[float]] = defaultdict(list)
    for seed in SEEDS:
        with _empty_cache():
            settled = _attempt(scenario, seed)[LOADED]
            rounds = [_attempt(scenario, seed) for _ in range(REPEATS)]
        for stage in rounds[0]:
            least[stage].append(min(took[stage] for took in rounds))
        least[SETTLED].append(settled)
    found = {stage: sum(times) / len(times) for stage, times in least.items()}
    found[ATTEMPT] = sum(time for stage, time in found.items() if stage != SETTLED)
    found[START] = min(_start() for _ in range(REPEATS))
    order = (START, SETTLED, ATTEMPT, LOADED, SEARCHED, BUILT, PHYSICS, CONTROL, STATE, SENSOR, WATCHDOG, REST)
    return {stage: found[stage] for stage in order}


def _start() -> float:
    """Return the processor time of a fresh interpreter that is ready for an attempt [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", "import pilegrasp_ctrl.episode"], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@contextmanager
def _empty_cache() -> Iterator[None]:
    with tempfile.TemporaryDirectory() as folder, patch.dict(os.environ, XDG_CACHE_HOME=folder):
        yield


def _attempt(scenario: Scenario, seed: int) -> dict[str, float]:
    """Return the processor time of each stage of one attempt in this process [s]."""
    from pilegrasp_ctrl import episode
    from pilegrasp_ctrl.programs import attempt as preparation
    from pilegrasp_ctrl.sim import backend

    took: dict[str, float] = defaultdict(float)
    with ExitStack() as stack:

        def meter(owner: Any, name: str, stage: str) -> None:
            stack.enter_context(patch.object(owner, name, _metered(getattr(owner, name), took, stage)))

        meter(preparation, "settle_pile", LOADED)
        meter(preparation.StartPosture, "_solve", SEARCHED)
        begun = thread_time()
        attempt = preparation.prepare(scenario, seed)
        took[BUILT] = thread_time() - begun - took[LOADED] - took[SEARCHED]
        meter(backend.mujoco, "mj_step", PHYSICS)
        for name in ("sample", "read"):
            meter(preparation.WristSensor, name, SENSOR)
        meter(episode.Watchdog, "check", WATCHDOG)
        meter(preparation.ArmModel, "update", STATE)
        attempt = replace(attempt, control=_metered(attempt.control, took, CONTROL))
        begun = thread_time()
        episode._Loop(attempt, False, None).run()
        loop = thread_time() - begun
    took[REST] = loop - sum(took[stage] for stage in (PHYSICS, SENSOR, WATCHDOG, STATE, CONTROL))
    return took


def _metered(function: Callable[..., Any], took: dict[str, float], stage: str) -> Callable[..., Any]:
    def metered(*arguments: Any, **options: Any) -> Any:
        begun = thread_time()
        try:
            return function(*arguments, **options)
        finally:
            took[stage] += thread_time() - begun

    return metered


def main() -> None:
    """Print the table."""
    name, *overrides = sys.argv[1:] or ["spheres_wall"]
    found = stages(load_scenario(name, parse_overrides(overrides)))
    shares = {stage: f"{found[stage] / found[ATTEMPT]:.1%}" for stage in found if stage not in (START, SETTLED)}
    rows = [(stage, f"{seconds:.3f}", shares.get(stage, "")) for stage, seconds in found.items()]
    print(markdown_table((f"`{' '.join([name, *overrides])}`", "processor time [s]", "share"), rows))


if __name__ == "__main__":
    main()
