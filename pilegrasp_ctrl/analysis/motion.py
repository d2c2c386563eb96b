"""An attempt's motion pattern in numbers that JSON can hold."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..recording import Recording
from .force_chains import force_chains
from .funnel import Funnel
from .grasp_check import are_held
from .motion_field import MotionField
from .push_motion import PushMotion, has_points, primitive, strategy_number, tool_position
from .separation import Separation
from .touching import touching

USUAL_LIFT = 0.2


def measure(recording: Recording) -> dict[str, Any]:
    """Return the motion pattern of an attempt, whatever came of it; what does not apply is None.

    Keys, in m and m/s:
        triggered: whether the force along the push reached F_grasp.
        hand_speed: median speed of the hand from the pile's first motion to the end of the push.
        approach_speed: mean speed at which objects before the leading edge come nearer to the hand.
        spread_speed: mean speed at which objects ahead of it and beside it move away from the edge, in the scene;
            spread_forward and spread_sideways are the mean components of that motion along the push and across it.
        mouth_width: of the hand's leading edge.
        funnel_width: of the funnel, two diameters ahead of the edge.
        separated: {object, time, stabilised}, from the frames of the push alone.
        in_hand: names of all objects in the hand at the end of the push, or touched right before its edge; the
            separated one is among them.
        held: names of the objects in the hand at the end.
        agreed: whether the separated object is one of them; None where none is held.
        force_chains: see `force_chains`; absent where the recording holds no contacts.
    """
    push = PushMotion.of(recording)
    separated, caught = None, np.zeros(0, dtype=bool)
    held = held_names(recording)
    row = primitive(recording, "push")
    result: dict[str, Any] = {"triggered": row is not None and row.get("trigger") == "grasp force"}
    names = ("approach_speed", "spread_speed", "spread_forward", "spread_sideways", "mouth_width", "funnel_width")
    result |= dict.fromkeys(("hand_speed", *names))
    if push:
        every = push.in_hand | (touching(recording, push) & push.at_edge)
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


def annotate(recording: Recording) -> Recording:
    """Return the recording with its motion pattern in `meta["motion"]`, for a page to show; as it is without a push."""
    if primitive(recording, "push") is None:
        return recording
    return replace(recording, meta={**recording.meta, "motion": measure(recording)})


def held_names(recording: Recording) -> list[str]:
    """Return the names of the objects in the hand at the end, by the rule of the simulation's own verdict."""
    chosen = [index for index, body in enumerate(recording.bodies) if body.role == "object"]
    if not chosen or not recording.meta.get("grasped") or not has_points(recording, "tool_position"):
        return []
    lift = strategy_number(recording, "lift_height", USUAL_LIFT)
    place = recording.body_position[:, chosen].astype(float)
    held = are_held(place[-1], tool_position(recording, recording.frame_time[-1:])[0], place[0, :, 2], lift)
    return [recording.bodies[chosen[index]].name for index in np.flatnonzero(held)]


def _speeds(push: PushMotion) -> dict[str, float | None]:
    """Return means over time and objects.

    The leading edge is a segment on y = 0. Before it the way to the nearest point is along the push; beside it, to
    the nearer end. A component along that way is the rate at which the distance changes.
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
