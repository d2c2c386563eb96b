"""A synthetic push by formulas: a hand of one box, and objects on given paths, so that every measure is known."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pilegrasp_ctrl.recording import Body, Recording, Shape

RADIUS = 0.03
SPEED = 0.1
FRONT = 0.02
HALF_WIDTH = 0.05
BEGIN, END, LAST = 1.0, 3.0, 5.0
"""The push lasts from 1 s to 3 s; the recording goes on to 5 s."""

ObjectPath = Callable[[np.ndarray], np.ndarray]


def at_rest(x: float, y: float) -> ObjectPath:
    """Return the path of an object at rest, relative to the middle of the leading edge at the start of the push [m]."""
    return lambda t: np.stack([np.full_like(t, x), np.full_like(t, y)], axis=-1)


def moving(x: float, y: float, vx: float, vy: float) -> ObjectPath:
    """Return the path of an object that moves from the start of the push to its end [m, m/s]."""
    return lambda t: np.stack([x + vx * pushed(t), y + vy * pushed(t)], axis=-1)


def pushed(time: np.ndarray) -> np.ndarray:
    """Return the time since the start of the push [s]; it stops at the end of the push."""
    return np.clip(time, BEGIN, END) - BEGIN


def yaw_quaternion(angle: float) -> np.ndarray:
    """Return the quaternion (w, x, y, z) of a turn about z [rad]."""
    return np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])


def push_recording(
    paths: Mapping[str, ObjectPath],
    *,
    alpha: float = 0.0,
    beta: float = 0.0,
    rigid: bool = False,
    held: tuple[str, ...] = (),
    trigger: str = "grasp force",
    outcomes: list[dict] | None = None,
    **meta: object,
) -> Recording:
    """Return a recording at 100 Hz of a hand that goes at `SPEED` along `alpha` [rad] and points `beta` to the left.

    The held objects are lifted at the end.
    """
    time = np.linspace(0.0, LAST, 501)
    turn = np.array([[np.cos(alpha), -np.sin(alpha)], [np.sin(alpha), np.cos(alpha)]])
    lift = 0.2 * np.clip(time - 4.0, 0.0, 1.0)
    quaternion = yaw_quaternion(alpha + beta)
    begin = np.array([0.5, 0.1])

    def placed(plane: np.ndarray, height: np.ndarray | float) -> np.ndarray:
        return np.column_stack([begin + plane @ turn.T, np.broadcast_to(height, time.shape)])

    travel = np.column_stack([SPEED * pushed(time), 0.0 * time])
    tool = placed(travel - [FRONT, 0.0], lift)
    hand = Body("palm", "hand", (Shape("box", (0.06, HALF_WIDTH, 0.01), (FRONT - 0.06, 0.0, 0.0)),))
    thumb = Body("thumb", "hand", (Shape("box", (0.01, 0.01, 0.01), (FRONT - 0.1, 0.0, 0.0)),))
    tracks = [(hand, tool, quaternion)]
    for name, path in paths.items():
        place = placed(path(time), RADIUS + lift * (name in held))
        tracks.append((Body(name, "object", (Shape("sphere", (RADIUS,)),)), place, np.array([1.0, 0.0, 0.0, 0.0])))
    if not rigid:
        tracks.append((thumb, tool, quaternion))
    push = {"name": "push", "status": "ended" if trigger == "grasp force" else "failed", "trigger": trigger}
    rows = [push | {"start": BEGIN, "end": END, "travel": 0.2, "peak_force": 17.0}] if outcomes is None else outcomes
    strategy = {"lift_height": 0.2, "beta_deg": float(np.degrees(beta))}
    return Recording(
        meta={"outcomes": rows, "grasped": len(held), "config": {"strategy": strategy}} | meta,
        bodies=tuple(body for body, _, _ in tracks),
        frame_time=time,
        body_position=np.stack([place for _, place, _ in tracks], axis=1),
        body_quaternion=np.stack([np.broadcast_to(q, (time.size, 4)) for _, _, q in tracks], axis=1),
        signal_time=time,
        signals={"tool_position": tool, "reference_position": tool},
    )


RESTLESS = moving(0.3, 0.3, 0.02, 0.0)
"""Path of an object far from the hand that moves from the start of the push on, so that the pile counts as moving."""


def crowd(vx: float, slope: float = 0.0) -> dict[str, ObjectPath]:
    """Return rows of objects over the whole width that move along the push at vx, and off its middle at slope * y."""
    paths = {"far": RESTLESS}
    for i, x in enumerate(np.arange(0.01, 0.4, 0.03)):
        for j, y in enumerate(np.arange(-0.12, 0.121, 0.03)):
            paths[f"o{i}_{j}"] = moving(x, y, vx, slope * y)
    return paths


def sliding_in(x: float, y: float, stop: float) -> ObjectPath:
    """Return the path of an object that rests until the leading edge is `stop` [m] past it, and then moves with it."""
    return lambda t: np.stack([np.maximum(x, SPEED * pushed(t) - stop), y + 0 * t], axis=-1)
