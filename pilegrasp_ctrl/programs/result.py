"""The result of an attempt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..recording import Recording
from ..types import Array, Outcome
from .pick_order import PickAttempt


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class EpisodeResult:
    """Result of an attempt.

    Attributes:
        scenario: Name of the scenario.
        seed: Seed of pile and sensor noise.
        config_hash: Hash of everything in the scenario that physics and control depend on.
        success: Whether an object was held (grasp), the motion completed (push, line), or the order complete (order).
        grasped: Number of objects held after lift and hold.
        reason: Reason of a failure; "" after a success.
        outcomes: Outcome of each primitive that began.
        sim_time: Simulated time [s].
        wall_time: Wall-clock time of the loop without that of the frames' observer [s].
        tick_times: (n,) duration of each control tick, from the state to the torque [s].
        limited_ticks: Number of ticks with an active limit.
        fallback_ticks: Number of ticks in which the solver failed and the arm was only held.
        packing_density: Packing density of the pile in its frame [-]; 0 without objects.
        attempts: Attempts of an order; empty for other programs.
        carried: Counts of the objects that came into the hand, as `analysis.carried.count_carried` returns them; empty
            if the backend is not the attempt's simulation.
        notes: Sentences on what the result rests on, such as parts that are too heavy for the hand.
        recording: Recording; None if none was requested.
    """

    scenario: str
    seed: int
    config_hash: str
    success: bool
    grasped: int
    reason: str
    outcomes: tuple[Outcome, ...]
    sim_time: float
    wall_time: float
    tick_times: Array
    limited_ticks: int
    fallback_ticks: int
    packing_density: float
    attempts: tuple[PickAttempt, ...] = ()
    carried: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    recording: Recording | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        """Return scenario, seed, verdict and simulated time in one line."""
        verdict = f"{self.grasped} held" if self.grasped else "success" if self.success else self.reason
        return f"EpisodeResult({self.scenario!r}, seed={self.seed}, {verdict!r}, sim_time={self.sim_time:.1f} s)"

    def as_dict(self) -> dict[str, Any]:
        """Return plain JSON values, as `pilegrasp run --json` prints them.

        The times of a tick are None if the attempt failed before its first one.
        """
        ticked = len(self.tick_times) > 0
        median, p99 = (1e6 * np.percentile(self.tick_times, [50.0, 99.0])).tolist() if ticked else (None, None)
        return {
            "scenario": self.scenario,
            "seed": self.seed,
            "config_hash": self.config_hash,
            "success": self.success,
            "grasped": self.grasped,
            "reason": self.reason,
            "outcomes": [outcome.as_dict() for outcome in self.outcomes],
            **({"attempts": [attempt.as_dict() for attempt in self.attempts]} if self.attempts else {}),
            "packing_density": self.packing_density,
            "sim_time": self.sim_time,
            "wall_time": self.wall_time,
            "realtime_factor": self.sim_time / self.wall_time,
            "controller": {
                "ticks": len(self.tick_times),
                "median_us": median,
                "p99_us": p99,
                "limited": self.limited_ticks,
                "fallbacks": self.fallback_ticks,
            },
            **({"carried": dict(self.carried)} if self.carried else {}),
            **({"notes": list(self.notes)} if self.notes else {}),
        }
