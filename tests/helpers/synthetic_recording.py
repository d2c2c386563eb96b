"""A synthetic attempt with the form of a real one: an arm, a hand of capsules, spheres, a table and a wall.

Nothing is simulated. The motion follows from formulas, so that tests of the recording and the viewer need no engine and
know every value.
"""

from __future__ import annotations

import numpy as np

from pilegrasp_ctrl.recording import Body, Recording, Shape
from pilegrasp_ctrl.recording_parts import Contacts

RADIUS = 0.028
WALL_X = 0.95
PHASES = (("approach", 0.0, 2.2), ("push", 2.2, 6.4), ("grasp", 6.4, 7.6), ("lift", 7.6, 10.0))
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def rotation(axis: str, angle: np.ndarray | float) -> np.ndarray:
    """Return quaternions (..., 4) wxyz of turns about a principal axis."""
    half = np.asarray(angle, dtype=float) / 2.0
    quaternion = np.zeros((*half.shape, 4))
    quaternion[..., 0] = np.cos(half)
    quaternion[..., 1 + "xyz".index(axis)] = np.sin(half)
    return quaternion


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the quaternion product a b, broadcast over leading axes."""
    a, b = np.broadcast_arrays(a, b)
    w, v, u, z = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    return np.concatenate([w * u - (v * z).sum(-1, keepdims=True), w * z + u * v + np.cross(v, z)], axis=-1)


def turned(quaternion: np.ndarray, vector: np.ndarray | tuple[float, ...]) -> np.ndarray:
    """Return vectors (..., 3) rotated by quaternions (..., 4)."""
    pure = np.concatenate([np.zeros((*np.shape(vector)[:-1], 1)), np.asarray(vector, dtype=float)], axis=-1)
    conjugate = quaternion * np.array([1.0, -1.0, -1.0, -1.0])
    return product(product(quaternion, pure), conjugate)[..., 1:]


def blend(time: np.ndarray, start: float, end: float) -> np.ndarray:
    """Return a smooth step from 0 to 1."""
    s = np.clip((time - start) / (end - start), 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)


def tool_path(time: np.ndarray) -> np.ndarray:
    """Return the tool's positions (F, 3) [m]: down, along +x, up."""
    x = 0.42 + 0.36 * np.clip((time - 2.2) / 4.2, 0.0, 1.0)
    z = 0.16 - 0.14 * blend(time, 0.0, 2.2) + 0.2 * blend(time, 7.8, 10.0)
    return np.stack([x, 0.01 * np.sin(time), z], axis=-1)


def arm_tracks(tool: np.ndarray) -> list[tuple[Body, np.ndarray, np.ndarray]]:
    shoulder = np.array([0.0, 0.0, 0.55])
    wrist = tool + np.array([-0.16, 0.0, 0.14])
    yaw = np.arctan2(wrist[:, 1], wrist[:, 0])
    reach = np.hypot(wrist[:, 0], wrist[:, 1])
    drop = shoulder[2] - wrist[:, 2]
    distance = np.hypot(reach, drop)
    upper, lower = 0.45, 0.40
    inner = np.arccos(np.clip((upper**2 + distance**2 - lower**2) / (2 * upper * distance), -1, 1))
    bend = np.pi - np.arccos(np.clip((upper**2 + lower**2 - distance**2) / (2 * upper * lower), -1, 1))
    pitch = np.arctan2(drop, reach) - inner + np.pi / 2
    first = product(rotation("z", yaw), rotation("y", pitch))
    second = product(first, rotation("y", bend))
    elbow = shoulder + turned(first, np.broadcast_to((0.0, 0.0, upper), tool.shape))
    end = elbow + turned(second, np.broadcast_to((0.0, 0.0, lower), tool.shape))
    hand = np.broadcast_to(rotation("y", np.deg2rad(135.0)), second.shape)
    grey, dark = (0.82, 0.83, 0.85, 1.0), (0.25, 0.27, 0.3, 1.0)

    def link(name: str, shape: Shape, position: np.ndarray, quaternion: np.ndarray) -> tuple:
        return Body(name, "arm", (shape,)), np.broadcast_to(position, tool.shape), quaternion

    still = np.broadcast_to(IDENTITY, second.shape)
    return [
        link("base", Shape("cylinder", (0.09, 0.275), (0, 0, 0.275), rgba=dark), np.zeros(3), still),
        link("shoulder_yaw", Shape("sphere", (0.085,), rgba=dark), shoulder, rotation("z", yaw)),
        link("shoulder_pitch", Shape("cylinder", (0.06, 0.1), (0, 0, 0), rotation("x", np.pi / 2)), shoulder, first),
        link("upper_arm", Shape("capsule", (0.05, 0.225), (0, 0, 0.225), rgba=grey), shoulder, first),
        link("elbow", Shape("sphere", (0.058,), rgba=dark), elbow, second),
        link("forearm", Shape("capsule", (0.042, 0.2), (0, 0, 0.2), rgba=grey), elbow, second),
        link("wrist", Shape("sphere", (0.046,), rgba=dark), end, second),
        link("flange", Shape("cylinder", (0.035, 0.03), (0, 0, 0.05), rgba=dark), end, hand),
    ]


