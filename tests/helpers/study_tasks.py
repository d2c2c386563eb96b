"""Functions for the workers in tests of studies, which a process can import by name."""

import json
import os
import signal
import sys
import threading
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
    if kind == "lacks memory" or (kind == "lacks memory once" and not before):
        raise MemoryError
    if kind == "stays":  # a thread that keeps the process
        threading.Thread(target=time.sleep, args=(300.0,), daemon=False).start()
    if kind == "raises":
        raise SimulationError("no work item would fare better")
    return number, os.getpid()


def short_attempt(item):
    """Report an attempt that never ran; from the seed HALT on, wait for the end."""
    time.sleep(60.0 if item.seed >= int(os.environ.get("HALT", "1000")) else 0.005)
    result = {"success": item.seed % 3 > 0, "grasped": item.seed % 4, "outcomes": []}
    return AttemptReport(item.config_hash, item.seed, json.dumps(result), None, result["success"])


def short_attempt_report(condition, seed):
    """Return the report of an attempt that never ran; seed 7 raised."""
    result = {
        "success": seed % 3 > 0,
        "grasped": seed % 4,
        "reason": f"push: travel limit of 0.{seed} m",
        "outcomes": [{"name": "push", "status": "ended", "trigger": "grasp force", "peak_force": 17.25 + seed}],
        "sim_time": 9.5 + 0.25 * seed,
    }
    text, error = (None, "the pile did not come to rest") if seed == 7 else (json.dumps(result), None)
    return AttemptReport(
        condition.config_hash, seed, text, error, bool(text) and result["success"], None, 1.5 + seed, 2.5, "host"
    )


def attempts(seeds):
    """Return two conditions times the seeds, as pairs."""
    return [(found, seed) for found in conditions("spheres_wall", {"pile.count": [3, 5]}) for seed in range(seeds)]


def final_position(recording):
    """Return the final position of the tool, as a measure."""
    return {"tool": recording.signals["tool_position"][-1].tolist(), "frames": len(recording.frame_time)}


def refused_while(recording):
    """Measure nothing while the file FAULT names what the environment refuses."""
    fault = Path(os.environ["FAULT"])
    if fault.exists():
        kind = fault.read_text()
        if kind == "disk":
            raise OSError(28, "No space left on device", "/tmp/a.npz")
        if kind == "package":
            raise ImportError("libgomp.so.1: cannot open shared object file")
        try:
            raise PermissionError(13, "Permission denied", "/data")
        except OSError:
            raise SimulationError("the file of the measure cannot be read") from None
    return {"frames": len(recording.frame_time)}


if __name__ == "__main__":
    run.run_work_item = short_attempt
    run.check_conditions = lambda conditions: None
    run.run_study(attempts(60), sys.argv[1], jobs=2).close()
