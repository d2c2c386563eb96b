"""How long a fresh interpreter takes until the library can be used."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from time import perf_counter

import numpy as np

from .clock import Timing

STATEMENTS = {
    "python": "pass",
    "import numpy": "import numpy",
    "import pinocchio": "import pinocchio",
    "import mujoco": "import mujoco",
    "import pilegrasp_ctrl": "import pilegrasp_ctrl",
    "pilegrasp list": "from pilegrasp_ctrl.cli import main; main(['list'])",
    "first controller": "import pilegrasp_ctrl as pg; pg.OperationalSpaceController(pg.ArmModel.load('wam7'))",
    "import mink": "import mink",
}
"""What each interpreter does; the first is what all the others include."""


def time_imports(rounds: int, round_done: Callable[[], None] = lambda: None) -> dict[str, Timing]:
    """Start every interpreter `rounds` times, in turns, after one round that fills the file system's cache.

    Args:
        rounds: at least 1.
        round_done: called after each round, the first included.
    """
    durations: dict[str, list[float]] = {key: [] for key in STATEMENTS}
    for _ in range(1 + rounds):
        for key, statement in STATEMENTS.items():
            start = perf_counter()
            subprocess.run([sys.executable, "-c", statement], check=True, stdout=subprocess.DEVNULL)
            durations[key].append(perf_counter() - start)
        round_done()
    return {key: Timing.of([np.array([value]) for value in values[1:]]) for key, values in durations.items()}