def hand_tracks(time: np.ndarray, tool: np.ndarray) -> list[tuple[Body, np.ndarray, np.ndarray]]:
    skin, palm_colour = (0.93, 0.78, 0.6, 1.0), (0.2, 0.22, 0.26, 1.0)
    palm_turn = np.broadcast_to(rotation("y", np.deg2rad(130.0)), (time.size, 4))
    palm = tool + np.array([-0.07, 0.0, 0.075])
    box = Body("palm", "hand", (Shape("box", (0.012, 0.05, 0.045), rgba=palm_colour),))
    tracks = [(box, palm, palm_turn)]
    curl = -0.1 - 0.42 * blend(time, 6.4, 7.6)
    for finger, y in enumerate((-0.039, -0.013, 0.013, 0.039, 0.0)):
        thumb = finger == 4
        turn = product(palm_turn, rotation("y", np.full(time.size, -0.9 if thumb else 0.0)))
        base = palm + turned(palm_turn, np.broadcast_to((0.02 if thumb else 0.0, y, 0.02), tool.shape))
        for segment in range(4 if thumb else 6):
            length = 0.018 - 0.001 * segment
            shape = Shape("capsule", (0.009 - 0.0006 * segment, length / 2), (0, 0, length / 2), rgba=skin)
            name = f"{'thumb' if thumb else f'finger{finger}'}_{segment}"
            turn = product(turn, rotation("y", curl * (-1.0 if thumb else 1.0)))
            tracks.append((Body(name, "hand", (shape,)), base, turn))
            base = base + turned(turn, np.broadcast_to((0.0, 0.0, length), tool.shape))
    return tracks


def object_tracks(time: np.ndarray, tool: np.ndarray, count: int, seed: int, carried: int) -> list[tuple]:
    rng = np.random.default_rng(seed)
    tracks = []
    for index in range(count):
        layer, place = divmod(index, 12)
        row, column = divmod(place, 4)
        start = np.array(
            [
                0.68 + 0.058 * row + 0.029 * layer + rng.uniform(-0.002, 0.002),
                0.058 * (column - 1.5) + 0.029 * layer + rng.uniform(-0.002, 0.002),
                RADIUS + 0.046 * layer,
            ]
        )
        pushed = tool[:, 0] + 0.02 + 0.057 * row
        stop = WALL_X - 0.01 - RADIUS - 0.03 * (2 - row)
        x = np.minimum(np.maximum(start[0], pushed), max(stop, start[0]))
        y = start[1] + 0.02 * (start[1] > 0) * blend(time, 4.0, 6.0)
        position = np.stack([x, y, np.full_like(time, start[2])], axis=-1)
        turn = product(rotation("y", (x - start[0]) / RADIUS), rotation("x", -(y - start[1]) / RADIUS))
        if index < carried:
            grasped = blend(time, 6.4, 7.6)[:, None]
            held = tool + np.array([0.01, 0.03 * (2 * index - 1), 0.03])
            position = (1.0 - grasped) * position + grasped * held
        shape = Shape("sphere", (RADIUS,), rgba=(0.95, 0.55, 0.2, 1.0))
        tracks.append((Body(f"light_sphere_{index:02d}", "object", (shape,)), position, turn))
    return tracks


def support_tracks(frames: int, corner: bool) -> list[tuple]:
    wood, stone = (0.78, 0.72, 0.62, 1.0), (0.6, 0.66, 0.72, 1.0)
    bodies = [
        Body("table", "support", (Shape("box", (0.55, 0.6, 0.02), (0.6, 0.0, -0.02), rgba=wood),)),
        Body("wall", "support", (Shape("box", (0.01, 0.3, 0.08), (WALL_X, 0.0, 0.08), rgba=stone),)),
    ]
    if corner:
        bodies.append(Body("side_wall", "support", (Shape("box", (0.2, 0.01, 0.08), (0.75, -0.16, 0.08), rgba=stone),)))
    return [(body, np.zeros((frames, 3)), np.broadcast_to(IDENTITY, (frames, 4))) for body in bodies]


