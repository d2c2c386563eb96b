"""Run one attempt on 18 light spheres beside a wall, print the outcome, and write the recording and its page.

Usage: python scenarios/grasp_wall.py [FOLDER]
"""

import sys
from pathlib import Path

import pilegrasp_ctrl as pg


def main(folder: Path) -> None:
    """Run the attempt and write grasp_wall.npz and grasp_wall.html into the folder."""
    result = pg.run("spheres_wall", seed=0, record=True)
    for outcome in result.outcomes:
        print(f"{outcome.name:10} {outcome.status}: {outcome.trigger}")
    print(f"{result.grasped} objects held" if result.success else f"no success: {result.reason}")
    if result.recording is not None:
        result.recording.save(folder / "grasp_wall.npz")
        pg.write_html(result.recording, folder / "grasp_wall.html")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
