"""Success rate of a scenario over a range of seeds.

Usage: python success_rate.py [NAME FIRST LAST [KEY=VALUE]...], for example spheres_wall 10000 10050 hand=shovel
"""

from concurrent.futures import ProcessPoolExecutor
from functools import partial

from scipy.stats import binomtest

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.config import parse_overrides
from pilegrasp_ctrl.scenarios._script import run_script, seed_range


def attempt(scenario: pg.Scenario, seed: int) -> tuple[bool, bool, int]:
    """Run one seed; return success, whether F_grasp was reached, and the number of objects held."""
    result = pg.run(scenario, seed=seed)
    triggered = any(outcome.trigger == "grasp force" for outcome in result.outcomes)
    return result.success, triggered, result.grasped


def main(name: str = "spheres_wall", first: int = 0, last: int = 4, *overrides: str) -> None:
    """Run the seeds on two processes and print the rate with its 95 % Wilson interval."""
    scenario = pg.load_scenario(name, parse_overrides(overrides))
    with ProcessPoolExecutor(2) as pool:
        results = list(pool.map(partial(attempt, scenario), seed_range(first, last)))
    successes = sum(success for success, _, _ in results)
    interval = binomtest(successes, len(results)).proportion_ci(method="wilson")
    several = sum(held > 1 for _, _, held in results)
    print(f"{name}: {successes} of {len(results)} (95 % interval {interval.low:.0%} to {interval.high:.0%}); ", end="")
    print(f"triggered {sum(triggered for _, triggered, _ in results)}, more than one object {several}")


if __name__ == "__main__":
    run_script(main)