def contacts(time: np.ndarray, tool: np.ndarray, bodies: list[Body]) -> Contacts:
    """Return three contacts in each frame of the push: hand and ball, two balls, ball and table."""
    names = [body.name for body in bodies]
    ball, other = (names.index(f"light_sphere_{k:02d}") for k in (0, 1))
    pairs = [[names.index("palm"), ball], [ball, other], [ball, names.index("table")]]
    forces = [[-4.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 0.6]]
    pushing = (time >= PHASES[1][1]) & (time < PHASES[1][2])
    return Contacts(
        start=np.concatenate([[0], np.cumsum(3 * pushing)]),
        bodies=np.tile(pairs, (pushing.sum(), 1)),
        position=np.repeat(tool[pushing], 3, axis=0),
        force=np.tile(forces, (pushing.sum(), 1)),
    )


def outcomes(success: bool) -> list[dict]:
    triggers = ("touch_force", "grasp_force" if success else "travel limit of 0.36 m", "closed", "lifted")
    peaks = (1.9, 17.3 if success else 11.2, 6.0, 4.1)
    travels = (0.14, 0.36, 0.0, 0.2)
    rows = [
        {"name": n, "status": "ended", "trigger": t, "start": a, "end": b, "travel": d, "peak_force": p}
        for (n, a, b), t, d, p in zip(PHASES, triggers, travels, peaks, strict=True)
    ]
    if not success:
        rows[1]["status"] = "failed"
        rows = rows[:2]
    return rows


def synthetic(
    success: bool = True,
    objects: int = 18,
    frames: int = 300,
    duration: float = 10.0,
    corner: bool = False,
    seed: int = 0,
    **meta: object,
) -> Recording:
    """Return an attempt of `frames` frames; keyword arguments replace entries of its meta."""
    duration = duration if success else min(duration, PHASES[1][2])
    time = np.linspace(0.0, duration, frames)
    tool = tool_path(time)
    tracks = [
        *arm_tracks(tool),
        (
            Body("wrist_sensor", "sensor", (Shape("cylinder", (0.03, 0.012)),)),
            tool + np.array([-0.11, 0.0, 0.1]),
            rotation("y", np.full(frames, 2.2)),
        ),
        *hand_tracks(time, tool),
        *object_tracks(time, tool, objects, seed, carried=2 if success else 0),
        *support_tracks(frames, corner),
    ]
    ticks = np.arange(0.0, duration, 0.01)
    rng = np.random.default_rng(seed + 1)
    pushing = (ticks >= 2.2) & (ticks < 6.4)
    force = np.where(pushing, (17.3 if success else 11.2) * ((ticks - 2.2) / 4.2) ** 2, 0.0)
    force = force + pushing * np.abs(rng.normal(0.0, 0.6, ticks.size))
    normal = 3.0 * blend(ticks, 2.0, 2.3) * (1.0 - blend(ticks, 7.6, 7.9)) + rng.normal(0.0, 0.1, ticks.size)
    path = tool_path(ticks)
    signals = {
        "push_force": force,
        "normal_force": normal,
        "wrench": np.stack([-force, 0.05 * force, normal, *np.zeros((3, ticks.size))], axis=-1),
        "torque_ratio": 0.2 + 0.1 * np.sin(ticks[:, None] + np.arange(7)),
        "tracking_error": 0.002 * np.abs(np.sin(ticks)),
        "orientation_error": 0.004 * np.abs(np.cos(ticks)),
        "closure": blend(ticks, 6.4, 7.6),
        "q": 0.5 * np.sin(ticks[:, None] + np.arange(7)),
        "v": 0.5 * np.cos(ticks[:, None] + np.arange(7)),
        "tool_position": path,
        "reference_position": path + 0.001,
    }
    facts: dict[str, object] = {
        "scenario": "spheres_wall",
        "seed": seed,
        "config_hash": "0123456789abcdef",
        "config": {
            "hand": "rbo_hand2",
            "support": {"kind": "corner" if corner else "wall"},
            "pile": {"object": "light_sphere", "count": objects},
            "strategy": {"speed": 0.1, "grasp_force": 17.0},
            "controller": {"kind": "operational_space", "solver": "daqp"},
        },
        "success": success,
        "grasped": 2 if success else 0,
        "reason": "" if success else "push: travel limit of 0.36 m before 17 N",
        "outcomes": outcomes(success),
        "versions": {"pilegrasp": "0.1.0", "mujoco": "4.0.0", "pinocchio": "4.1.0"},
        "hand": "rbo_hand2",
        "grasp_force": 17.0,
        "signal_units": {"push_force": "N", "normal_force": "N", "tracking_error": "m"},
    }
    return Recording(
        meta=facts | meta,
        bodies=tuple(body for body, _, _ in tracks),
        frame_time=time,
        body_position=np.stack([position for _, position, _ in tracks], axis=1),
        body_quaternion=np.stack([np.broadcast_to(turn, (frames, 4)) for _, _, turn in tracks], axis=1),
        signal_time=ticks,
        signals=signals,
        contacts=contacts(time, tool, [body for body, _, _ in tracks]) if objects > 1 else None,
    )
