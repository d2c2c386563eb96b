"""Recordings with a missing or wrong part that the analysis needs, by the name of the part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pilegrasp_ctrl.recording import Recording
from pushed_pile import RESTLESS, at_rest, push_recording
from synthetic_recording import synthetic


def one_frame(recording: Recording) -> Recording:
    return replace(
        recording,
        frame_time=recording.frame_time[:1],
        body_position=recording.body_position[:1],
        body_quaternion=recording.body_quaternion[:1],
        contacts=None,
    )


ODD_RECORDINGS = {
    "synthetic": synthetic(success=False),
    "no objects": synthetic(objects=0),
    "failed approach": synthetic(outcomes=[{"name": "approach", "status": "failed", "start": 0.5, "end": 2.0}]),
    "no outcomes": synthetic(outcomes=None),
    "garbled outcomes": synthetic(outcomes=["push", {"name": "push", "start": None, "end": "soon"}]),
    "push without a trigger": synthetic(outcomes=[{"name": "push", "start": 2.2, "end": 6.4}]),
    "push of no length": synthetic(outcomes=[{"name": "push", "start": 2.2, "end": 2.2}]),
    "push beyond the recording": synthetic(outcomes=[{"name": "push", "start": 90.0, "end": 99.0}]),
    "one frame": one_frame(synthetic()),
    "no signals": replace(synthetic(), signals={}),
    "no signal rows": replace(
        synthetic(),
        signal_time=np.zeros(0),
        signals={name: np.zeros((0, 3)) for name in ("tool_position", "reference_position")},
    ),
    "push at a time that no float holds": synthetic(outcomes=[{"name": "push", "start": 10**400, "end": 3.0}]),
    "pile at rest": push_recording({"a": at_rest(0.5, 0.0)}),
    "no config": push_recording({"a": RESTLESS}, held=("a",), config=None),
    "no hand": replace(
        push_recording({"a": RESTLESS}),
        bodies=tuple(replace(body, role="object") for body in push_recording({"a": RESTLESS}).bodies),
    ),
}
