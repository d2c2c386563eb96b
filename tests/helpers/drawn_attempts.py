"""Do pages explain? Attempts drawn by a seed, their pages as pictures, and the truth, which is printed on request only.

    python tests/helpers/drawn_attempts.py FOLDER --draw 27 --attempts 10
    python tests/helpers/drawn_attempts.py FOLDER --truth

The first command writes `1.html`, `1.png` (the page as it opens), `1-0.png` to `1-3.png` (at moments that a reader
reaches by the key for the next event) and so on. Write down from the pictures what happened, when and why; then the
second command prints what the simulation says.
"""

from __future__ import annotations

import argparse
import base64
import json
import random
from pathlib import Path
from typing import Any

from pilegrasp_ctrl import run
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer import write_html
from pilegrasp_ctrl.viewer.pictures import chromium

SCENARIOS = (
    "spheres_wall",
    "spheres_corner",
    "spheres_alone",
    "cylinders_wall",
    "cubes_wall",
    "bin_picking",
    "push_wall",
    "free_space_line",
)
"""Scenarios that are drawn from."""

CHANGES: dict[str, tuple[Any, ...]] = {
    "hand": ("rbo_hand2", "rbo_hand2", "shovel"),
    "strategy.grasp_force": (2.0, 6.0, 10.0),
    "pile.object": ("light_sphere", "heavy_sphere", "apple", "lime"),
}
"""Values that are drawn for a key."""

LAST_SEED = 9999
"""Largest seed of an attempt; larger ones belong to validation."""

PICTURES = 4
"""Number of pictures at events of an attempt."""


def draw(chance: random.Random) -> tuple[str, int, dict[str, Any]]:
    """Return scenario, seed and overrides of an attempt."""
    name = chance.choice(SCENARIOS)
    changes = {key: chance.choice(values) for key, values in CHANGES.items() if chance.random() < 0.4}
    if name in ("push_wall", "free_space_line"):
        changes.pop("pile.object", None)
    if name in ("cylinders_wall", "cubes_wall"):
        changes.pop("pile.object", None)
    if name == "bin_picking":
        changes["order.max_attempts"] = 4
    return name, chance.randrange(LAST_SEED + 1), changes


def truth(name: str, result: Any) -> dict[str, Any]:
    """Return what the simulation says about an attempt, without what the page computes."""
    facts = result.as_dict()
    recording = result.recording
    lifted = [
        body.name
        for k, body in enumerate(recording.bodies)
        if body.role == "object" and recording.body_position[-1, k, 2] - recording.body_position[0, k, 2] > 0.08
    ]
    keys = ("seed", "success", "grasped", "reason", "attempts", "carried")
    outcomes = [
        {key: row[key] for key in ("name", "status", "trigger", "start", "end", "peak_force")}
        for row in facts["outcomes"]
    ]
    return {"scenario": name, **{key: facts.get(key) for key in keys}} | {
        "outcomes": outcomes,
        "objects that ended more than 8 cm above their start": lifted,
    }


def made(chance: random.Random) -> tuple[str, Any]:
    """Return the scenario and the result of the first drawn attempt that can be made."""
    while True:
        name, own, changes = draw(chance)
        try:
            return name, run(name, seed=own, overrides=changes, record=True)
        except PilegraspError as error:
            print("drawn again, because the attempt cannot be made:", error)


def prepare(folder: Path, seed: int, count: int) -> None:
    """Run the attempts, and take the pictures of their pages, as far as they are not in FOLDER yet."""
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(1, count + 1):
        if (folder / f"{number}.npz").exists():
            continue
        name, result = made(random.Random(f"{seed}-{number}"))
        (folder / f"{number}.truth.json").write_text(json.dumps(truth(name, result), indent=1))
        result.recording.save(folder / f"{number}.npz")
    with chromium.Chromium(chromium.require_chromium()) as browser:
        for index in range(1, count + 1):
            if not (folder / f"{index}.png").exists():
                photograph(browser, folder / f"{index}.npz")


def photograph(browser: chromium.Chromium, file: Path) -> None:
    """Write the page of a recording, and its pictures at events, spread over them."""
    page = file.with_suffix(".html")
    write_html(Recording.load(file), page)
    browser.open(page, 1400, 900)
    browser.evaluate("pilegrasp.ready.then(() => pilegrasp.pause())")
    times = browser.evaluate("pilegrasp.panels[0].data.events.map(({ time }) => time)")
    times = sorted(set(times))
    chosen = [times[round(k * (len(times) - 1) / (PICTURES - 1))] for k in range(PICTURES)] if times else []
    for suffix, moment in [("", None), *((f"-{k}", time) for k, time in enumerate(chosen))]:
        browser.evaluate(f"pilegrasp.pause(); pilegrasp.seek({json.dumps(moment) if moment is not None else 1e9})")
        browser.wait_for_picture()
        picture = browser.call("Page.captureScreenshot", format="png")["data"]
        (file.parent / f"{file.stem}{suffix}.png").write_bytes(base64.b64decode(picture))


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--draw", type=int, default=27, help="seed of what is drawn")
    parser.add_argument("--attempts", type=int, default=10)
    parser.add_argument("--truth", action="store_true", help="print the truth of the attempts in FOLDER")
    options = parser.parse_args()
    if not options.truth:
        return prepare(options.folder, options.draw, options.attempts)
    for file in sorted(options.folder.glob("*.truth.json"), key=lambda path: int(path.name.split(".")[0])):
        print(file.name, file.read_text())
    return None


if __name__ == "__main__":
    main()
