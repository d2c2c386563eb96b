"""What the claims need of each recording: the motion pattern, and the force of the table on the hand."""

from __future__ import annotations

from typing import Any

from pilegrasp_ctrl.analysis.motion import measure as motion
from pilegrasp_ctrl.analysis.motion import table_force
from pilegrasp_ctrl.recording import Recording

MEASURE = f"{__name__}.measure"


def measure(recording: Recording) -> dict[str, Any]:
    """Return `motion` and `table_force` of an attempt, as JSON values."""
    return {"motion": motion(recording), "table_force": table_force(recording)}
