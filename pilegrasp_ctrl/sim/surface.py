"""What a body's skin does in a contact."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Surface:
    """Friction and restitution of one body, in the paper's (and Bullet's) vocabulary.

    Attributes:
        lateral: sliding friction coefficient [-].
        spinning: torsional friction [m], the torque about the normal per newton of normal force.
        rolling: rolling friction [m], the torque about the tangent per newton of normal force.
        restitution: ratio of separation to approach speed [-].
        rank: who governs a contact under the "paper" rule: 2 end-effector, 1 object, 0 support.
    """

    lateral: float
    spinning: float
    rolling: float
    restitution: float
    rank: int

    def __post_init__(self) -> None:
        if min(self.lateral, self.spinning, self.rolling) < 0.0 or not 0.0 <= self.restitution <= 1.0:
            raise ValueError("friction must not be negative and restitution must lie in [0, 1]")


SUPPORT = Surface(lateral=0.25, spinning=0.001, rolling=0.001, restitution=0.72, rank=0)
"""Table, walls and frame: smooth wood, against which the tennis ball's coefficients were measured (Cross 2002)."""
