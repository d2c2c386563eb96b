"""A search over gains whose trials simulate nothing."""

from dataclasses import replace

import numpy as np

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.tasks.gains import MotionGains, load_gains
from pilegrasp_ctrl.tuning.gain_space import GainSpace
from pilegrasp_ctrl.tuning.objectives import Measured
from pilegrasp_ctrl.tuning.search import Search
from pilegrasp_ctrl.tuning.trial import TrialReport, TrialWork

BAD = MotionGains(stiffness=25.0, damping_ratio=0.3)
OPTIMUM = {"translation": 2000.0, "rotation": 400.0, "damping_ratio": 1.0}


def search(folder, **changes) -> Search:
    (folder / "gains").mkdir(parents=True, exist_ok=True)
    scenario = load_scenario("free_space_line", {"controller.kind": "operational_space"})
    return replace(Search(scenario, GainSpace.around(BAD, 500.0), (0,), 0, folder), **changes)


def made_up(task: TrialWork) -> TrialReport:
    """A trial without a simulation: the farther from the optimum, the worse; damping below 0.4 rings."""
    gains = load_gains(task.scenario.controller.gains)
    found = {"translation": gains.stiffness[0], "rotation": gains.stiffness[3], "damping_ratio": gains.damping_ratio}
    away = sum(np.log(found[name] / best) ** 2 for name, best in OPTIMUM.items())
    ringing = 0.4 / gains.damping_ratio
    measured = Measured(0.1 + away, 0.1 + 1e-5 * found["rotation"], None, away, away, 8.0)
    return TrialReport(task.number, measured, (ringing, ringing), 1.0, "", 0.01)


def table(store) -> list[tuple]:
    return [(record.number, *record.values.values(), record.report.measured) for record in store.records()]
