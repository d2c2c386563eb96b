"""Print digests of sixteen attempts, two recordings and a page, to see whether results changed between two revisions.

Usage:

    python docs/studies/attempt_digests.py > before.json     # in one checkout
    python docs/studies/attempt_digests.py > after.json      # in another, on the same machine
    diff before.json after.json

Only public names are used, so that the script runs at every revision since 0.1.0.
"""

from __future__ import annotations

import hashlib
import json
import re
import tempfile
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from pathlib import Path

import numpy as np

import pilegrasp_ctrl as pg

ATTEMPTS: list[tuple[str, int, dict[str, object]]] = [
    ("spheres_wall", 3, {}),
    ("spheres_wall", 4, {"hand": "shovel"}),
    ("spheres_wall", 5, {"pile.object": "heavy_sphere", "strategy.alpha_deg": 30.0, "strategy.beta_deg": -10.0}),
    ("spheres_wall", 6, {"controller.solver": "osqp", "strategy.kind": "object"}),
    ("spheres_wall", 7, {"controller.compiled": True}),
    ("spheres_corner", 3, {"pile.count": 5}),
    ("spheres_alone", 3, {"pile.count": 30}),
    ("cylinders_wall", 3, {}),
    ("cylinders_wall", 4, {"hand": "shovel", "strategy.kind": "object"}),
    ("cubes_wall", 3, {"controller.kind": "impedance"}),
    ("spheres_wall", 8, {"pile.object": "lime+apple", "pile.variant": "literal", "pile.count": 10}),
    ("spheres_wall", 9, {"pile.object": "lime_net", "pile.count": 6, "support.tilt_deg": 5.0}),
    ("bin_picking", 3, {"order.count": 2, "order.operator": "sees"}),
    ("bin_picking", 4, {"order.count": 1, "pile.object": "cylinder"}),
    ("push_wall", 3, {}),
    ("free_space_line", 3, {}),
]
"""Scenario, seed and keys: every program, hand, support and object shape at least once."""

RECORDED = (0, 12)
"""Indices of the attempts whose recordings are compared too; the page of the first one is compared as well."""

VARYING = {"wall_time", "realtime_factor", "median_us", "p99_us"}
"""Keys of a result whose values come from a clock."""


def stable(value: object) -> object:
    """Return a result without the values that come from a clock."""
    if isinstance(value, dict):
        return {key: stable(entry) for key, entry in value.items() if key not in VARYING}
    return [stable(entry) for entry in value] if isinstance(value, list) else value


def digest(*parts: bytes) -> str:
    """Return the first 16 digits of the parts' SHA-256."""
    return hashlib.sha256(b"".join(parts)).hexdigest()[:16]


def recording_digest(recording: pg.Recording) -> str:
    """Return a digest of all frames, signals and contacts."""
    arrays = [recording.frame_time, recording.body_position, recording.body_quaternion, recording.signal_time]
    arrays += [recording.signals[name] for name in sorted(recording.signals)]
    arrays += [getattr(recording.contacts, name) for name in ("start", "bodies", "position", "force")]
    return digest(*(np.ascontiguousarray(array).tobytes() for array in arrays))


def page_digest(recording: pg.Recording) -> str:
    """Return a digest of the page without versions and wall-clock times, and without the funnel."""
    from pilegrasp_ctrl.viewer import write_html

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "page.html"
        write_html(recording, path)
        text = path.read_text(encoding="utf-8")
    for pattern in (r'"(wall_time|realtime_factor|median_us|p99_us)": ?[0-9.e-]+', r'"funnel": ?\[[^"]*\]'):
        text = re.sub(pattern, "", text)
    return digest(text.encode())


def main() -> None:
    """Print the digests as JSON."""
    ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter).parse_args()
    document: dict[str, object] = {}
    for number, (scenario, seed, overrides) in enumerate(ATTEMPTS):
        record = number in RECORDED
        name = " ".join([scenario, str(seed), *(f"{key}={value}" for key, value in overrides.items())])
        try:
            result = pg.run(scenario, seed=seed, overrides=overrides, record=record)
        except pg.PilegraspError as error:
            document[name] = str(error).replace(str(Path(pg.__file__).resolve().parents[1]), "")
            continue
        plain = stable(result.as_dict())
        document[name] = [result.grasped, digest(json.dumps(plain, sort_keys=True).encode())]
        if result.recording:
            document[f"{name}, recording"] = recording_digest(result.recording)
            if number == 0:
                document[f"{name}, page"] = page_digest(result.recording)
    print(json.dumps(document, indent=1))


if __name__ == "__main__":
    main()
