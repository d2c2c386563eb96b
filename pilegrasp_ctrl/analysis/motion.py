"""An attempt as JSON numbers: its motion pattern, and its force on the table."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..recording import Recording
from .contact_network import force_chains, objects_touching_hand
from .kept_objects import Separation, held_names
from .motion_field import Funnel, MotionField
from .push_motion import PushMotion
from .reading import first_outcome

UNLOADED_TIME = 0.3
"""Time at the start of the approach over which the force is averaged while nothing touches the hand [s]; chosen."""


def measure(recording: Recording) -> dict[str, Any]:
    """Return the motion pattern of an attempt, whatever its outcome; a value that does not apply is None.

    Keys, in m and m/s:
        triggered: Whether the force along the push reached F_grasp.
        hand_speed: Median speed of the hand from the pile's first motion to the end of the push.
        approach_speed: Mean speed at which objects ahead of the leading edge come nearer to the hand.
        spread_speed: Mean speed at which objects ahead of the edge and beside it move away from it, in the scene.
        spread_forward: Mean component of that motion along the push.
        spread_sideways: Mean component of that motion across the push.
        mouth_width: Width of the hand's leading edge.
        funnel_width: Width of the funnel two diameters ahead of the edge.
        separated: {object, time, stabilised}, from the frames of the push alone.
        in_hand: Names of all objects that are in the hand at the end of the push, or touched right ahead of its edge.
            The separated object is one of them.
        held: Names of the objects in the hand at the end.
        agreed: Whether the separated object is held; None if no object is held.
        force_chains: See `force_chains`; absent if the recording holds no contacts.
    """
    push = PushMotion.of(recording)
    separated, caught = None, np.zeros(0, dtype=bool)
    held = held_names(recording)
    row = first_outcome(recording, "push")
    result: dict[str, Any] = {"triggered": row is not None and row.get("trigger") == "grasp force"}
    names = ("approach_speed", "spread_speed", "spread_forward", "spread_sideways", "mouth_width", "funnel_width")
    result |= dict.fromkeys(("hand_speed", *names))
    if push:
        every = push.in_hand | (objects_touching_hand(recording, push) & push.at_edge)
        separated, caught = Separation.of(push, every), every[-1]
        result |= {"hand_speed": push.hand_speed, "mouth_width": 2.0 * push.half_width} | _speeds(push)
        result["funnel_width"] = Funnel.of(MotionField.of(push)).width_at(4.0 * push.radius)
        if chains := force_chains(recording, push):
            result["force_chains"] = chains
    return result | {
        "separated": separated.as_dict() if separated else None,
        "in_hand": [push.objects[index] for index in np.flatnonzero(caught)] if push else [],
        "held": held,
        "agreed": (separated is not None and separated.object in held) if held else None,
    }


def measure_attempt(recording: Recording) -> dict[str, Any]:
    """Return the measures that the paper's claims need, as JSON values: the `motion` pattern and the `table_force`."""
    return {"motion": measure(recording), "table_force": table_force(recording)}


def annotate(recording: Recording) -> Recording:
    """Return the recording with its motion pattern in `meta["motion"]`; unchanged if there was no push."""
    if first_outcome(recording, "push") is None:
        return recording
    return replace(recording, meta={**recording.meta, "motion": measure(recording)})


def table_force(recording: Recording) -> dict[str, float] | None:
    """Return `mean` and `peak` of the vertical force on the hand during the push [N], or None without a push.

    The force is relative to the force in the air before touch-down. It therefore includes the load on the hand when the
    push begins. Objects also press on a sloping hand, but for most of a push the table does.
    """
    approach, push = first_outcome(recording, "approach"), first_outcome(recording, "push")
    if approach is None or push is None:
        return None
    time, vertical = recording.signal_time, recording.signals["wrench"][:, 2].astype(float)
    air = time <= float(approach["start"]) + UNLOADED_TIME
    pushing = (time >= float(push["start"])) & (time <= float(push["end"]))
    if not air.any() or not pushing.any():
        return None
    force = vertical[pushing] - vertical[air].mean()
    return {"mean": float(np.mean(force)), "peak": float(force.max())}


def _speeds(push: PushMotion) -> dict[str, float | None]:
    """Return mean speeds over time and objects [m/s].

    The leading edge is a segment on y = 0. Ahead of it the direction to the nearest point is along the push; beside it,
    to the nearer end. The component along that direction is the rate at which the distance changes.
    """
    duration = np.broadcast_to(np.diff(push.time)[:, None], push.before_mouth.shape)

    def mean(values: np.ndarray, where: np.ndarray) -> float | None:
        total = float(duration[where].sum())
        return float((values * duration)[where].sum()) / total if total > 0.0 else None

    y = push.midpoints[..., 1]
    away = push.midpoints - np.stack([np.zeros_like(y), np.clip(y, -push.half_width, push.half_width)], axis=-1)
    away = away / np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), 1e-9)
    velocity, beside = push.absolute_velocity, push.beside_mouth
    return {
        "approach_speed": mean(-push.relative_velocity[..., 0], push.before_mouth),
        "spread_speed": mean((velocity * away).sum(axis=-1), beside),
        "spread_forward": mean(velocity[..., 0], beside),
        "spread_sideways": mean(velocity[..., 1] * np.sign(y), beside),
    }
