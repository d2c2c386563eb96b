"""The same piles in MuJoCo and in PyBullet: settled height and spread, push force, cost of a step.

Needs `pip install 'pilegrasp[pybullet]'`. Usage: python compare_pybullet.py [SEEDS]
"""

from pilegrasp_ctrl.statistics import markdown_row, markdown_table
from script import run_script

COUNTS = (18, 30, 60, 90)


def main(seeds: int = 5) -> None:
    """Print both tables."""
    from pile_comparison import in_bullet, in_mujoco, row, step_costs

    print(markdown_table(("18 balls", "mean height [mm]", "top", "spread [mm]", "17 N after", "mean force [N]")))
    print(row("MuJoCo, rule `paper`", [in_mujoco(18, seed, "paper") for seed in range(seeds)]))
    print(row("MuJoCo, rule `product`", [in_mujoco(18, seed, "product") for seed in range(seeds)]))
    print(row("PyBullet", [in_bullet(18, seed) for seed in range(seeds)]))
    print()
    print(markdown_table(("balls", "MuJoCo [us]", "PyBullet [us]", "PyBullet / MuJoCo")))
    for count in COUNTS:
        own, other = step_costs(count)
        print(markdown_row((count, f"{1e6 * own:.0f}", f"{1e6 * other:.0f}", f"{other / own:.1f}")))


if __name__ == "__main__":
    run_script(main)
