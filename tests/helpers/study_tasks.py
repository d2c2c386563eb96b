"""Functions for the workers in tests of studies, which a process can import by name."""

import json
import os
import signal
import sys
import time
from pathlib import Path

from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.study import run
from pilegrasp_ctrl.study.attempt import AttemptReport
from pilegrasp_ctrl.study.condition import conditions


def begun_before(item):
    """Note in a file that the work item began, and return how often it began before."""
    folder, number, _ = item
    with (Path(folder) / str(number)).open("a+b") as file:
        file.write(b"x")
        return file.tell() - 1


def work(item):
    """Act as the last part of the work item says; return its number and the process."""
    before, (_, number, kind) = begun_before(item), item
    time.sleep(0.02)
    if kind == "dies" or (kind == "dies once" and not before):
        os.kill(os.getpid(), signal.SIGKILL)
    if kind == "lacks memory once" and not before:
        raise MemoryError
    if kind == "raises":
        raise SimulationError("no work item would fare better")
    return number, os.getpid()


def short_attempt(item):
    """Report an attempt that never ran; from the seed HALT on, wait for the end."""
    time.sleep(60.0 if item.seed >= int(os.environ.get("HALT", "1000")) else 0.005)
    result = {"success": item.seed % 3 > 0, "grasped": item.seed % 4, "outcomes": []}
    return AttemptReport(item.config_hash, item.seed, json.dumps(result), None, result["success"])


def attempts(seeds):
    """Return two conditions times the seeds, as pairs."""
    return [(found, seed) for found in conditions("spheres_wall", {"pile.count": [3, 5]}) for seed in range(seeds)]


def final_position(recording):
    """Return the final position of the tool, as a measure."""
    return {"tool": recording.signals["tool_position"][-1].tolist(), "frames": len(recording.frame_time)}


if __name__ == "__main__":
    run.run_work_item = short_attempt
    run.check_conditions = lambda conditions: None
    run.run_study(attempts(60), sys.argv[1], jobs=2).close()
