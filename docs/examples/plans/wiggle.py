"""A plan that wiggles the hand from side to side while it pushes, and pushes again if it never feels F_grasp."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pilegrasp_ctrl.primitives.guarded_motions import ActivePush, Push
from pilegrasp_ctrl.primitives.retry import push_again
from pilegrasp_ctrl.types import Reference

AMPLITUDE, FREQUENCY = 0.008, 2.0  # [m], [Hz]


@dataclass(frozen=True)
class Wiggle:
    """A push with a wiggle; it ends like the push inside it."""

    push: Push
    name: str = "push"
    tares: ClassVar[bool] = True

    def begin(self, inputs, last):
        return ActiveWiggle(self.push.begin(inputs, last), self.push.direction)


@dataclass(frozen=True)
class ActiveWiggle:
    inner: ActivePush
    direction: np.ndarray

    def setpoint(self, inputs):
        aside = AMPLITUDE * math.sin(2.0 * math.pi * FREQUENCY * self.inner.elapsed(inputs))
        setpoint, left = self.inner.setpoint(inputs), np.array([-self.direction[1], self.direction[0], 0.0])
        at = setpoint.reference
        return setpoint._replace(reference=Reference(at.pose.moved(aside * left), at.twist, at.acceleration))

    def ending(self, inputs):
        return self.inner.ending(inputs)

    def force(self, inputs):
        return self.inner.force(inputs)


def plan(parts):
    shipped = parts.grasp_plan()
    approach, push, *rest = shipped.primitives
    return replace(shipped, primitives=(approach, push_again(push, 0.06, tries=3, make=Wiggle), *rest))
