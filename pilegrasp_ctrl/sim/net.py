"""A net-bag: a loop of limited length around a few objects, which pulls but never pushes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from ..types import Array

NATURAL_FREQUENCY = 300.0
"""Natural frequency of a taut loop [rad/s], critically damped; chosen."""

IMPEDANCE = 0.95
"""d in MuJoCo's solimp [-], constant, chosen. Three limes that hang from one stretch the loop by less than 0.1 mm."""

SPACING = 1.03
"""Distance of neighbours in a bag at the start, over the distance of touching objects [-]; chosen."""


@dataclass(frozen=True, slots=True)
class Net:
    """A bag around `members` objects.

    The girth of a taut bag around equal round objects is the girth of one of them plus the loop through their centres.
    The bag is therefore modelled as that loop: one spatial tendon, limited in length, without stiffness or damping. It
    acts at the centres, because an object turns freely in a bag, and slides freely from one object to the next.

    Attributes:
        members: Number of objects in one bag, 2 or more.
        loop: Greatest length of the closed loop through their centres [m].
    """

    members: int
    loop: float

    def scaled(self, factor: float) -> Net:
        """Return the net with its length multiplied."""
        return Net(self.members, factor * self.loop)

    def ring_radius(self, flank_radius: float) -> float:
        """Return the radius [m] of the ring on which objects of `flank_radius` [m] are side by side."""
        return SPACING * flank_radius / math.sin(math.pi / self.members)

    def shortest_loop(self, flank_radius: float) -> float:
        """Return the shortest loop [m] in which objects of `flank_radius` [m] fit side by side."""
        return 2.0 * SPACING * self.members * flank_radius

    def start_position(self, index: int, flank_radius: float) -> Array:
        """Return the position (3,) [m] of object `index` in an upright bag at the origin."""
        angle = 2.0 * math.pi * (index % self.members) / self.members
        return self.ring_radius(flank_radius) * np.array([math.cos(angle), math.sin(angle), 0.0])

    def object_poses(self, bags: Array, flank_radius: float) -> Array:
        """Return the poses (members n, 7) of all objects, bag by bag, from the poses (n, 7) of upright bags."""
        angles = 2.0 * math.pi * np.arange(self.members) / self.members
        # numpy's arctan2 rounds differently on processors with and without AVX-512.
        half_yaws = np.array([math.atan2(z, w) for w, z in bags[:, [3, 6]].tolist()])
        yaw = 2.0 * half_yaws[:, None] + angles
        poses = np.repeat(bags, self.members, axis=0)
        offsets = self.ring_radius(flank_radius) * np.stack([np.cos(yaw), np.sin(yaw)], axis=-1)
        poses[:, :2] += offsets.reshape(-1, 2)
        return poses

    def add_to(self, spec: mujoco.MjSpec, name: str, bodies: Sequence[str]) -> None:
        """Tie `bodies` by a tendon called `name`; each body has a site with the body's name at its centre."""
        tendon = spec.add_tendon(
            name=name,
            limited=True,
            range=[0.0, self.loop],
            solref_limit=[-(NATURAL_FREQUENCY**2), -2.0 * NATURAL_FREQUENCY],
            solimp_limit=[IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0],
        )
        for body in (*bodies, bodies[0]):
            tendon.wrap_site(body)
