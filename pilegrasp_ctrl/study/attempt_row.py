"""An attempt as the store knows it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class AttemptRow:
    """One row of `attempts`.

    Attributes:
        config_hash: of the scenario.
        seed: of the attempt.
        condition: the scenario's name under "scenario", and what was varied.
        result: as `pilegrasp run --json` without what a clock told, and `measures` where there was a measure; None
            where the attempt raised.
        error: the sentence that it raised, or None.
    """

    config_hash: str
    seed: int
    condition: Mapping[str, Any]
    result: Mapping[str, Any] | None
    error: str | None

    @property
    def success(self) -> bool:
        """Whether the attempt succeeded; one that raised did not."""
        return self.result is not None and bool(self.result["success"])

    @property
    def grasped(self) -> int:
        """Number of objects held at the end."""
        return 0 if self.result is None else int(self.result["grasped"])

    @property
    def triggered(self) -> bool:
        """Whether the push ended because the wrist sensor felt F_grasp."""
        outcomes = () if self.result is None else self.result["outcomes"]
        return any(outcome["trigger"] == "grasp force" for outcome in outcomes)
