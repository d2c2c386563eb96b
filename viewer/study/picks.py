"""The attempts of an order, read from a result without trust in its content."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from pilegrasp_ctrl.analysis.reading import lookup, number, text

MAX_PICKS = 500
"""Largest number of attempts of an order that are counted; chosen, five times what a scenario allows."""
MAX_DELIVERED = 1000
"""Largest number of objects that an attempt may have delivered; chosen, more than any pile has."""

MISSED = "what was let go did not land in the crate"
"""Reason of an attempt whose operator counted a delivery that was none."""

UNFELT = "something was held, and not felt at the wrist"
"""Reason of an attempt whose operator took a full hand for an empty one."""

_NUMBER = re.compile(r"\d+(?:\.\d+)?")


@dataclass(frozen=True, slots=True)
class Pick:
    """One attempt of an order.

    Attributes:
        delivered: Number of objects that it added to the order's crate.
        counted: Number of objects that its operator counted as delivered.
        words: Reason for no delivery; "" after a delivery.
        unfelt: Whether the hand held something of which its operator did not know.
    """

    delivered: int
    counted: int
    words: str
    unfelt: bool = False

    @property
    def wrong(self) -> str:
        """What went wrong; "" if nothing did."""
        if not self.delivered:
            return UNFELT if self.unfelt else self.words or MISSED
        if self.counted != self.delivered:
            return f"{self.counted} counted where {self.delivered} were delivered"
        return ""


def picks_of(result: Any) -> tuple[Pick, ...]:
    """Return the attempts of an order; none if the result is that of no order."""
    entries = lookup(result, "attempts")
    return tuple(_pick(entry) for entry in entries[:MAX_PICKS]) if isinstance(entries, list) else ()


def _pick(entry: Any) -> Pick:
    delivered = _count(entry, "delivered") or 0
    counted = _count(entry, "believed_delivered")
    unfelt = _count(entry, "believed_held") == 0 and bool(_count(entry, "held"))
    return Pick(delivered, delivered if counted is None else counted, text(lookup(entry, "reason"), 120), unfelt)


def _count(entry: Any, key: str) -> int | None:
    value = number(lookup(entry, key))
    return None if value is None else int(min(max(value, 0.0), MAX_DELIVERED))


def kind_of_reason(words: str) -> str:
    """Return a reason with its numbers replaced, so that equal reasons with other numbers count together."""
    return _NUMBER.sub("…", words)
