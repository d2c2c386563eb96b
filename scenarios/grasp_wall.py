"""One attempt at 18 light spheres beside a wall: prints the verdict, writes the recording and the page.

Usage: python grasp_wall.py [FOLDER]
"""

from pathlib import Path

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.scenarios._script import run_script
from pilegrasp_ctrl.viewer import write_html


def main(folder: Path = Path(".")) -> None:
    """Run the attempt and write grasp_wall.npz and grasp_wall.html into FOLDER, or here."""
    result = pg.run("spheres_wall", seed=0, record=True)
    facts = result.as_dict()
    for outcome in facts["outcomes"]:
        print(f"{outcome['name']:10} {outcome['status']}: {outcome['trigger']}")
    print("success" if facts["success"] else f"no success: {facts['reason']}", f"({facts['grasped']} objects held)")
    if result.recording is not None:
        result.recording.save(folder / "grasp_wall.npz")
        write_html(result.recording, folder / "grasp_wall.html")


if __name__ == "__main__":
    run_script(main)
