"""Touch in the fingers: how many objects they touch."""

from __future__ import annotations

import mujoco
import numpy as np

from .scene import Scene

RIGID_PARTS = ("sensor", "palm", "palm_web", "housing")
"""Bodies of a hand that are no fingers."""


class TouchSensor:
    """Counts the objects in contact with the fingers. It is perfect: without noise, delay and threshold."""

    def __init__(self, scene: Scene) -> None:
        """Find the bodies of fingers and objects."""
        model = scene.model
        owner = np.zeros(model.nbody, dtype=np.int64)
        for body in scene.hand_bodies:
            owner[body] = -1 if model.body(body).name not in RIGID_PARTS else 0
        owner[list(scene.objects)] = np.arange(1, len(scene.objects) + 1)
        self._owner = owner[model.geom_bodyid]

    def count(self, data: mujoco.MjData) -> int:
        """Return the number of objects that touch a finger, as of the last physics step."""
        pairs = self._owner[data.contact.geom[data.contact.efc_address >= 0]].reshape(-1, 2)
        touching = pairs[(pairs.min(axis=1) == -1) & (pairs.max(axis=1) > 0)]
        return len(np.unique(touching.max(axis=1)))
