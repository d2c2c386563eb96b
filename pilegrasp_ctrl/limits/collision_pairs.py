"""Which capsules of an arm a collision limit keeps off one another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np
import pinocchio as pin

from ..arm.capsule import Capsule
from ..arm.controllability import spread_postures
from ..arm.frames import frame_id
from ..arm.model import ArmModel
from ..exceptions import ConfigurationError, remedy_for
from .collision_geometry import Geometry, Pair

MOSTLY = 0.5
"""Share of the postures within the margin from which a pair counts as always together; chosen."""


def carrier(model: pin.Model, frame: str) -> int:
    """Return the index of the joint that carries a frame; 0 for a frame of the base."""
    joint: int = model.frames[frame_id(model, frame, model.name)].parentJoint
    return joint


def apart(arm: ArmModel, capsules: Sequence[Capsule], margin: float) -> list[Pair]:
    """Return the pairs of capsules on links that no joint joins, and that are apart by the margin in most postures."""
    model = arm.pinocchio_model
    pairs = []
    for (first, one), (second, other) in combinations(enumerate(capsules), 2):
        joints = carrier(model, one.frame), carrier(model, other.frame)
        near, far = min(joints), max(joints)
        if near != far and model.parents[far] != near:
            pairs.append(_pair(capsules, first, second))
    geometry, together = Geometry(model, capsules, (), pairs), np.zeros(len(pairs))
    postures = list(spread_postures(arm.q_lower, arm.q_upper))
    for q in postures:
        geometry.place(q)
        together += geometry.distances() < margin
    return [pair for pair, times in zip(pairs, together.tolist(), strict=True) if times < MOSTLY * len(postures)]


def named(capsules: Sequence[Capsule], frames: Iterable[tuple[str, str]]) -> list[Pair]:
    """Return the pairs of capsules on pairs of frames.

    Raises:
        ConfigurationError: An entry is no pair of different frames with capsules.
    """
    known = list(dict.fromkeys(capsule.frame for capsule in capsules))
    pairs = []
    for entry in frames:
        if isinstance(entry, str) or not isinstance(entry, Sequence) or len(entry) != 2 or entry[0] == entry[1]:
            raise ConfigurationError(f"self_collision has the entry {entry!r:.80}; give pairs of different frames")
        for frame in entry:
            if frame not in known:
                remedy = remedy_for(str(frame), known, f"the frames with one are {', '.join(known)}")
                raise ConfigurationError(f"self_collision names {frame!r}, which has no capsule; {remedy}")
        pairs += [
            _pair(capsules, first, second)
            for first, one in enumerate(capsules)
            for second, other in enumerate(capsules)
            if (one.frame, other.frame) == tuple(entry)
        ]
    return pairs


def _pair(capsules: Sequence[Capsule], first: int, second: int) -> Pair:
    return Pair(first, second, f"collision[{capsules[first].frame} | {capsules[second].frame}]")
