"""Touch in the fingers: how many objects they touch, and how many of these behind the fingertips."""

from __future__ import annotations

import mujoco
import numpy as np

from ..types import Array
from .scene import Scene

RIGID_PARTS = ("sensor", "palm", "palm_web", "housing")
"""Bodies of a hand that are no fingers."""


class TouchSensor:
    """Counts the objects in contact with the fingers. It is perfect: without noise, delay and threshold."""

    def __init__(self, scene: Scene) -> None:
        """Find the bodies of fingers, fingertips and objects. A fingertip is the last link of a finger."""
        model = scene.model
        parents = {int(model.body_parentid[body]) for body in scene.hand_bodies}
        owner = np.zeros(model.nbody, dtype=np.int64)
        for body in scene.hand_bodies:
            if model.body(body).name not in RIGID_PARTS:
                owner[body] = -2 if body in parents else -1
        owner[list(scene.objects)] = np.arange(1, len(scene.objects) + 1)
        self._owner = owner[model.geom_bodyid]

    def count(self, data: mujoco.MjData) -> tuple[int, int]:
        """Return the numbers of objects that touch a finger, and that touch one behind its tip.

        Both are as of the last physics step.
        """
        pairs = self._owner[data.contact.geom[data.contact.efc_address >= 0]].reshape(-1, 2)
        finger, thing = pairs.min(axis=1), pairs.max(axis=1)
        return _count(thing[(finger < 0) & (thing > 0)]), _count(thing[(finger == -2) & (thing > 0)])


def _count(objects: Array) -> int:
    return len(np.unique(objects))
