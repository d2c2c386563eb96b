"""What one finger does: deflection, stiffness, blocked force and closing time, each measured on the compiled hand."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from ...types import Array
from .hand_bench import HandBench

FINGER = "middle"
SETTLING = 1.5
"""Longer than it takes a loaded finger to come to rest [s]."""
LOAD_PERIOD = 0.01
"""A load follows the fingertip in steps of this [s]."""
SMALL_FORCE = 0.1
"""A load that bends a finger by a few millimetres [N]."""
CLOSED = 0.9
"""A finger has closed when its tip has covered this part of its way."""


def axes(bench: HandBench, finger: str = FINGER) -> tuple[Array, Array]:
    """Return the unit vectors (3,) across a straight finger in the world: the way it closes, and sideways."""
    body = bench.start().body(f"{finger}_1")
    rotation = body.xmat.reshape(3, 3)
    return rotation[:, 2].copy(), rotation[:, 1].copy()


def displacement(bench: HandBench, force: Array, closure: float = 0.0, finger: str = FINGER) -> Array:
    """Return where the fingertip comes to rest under `force` (3,) [N], from where the straight finger has it [m]."""
    data = bench.start()
    before = bench.fingertip(data, finger)
    data.ctrl[:] = closure
    # Inflated at once: how long it takes is another measurement.
    data.act[:] = closure
    while data.time < SETTLING:
        bench.load(data, finger, force)
        bench.advance(data, LOAD_PERIOD)
    return bench.fingertip(data, finger) - before


def deflection(bench: HandBench, force: float, finger: str = FINGER) -> float:
    """Return how far a load [N] against the closing direction moves the tip of a straight, vented finger [m]."""
    closing, _ = axes(bench, finger)
    return float(-displacement(bench, -force * closing, 0.0, finger) @ closing)


def stiffness(bench: HandBench, closure: float = 0.0, finger: str = FINGER) -> float:
    """Return the stiffness at the tip against a small load along its present normal, in the plane of closing [N/m]."""
    closing, sideways = axes(bench, finger)
    at_rest = displacement(bench, np.zeros(3), closure, finger)
    turn = _tip_turn(bench, closure, finger)
    normal = np.cos(turn) * closing - np.sin(turn) * np.cross(sideways, closing)
    loaded = displacement(bench, SMALL_FORCE * normal, closure, finger)
    return float(SMALL_FORCE / ((loaded - at_rest) @ normal))


def lateral_stiffness(bench: HandBench, finger: str = FINGER) -> float:
    """Return the stiffness at the tip of a straight finger against a small load from the side [N/m]."""
    _, sideways = axes(bench, finger)
    return float(SMALL_FORCE / (displacement(bench, SMALL_FORCE * sideways, 0.0, finger) @ sideways))


def blocked_force(bench: HandBench, closure: float = 1.0, finger: str = FINGER) -> float:
    """Return the force on the tip that keeps it at the height of the straight finger's while it closes [N]."""
    closing, _ = axes(bench, finger)

    def rise(force: float) -> float:
        return float(displacement(bench, -force * closing, closure, finger) @ closing)

    # A load several times as large folds the finger over.
    return float(brentq(rise, 0.0, 15.0, xtol=1e-3))


def closing_time(bench: HandBench, finger: str = FINGER) -> float:
    """Return the time from the command to close until the tip has covered `CLOSED` of its way in free space [s]."""
    final = np.linalg.norm(displacement(bench, np.zeros(3), 1.0, finger))
    data = bench.start()
    before = bench.fingertip(data, finger)
    data.ctrl[:] = 1.0
    while np.linalg.norm(bench.fingertip(data, finger) - before) < CLOSED * final:
        bench.advance(data, bench.model.opt.timestep)
    return float(data.time)


def free_bend(bench: HandBench, closure: float = 1.0, finger: str = FINGER) -> float:
    """Return by how much the tip of a finger turns when it closes in free space [rad]."""
    return _tip_turn(bench, closure, finger)


def _tip_turn(bench: HandBench, closure: float, finger: str) -> float:
    data = bench.start()
    data.ctrl[:] = closure
    data.act[:] = closure
    bench.advance(data, SETTLING)
    segments = bench.hand.parameters["thumb" if finger == "thumb" else "fingers"]["segments"]
    return float(sum(data.joint(f"{finger}_bend_{i + 1}").qpos[0] for i in range(segments)))
