"""The measured motion of a push, for the page: the separated object, and the funnel before the hand."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from pilegrasp_ctrl.analysis.motion import annotate
from pilegrasp_ctrl.analysis.motion_field import Funnel, MotionField
from pilegrasp_ctrl.analysis.push_motion import PushMotion, hand_axes
from pilegrasp_ctrl.recording import Recording

Result = TypeVar("Result")


def with_motion(recording: Recording) -> Recording:
    """Return the recording with its motion pattern in `meta["motion"]`; an existing pattern is kept."""
    if "motion" in recording.meta:
        return recording
    return _attempted(annotate, recording) or recording


def forward(recording: Recording) -> list[float]:
    """Return the horizontal direction (2,) in which the pushing hand points; +x without a push."""
    axes = _attempted(hand_axes, recording)
    return [1.0, 0.0] if axes is None else np.round(axes[0, :2], 5).tolist()


def push_frame(recording: Recording) -> dict[str, Any] | None:
    """Return the hand's leading edge and its funnel; None if no motion of the pile was measured.

    Keys, in metres along `forward` and to its left:
        start: Time at which the pile begins to move [s].
        end: Time at which the push ends [s].
        edge: Middle of the leading edge relative to the tool.
        half: Half the width of the leading edge.
        length: Distance from the leading edge to the rear of the hand.
        funnel: Rows of distance ahead of the edge, right side and left side; a single row if nothing flows in.
    """
    return _attempted(_push_frame, recording)


def _push_frame(recording: Recording) -> dict[str, Any] | None:
    push = PushMotion.of(recording)
    if push is None:
        return None
    funnel = Funnel.of(MotionField.of(push))
    return {
        "start": float(push.time[0]),
        "end": float(push.time[-1]),
        "edge": np.round(push.edge, 4).tolist(),
        "half": round(push.half_width, 4),
        "length": round(push.length, 4),
        "funnel": np.round(np.stack([funnel.x, funnel.right, funnel.left], axis=1), 4).tolist(),
    }


def _attempted(measure: Callable[[Recording], Result], recording: Recording) -> Result | None:
    """Return a measure; None if it fails, because a page must show a recording with any meta."""
    try:
        return measure(recording)
    except Exception as error:
        warnings.warn(f"the page leaves out a measure that failed: {error!r}", RuntimeWarning, stacklevel=3)
        return None
