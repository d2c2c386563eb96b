"""Print the processor time of each part of an attempt, from the start of the process to the verdict.

Usage: python docs/studies/attempt_profile.py [NAME [KEY=VALUE]...]
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from collections import defaultdict
from time import thread_time

from pilegrasp_ctrl.config import Scenario, load_scenario, parse_overrides
from pilegrasp_ctrl.episode import LOOP_PARTS, run_attempt
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.statistics import markdown_table
from script import run_script

SEEDS = (0, 1)
"""Seeds of the attempts; chosen."""

REPEATS = 2
"""Repeats of each seed; chosen. The shortest time counts, because other programs on the machine only add to it."""

START, SETTLED = "process start and imports, once a worker", "preparation with an empty cache, once a seed"
PREPARED, ATTEMPT = "preparation: pile from the cache, start posture, scene", "attempt, pile in the cache"
"""Names of the other rows of the table."""

WORDS = {
    "observe": "wrist sensor and encoders",
    "state": "arm's terms (Pinocchio)",
    "primitive": "primitives",
    "control": "controller",
    "record": "recording and frames",
    "step": "physics, the sensor's samples, watchdog",
    "check": "saturation, rims",
}
"""Name of each part of the loop in the table."""


class Clock:
    """Processor time of each part of the loop [s]."""

    def __init__(self) -> None:
        """Start."""
        self.took: dict[str, float] = defaultdict(float)
        self._last = thread_time()

    def __call__(self, part: str) -> None:
        """Add the time since the last part to this one."""
        now = thread_time()
        self.took[part] += now - self._last
        self._last = now


def profile(scenario: Scenario) -> dict[str, float]:
    """Return the processor time of each part of an attempt [s], the mean over a few seeds; `ATTEMPT` is the sum."""
    least: dict[str, list[float]] = defaultdict(list)
    for seed in SEEDS:
        with tempfile.TemporaryDirectory() as folder:
            os.environ["XDG_CACHE_HOME"] = folder
            first, *rounds = (_attempt(scenario, seed) for _ in range(REPEATS + 1))
        for part in rounds[0]:
            least[part].append(min(took[part] for took in rounds))
        least[SETTLED].append(first[PREPARED])
    found = {part: sum(times) / len(times) for part, times in least.items()}
    found[ATTEMPT] = sum(time for part, time in found.items() if part != SETTLED)
    found[START] = min(_start() for _ in range(REPEATS))
    return {part: found[part] for part in (START, SETTLED, ATTEMPT, PREPARED, *WORDS.values())}


def _attempt(scenario: Scenario, seed: int) -> dict[str, float]:
    """Return the processor time of the preparation and of each part of the loop [s]."""
    begun = thread_time()
    attempt = prepare(scenario, seed)
    prepared, clock = thread_time() - begun, Clock()
    run_attempt(attempt, on_part=clock)
    return {PREPARED: prepared} | {WORDS[part]: clock.took[part] for part in LOOP_PARTS}


def _start() -> float:
    """Return the processor time of a fresh interpreter that is ready for an attempt [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", "import pilegrasp_ctrl.episode"], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main(name: str = "spheres_wall", *overrides: str) -> None:
    """Profile attempts of scenario NAME with OVERRIDES (KEY=VALUE), and print the table."""
    found = profile(load_scenario(name, parse_overrides(overrides)))
    shares = {part: f"{found[part] / found[ATTEMPT]:.1%}" for part in found if part not in (START, SETTLED)}
    rows = [(part, f"{seconds:.3f}", shares.get(part, "")) for part, seconds in found.items()]
    print(markdown_table((f"`{' '.join([name, *overrides])}`", "processor time [s]", "share"), rows))


if __name__ == "__main__":
    run_script(main)
