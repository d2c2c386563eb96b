"""Functions that a question may call instead of a command, as "@name"; each prints its result."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pilegrasp_ctrl import ArmModel


def arm(folder: str) -> None:
    """Load the arm in a folder and look at it in its middle."""
    from pilegrasp_ctrl import ArmModel

    _print_arm(ArmModel.load(folder))


def urdf(file: str) -> None:
    """Load an arm from a URDF."""
    from pilegrasp_ctrl import ArmModel

    _print_arm(ArmModel.from_urdf(file, tool_frame="flange"))


def mjcf(file: str) -> None:
    """Load an arm from an MJCF."""
    from pilegrasp_ctrl import ArmModel

    _print_arm(ArmModel.from_mjcf(file, tool_frame="flange"))


def hand(folder: str) -> None:
    """Load the hand in a folder, and what an attempt asks of it."""
    from pilegrasp_ctrl.sim.hand import Hand

    found = Hand.load(Path(folder))
    print(found.use.half_width, found.mass_properties().mass, found.contact_geoms, found.drive.opened.tolist())


def pile(seed: str) -> None:
    """Settle a pile of two balls, from the cache if it has it, and print where they lie."""
    from pilegrasp_ctrl.config import load_scenario
    from pilegrasp_ctrl.programs.attempt import prepare

    attempt = prepare(load_scenario("spheres_wall", {"pile.count": 2}), int(seed))
    print(attempt.pile.poses.tolist())


def recording(file: str) -> None:
    """Load a recording and measure it."""
    from pilegrasp_ctrl.analysis.motion import annotate
    from pilegrasp_ctrl.recording import Recording

    print(repr(annotate(Recording.load(file))))


def scenario(file: str) -> None:
    """Read a scenario and hash it."""
    from pilegrasp_ctrl.config import load_scenario

    print(load_scenario(Path(file)).config_hash())


def attempt(file: str, seed: str) -> None:
    """Run a whole attempt; if it succeeds, what it holds must be at the hand."""
    import json

    from pilegrasp_ctrl import run
    from pilegrasp_ctrl.config import load_scenario

    chosen = load_scenario(Path(file))
    result = run(chosen, seed=int(seed), record=True)
    json.dumps(result.as_dict(), allow_nan=False)
    if result.success and chosen.program == "grasp":
        near = _objects_at_the_hand(result.recording)
        if result.grasped < 1 or near < result.grasped:
            raise AssertionError(f"{result.grasped} objects are said to be held, and {near} are at the hand")
    print(f"success {result.success}, {result.grasped} held, {result.reason}")


REACH = 0.25
"""Farthest distance of the centre of a held object from the nearest part of the hand [m] (chosen)."""


def _objects_at_the_hand(recording: Any) -> int:
    """Return how many objects are near the hand, and above the table, in the last frame."""
    import numpy as np

    position = recording.body_position[-1]
    roles = np.array([body.role for body in recording.bodies])
    hand, objects = position[roles == "hand"], position[roles == "object"]
    distance = np.linalg.norm(objects[:, None] - hand[None], axis=-1).min(axis=1)
    return int(((distance < REACH) & (objects[:, 2] > 0.02)).sum())


real_pool: Any = None
"""The function that makes the workers of a study; the answering process puts another one in its place."""


def cluster(address: str) -> int:
    """Run a sweep on the workers of a scheduler, as the command line does; return the exit status."""
    from pilegrasp_ctrl.cli import main
    from pilegrasp_ctrl.study import run

    run.open_pool = real_pool
    return main(["sweep", "free_space_line", "--seeds", "0:1", "--out", "study", "--scheduler", address])


def _print_arm(model: ArmModel) -> None:
    """Look at an arm in the middle of its joints; what is accepted must be of use."""
    import numpy as np

    middle = 0.5 * (model.q_lower + model.q_upper)
    state = model.update(np.where(np.isfinite(middle), middle, 0.0), np.zeros(model.nv))
    if not (np.isfinite(state.M).all() and np.isfinite(state.h).all()):
        raise AssertionError("the inertia or gravity of an accepted arm is not finite")
    print(repr(model))


CALLS: dict[str, Callable[..., int | None]] = {
    function.__name__: function for function in (arm, urdf, mjcf, hand, pile, recording, scenario, attempt, cluster)
}
"""Functions by name; each returns an exit status, or None for 0."""
