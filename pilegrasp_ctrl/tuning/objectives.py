"""The objectives of a search over gains, measured in the recordings of the attempts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import Scenario
from ..exceptions import PilegraspError
from ..programs.result import EpisodeResult
from ..recording import Recording
from ..types import Array, Outcome

LEVER = 0.1
"""Lever by which a rotation error counts as a position error: about half the length of a hand [m] (chosen)."""
FREE = ("line", "approach")
"""Primitives in which tracking is measured. In contact the error is the spring that presses, not a fault."""
AFTER_TRIGGER = 0.1
"""How long the force is watched after it has ended the push [s] (chosen)."""
MIN_SCORED = 1e-9
"""Smallest value whose logarithm is taken, so that 0 has a finite score (chosen)."""


MEASURE_NAMES = {
    "tracking": "tracking error",
    "activity": "torque activity",
    "overshoot": "force beyond F_grasp",
    "position": "position error",
    "rotation": "rotation error",
    "share": "torque",
}
"""Name of each attribute of `Measured` on the page."""
UNITS = {"tracking": "mm", "activity": "%", "overshoot": "N", "position": "mm", "rotation": "mrad", "share": "%"}
"""Unit of each attribute of `Measured`; percentages are of the torque limit."""


class UnfinishedError(PilegraspError):
    """An attempt was not completed, so nothing can be measured."""


@dataclass(frozen=True, slots=True)
class Measured:
    """The measurements of one attempt, or of several attempts together.

    Attributes:
        tracking: Rms of tool position and rotation together, `sqrt(|e_p|² + (LEVER |e_R|)²)` [mm].
        activity: Rms over samples and joints of the change of |torque| within 10 ms [% of the torque limit].
        overshoot: Largest force along the push beyond F_grasp, the sensor's lag removed [N]; None without a push.
        position: Rms position error [mm].
        rotation: Rms rotation error [mrad].
        share: Rms over samples and joints of |torque| [% of the torque limit].
    """

    tracking: float
    activity: float
    overshoot: float | None
    position: float
    rotation: float
    share: float

    def objectives(self) -> tuple[float, ...]:
        """Return the objectives, in the order of `objective_names`."""
        both = (self.tracking, self.activity)
        return both if self.overshoot is None else (*both, self.overshoot)

    def scores(self, grasp_force: float) -> tuple[float, ...]:
        """Return the logarithms of tracking, activity and, with a push, its largest force.

        With logarithms, 10 % less of one objective counts for the sampler as much as 10 % less of another. With
        millimetres and percent it would favour the objective with the larger spread of numbers.

        Args:
            grasp_force: Force threshold F_grasp, from which the overshoot counts [N].
        """
        values = [self.tracking, self.activity]
        values += [] if self.overshoot is None else [grasp_force + self.overshoot]
        return tuple(float(np.log(max(value, MIN_SCORED))) for value in values)

    def as_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return asdict(self)


def has_push(scenario: Scenario) -> bool:
    """Return whether a force ends one of the scenario's motions."""
    return scenario.traits.touches


def objective_names(scenario: Scenario) -> tuple[str, ...]:
    """Return the attributes of `Measured` that the search minimises."""
    return ("tracking", "activity", "overshoot") if has_push(scenario) else ("tracking", "activity")


def measure(result: EpisodeResult, scenario: Scenario) -> Measured:
    """Return the measurements of one recorded attempt.

    The torque counts by its changes. Holding the arm up costs the same with all gains. An arm that sags away from its
    reference needs a little less torque, which must not count as better.

    Raises:
        UnfinishedError: A primitive failed, or no free motion was recorded.
    """
    recording, last = result.recording, result.outcomes[-1]
    if last.status == "failed":
        raise UnfinishedError(f"seed {result.seed}: {last.name}: {last.trigger}")
    free = [outcome for outcome in result.outcomes if outcome.name in FREE]
    if recording is None or not free:
        raise UnfinishedError(f"seed {result.seed}: no free motion was recorded, so there is no tracking to measure")
    chosen = np.any([_during(recording, outcome) for outcome in free], axis=0)
    position, rotation, torque = (
        np.asarray(recording.signals[name], dtype=np.float64)
        for name in ("tracking_error", "orientation_error", "torque_ratio")
    )
    push = next((outcome for outcome in result.outcomes if outcome.name == "push"), None)
    return Measured(
        tracking=1e3 * _rms(np.hypot(position[chosen], LEVER * rotation[chosen])),
        activity=1e2 * _rms(np.diff(torque, axis=0)),
        overshoot=_overshoot(recording, push, scenario) if push is not None else None,
        position=1e3 * _rms(position[chosen]),
        rotation=1e3 * _rms(rotation[chosen]),
        share=1e2 * _rms(torque),
    )


def combined(parts: Sequence[Measured]) -> Measured:
    """Return the measurements of several seeds as one: root mean square of the rms values, largest overshoot."""
    overshoots = [part.overshoot for part in parts if part.overshoot is not None]
    values = {
        name: _rms(np.array([getattr(part, name) for part in parts]))
        for name in ("tracking", "activity", "position", "rotation", "share")
    }
    return Measured(overshoot=max(overshoots) if overshoots else None, **values)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _during(recording: Recording, outcome: Outcome) -> NDArray[np.bool_]:
    return (recording.signal_time >= outcome.start) & (recording.signal_time <= outcome.end)


def _overshoot(recording: Recording, push: Outcome, scenario: Scenario) -> float:
    """Return the largest force along the push beyond F_grasp [N].

    The sensor's first-order low-pass is inverted exactly for a force that is constant between samples. Within a time t
    the low-pass passes the share 1 - exp(-2 pi cutoff t) of a step. The tick that ends the push may lie between two
    samples. Its force is then the peak of the outcome, because the first force beyond F_grasp ends the push.
    """
    watched = (recording.signal_time >= push.start) & (recording.signal_time <= push.end + AFTER_TRIGGER)
    time = recording.signal_time[watched]
    force = np.asarray(recording.signals["push_force"], dtype=np.float64)[watched]
    if not np.isclose(time, push.end, rtol=0.0, atol=1e-9).any():
        place = int(np.searchsorted(time, push.end))
        time, force = np.insert(time, place, push.end), np.insert(force, place, push.peak_force)
    passed = -np.expm1(-2.0 * np.pi * scenario.sensor.cutoff * np.diff(time))
    felt = force[:-1] + np.diff(force) / passed
    return float(max(force.max(), felt.max(initial=0.0)) - scenario.strategy.grasp_force)
