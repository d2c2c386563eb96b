"""Digests of a few attempts, which are the same on every x86-64 processor with AVX2 and FMA, and from Python 3.11 on.

Usage:

    python tests/helpers/attempt_bits.py [SCENARIO]...    # print the digests as JSON
    python tests/helpers/attempt_bits.py --write          # write all to tests/data/attempt_bits.json, with the versions
"""

import hashlib
import json
import platform
import sys
from pathlib import Path

import numpy as np

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.provenance import versions

KEPT = Path(__file__).parents[1] / "data" / "attempt_bits.json"
"""File of the digests that are kept."""

ATTEMPTS = {
    "spheres_wall": (3, {}),
    "cylinders_wall": (3, {"hand": "shovel"}),
    "cubes_wall": (3, {"controller.kind": "impedance"}),
    "bin_picking": (3, {"order.count": 1, "order.operator": "sees"}),
}
"""Seed and keys by scenario: motion and impedance control, both hands, an order, and the three shapes of the paper."""

VARYING = {"wall_time", "realtime_factor", "median_us", "p99_us"}
"""Keys of a result whose values come from a clock."""


def stable(value):
    """Return a result without the values that come from a clock."""
    if isinstance(value, dict):
        return {key: stable(entry) for key, entry in value.items() if key not in VARYING}
    return [stable(entry) for entry in value] if isinstance(value, list) else value


def digests(scenarios=ATTEMPTS):
    """Run attempts; return the objects held, and digests of result and recording, by scenario."""
    found = {}
    for scenario in scenarios:
        seed, overrides = ATTEMPTS[scenario]
        result = pg.run(scenario, seed=seed, overrides=overrides, record=True)
        signals = [np.ascontiguousarray(result.recording.signals[name]) for name in sorted(result.recording.signals)]
        found[scenario] = {
            "grasped": result.grasped,
            "result": digest(json.dumps(stable(result.as_dict()), sort_keys=True).encode()),
            "recording": digest(result.recording.body_position.tobytes(), *(signal.tobytes() for signal in signals)),
        }
    return found


def digest(*parts):
    """Return the first 16 digits of the parts' SHA-256."""
    return hashlib.sha256(b"".join(parts)).hexdigest()[:16]


def deciding_versions():
    """Return the versions on which the digests depend."""
    found = versions("numba", "eigenpy", "osqp", "qpsolvers")
    return {name: version for name, version in found.items() if name != "pilegrasp"}


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        made = {"python": platform.python_version(), "versions": deciding_versions(), "digests": digests()}
        KEPT.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")
    else:
        print(json.dumps(digests(sys.argv[1:] or ATTEMPTS), indent=1))
