"""Write tests/data/tsid_torques.json: TSID's torques at states of both arms.

TSID is no dependency of the project and has to be built (see docs/benchmark.md), so its torques are kept.

Usage: OMP_NUM_THREADS=1 python tests/helpers/record_tsid.py
"""

import json
import platform
from importlib.metadata import version

import numpy as np

from pilegrasp_ctrl.validation.bench.tsid import TsidController
from tsid_problem import (
    FILE,
    FRAMES,
    GAINS,
    HORIZON,
    LIMITS,
    RATE,
    REGULAR,
    SPEED,
    draw,
    load_arm,
    our_controller,
    posture_task,
)

DEMANDS = {"gentle": 0.3, "saturating": 10.0}
CASES = 15
"""Number of cases for each arm and each demand."""

SEED = 20


def cases(name: str) -> list[dict[str, object]]:
    """Return a row for each state: state, reference and TSID's torques."""
    arm, rng, rows = load_arm(name), np.random.default_rng(SEED), []
    controller, ours = TsidController(arm, FRAMES[name], posture_task(name), GAINS, RATE), our_controller(name)
    for demand, size in DEMANDS.items():
        for _ in range(CASES):
            observation, reference = draw(arm, rng, size)
            torque = controller.step(observation, reference)
            worst = np.abs(torque - ours.step(observation, reference).command.torque).max()
            print(f"{name} {demand}: differs from the project's by {worst:.1e} N·m")
            values = {
                "q": observation.q,
                "v": observation.v,
                "translation": reference.pose.translation,
                "rotation": reference.pose.rotation.ravel(),
                "twist": reference.twist,
                "acceleration": reference.acceleration,
                "torque": torque,
            }
            rows.append({"demand": demand} | {key: value.tolist() for key, value in values.items()})
    return rows


def main() -> None:
    """Write the file, one case a line."""
    packages = {name: version(name) for name in ("tsid", "libtsid", "eiquadprog", "pin", "numpy")}
    head = {
        "written_by": "tests/helpers/record_tsid.py",
        "versions": packages | {"python": platform.python_version()},
        "problem": "InverseDynamicsFormulationAccForce, SolverHQuadProgFast: SE3 task (GAINS as kp and kd), joint "
        "posture task, actuation bounds, joint speed bounds; tests/helpers/tsid_problem.py states it",
        "limits": LIMITS,
        "share_of_joint_speed": SPEED,
        "time_step_of_speed_bounds": HORIZON,
        "smallest_singular_value": REGULAR,
        "units": "rad, rad/s, m, m/s, m/s², N·m; rotation by rows; world axes, linear part first",
    }
    arms = ",\n".join(f' "{name}": [\n  {_lines(cases(name))}\n ]' for name in FRAMES)
    text = json.dumps(head, indent=1, ensure_ascii=False)[:-2] + f',\n "cases": {{\n{arms}\n }}\n}}\n'
    json.loads(text)
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_text(text, encoding="utf-8")


def _lines(rows: list[dict[str, object]]) -> str:
    return ",\n  ".join(json.dumps(row) for row in rows)


if __name__ == "__main__":
    main()
