"""What workers do in the tests of studies: functions that a process can import by name."""

import json
import os
import signal
import sys
import time
from concurrent.futures import Future
from pathlib import Path

from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.study import run
from pilegrasp_ctrl.study.attempt import AttemptReport
from pilegrasp_ctrl.study.condition import conditions


class PoolHere:
    """Carries tasks out in this process, as soon as they are submitted."""

    retries = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def width(self):
        return 1

    def submit(self, function, task):
        future = Future()
        try:
            future.set_result(function(task))
        except SimulationError as error:
            future.set_exception(error)
        return future

    def died(self, error):
        return False


def noted(task):
    """Note that the task began, in a file of its own, and return how often it did so before."""
    folder, number, _ = task
    with (Path(folder) / str(number)).open("a+b") as file:
        file.write(b"x")
        return file.tell() - 1


def work(task):
    """Do what the task's last part says; return its number and the process."""
    before, (_, number, kind) = noted(task), task
    time.sleep(0.02)
    if kind == "dies" or (kind == "dies once" and not before):
        os.kill(os.getpid(), signal.SIGKILL)
    if kind == "lacks memory once" and not before:
        raise MemoryError
    if kind == "raises":
        raise SimulationError("no task would fare better")
    return number, os.getpid()


def short_attempt(order):
    """Answer as an attempt does, without one; from the seed HALT on, wait for the end."""
    time.sleep(60.0 if order.seed >= int(os.environ.get("HALT", "1000")) else 0.005)
    result = {"success": order.seed % 3 > 0, "grasped": order.seed % 4, "outcomes": []}
    return AttemptReport(order.config_hash, order.seed, json.dumps(result), None, result["success"])


def tasks(seeds):
    """Return two conditions times the seeds."""
    return [(found, seed) for found in conditions("spheres_wall", {"pile.count": [3, 5]}) for seed in range(seeds)]


def final_position(recording):
    """Return where the tool ends, as a measure."""
    return {"tool": recording.signals["tool_position"][-1].tolist(), "frames": len(recording.frame_time)}


if __name__ == "__main__":
    run.run_work_item = short_attempt
    run.check_conditions = lambda conditions: None
    run.run_study(tasks(60), sys.argv[1], jobs=2).close()
