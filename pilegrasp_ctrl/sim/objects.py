"""The objects of the paper's Table I."""

from __future__ import annotations

from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Literal

import mujoco
import numpy as np

from ..exceptions import ConfigurationError
from .surface import Surface

OBJECT_BIT = 2
"""Contact affinity of the objects; the arm's links get it as a contact type, everything else has explicit pairs."""

TENNIS_BALL = Surface(lateral=0.6, spinning=0.001, rolling=0.001, restitution=0.72, rank=1)
"""Cross (2002), Tables I-II: 0.6 on a surface that bites, restitution 0.72 at 60 g. All objects share its friction."""


def restitution_for_mass(mass: float) -> float:
    """Return the paper's line through COR(60 g) = 0.72 and COR(180 g) = 0.37, clipped to [0, 1] (V-A)."""
    return float(np.clip(0.72 + (mass - 0.060) * (0.37 - 0.72) / (0.180 - 0.060), 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class ObjectKind:
    """One kind of object.

    Attributes:
        name: as in `pile.object`.
        shape: sphere, cylinder, box or ellipsoid.
        half_size: MuJoCo's half sizes [m]: radius; radius and half length; half edges; radii.
        mass: [kg].
        inertia_factor: diagonal inertia over that of the solid body; a hollow ball has more.
        surface: friction and restitution.
    """

    name: str
    shape: Literal["sphere", "cylinder", "box", "ellipsoid"]
    half_size: tuple[float, ...]
    mass: float
    inertia_factor: float
    surface: Surface

    @property
    def bounding_radius(self) -> float:
        """Radius of the enclosing sphere [m]."""
        if self.shape == "cylinder":
            return float(np.hypot(self.half_size[0], self.half_size[1]))
        return float(np.linalg.norm(self.half_size) if self.shape == "box" else max(self.half_size))

    @property
    def diameter(self) -> float:
        """Smallest width [m]."""
        return 2.0 * min(self.half_size)

    def solid_inertia(self) -> tuple[float, float, float]:
        """Return the principal moments of the homogeneous solid [kg·m²]."""
        m = self.mass
        if self.shape == "cylinder":
            r, h = self.half_size[0], 2.0 * self.half_size[1]
            across = m * (3.0 * r * r + h * h) / 12.0
            return across, across, 0.5 * m * r * r
        factor = m / 3.0 if self.shape == "box" else m / 5.0
        a, b, c = self.half_size if len(self.half_size) == 3 else (self.half_size[0],) * 3
        return factor * (b * b + c * c), factor * (a * a + c * c), factor * (a * a + b * b)

    def add_to(self, spec: mujoco.MjSpec, index: int, rgba: tuple[float, float, float, float]) -> None:
        """Add a free body `object_{index}` with one geom of the same name."""
        body = spec.worldbody.add_body(name=f"object_{index}", explicitinertial=True, mass=self.mass)
        body.inertia = [self.inertia_factor * moment for moment in self.solid_inertia()]
        body.add_freejoint(name=f"object_{index}")
        size = np.zeros(3)
        size[: len(self.half_size)] = self.half_size
        body.add_geom(
            name=f"object_{index}",
            type=getattr(mujoco.mjtGeom, f"mjGEOM_{self.shape.upper()}"),
            size=size,
            rgba=rgba,
            contype=0,
            conaffinity=OBJECT_BIT,
        )


def _kind(name: str, shape: str, half_size: tuple[float, ...], mass: float, inertia_factor: float = 1.0) -> ObjectKind:
    surface = replace(TENNIS_BALL, restitution=restitution_for_mass(mass))
    return ObjectKind(name, shape, half_size, mass, inertia_factor, surface)  # type: ignore[arg-type]


KINDS = {
    kind.name: kind
    for kind in (
        # Table I prints r = 27 mm, which only makes sense as half of the 54 mm diameter; hollow: I = 0.55 m r² (Cross).
        _kind("light_sphere", "sphere", (0.027,), 0.060, inertia_factor=0.55 / 0.4),
        _kind("heavy_sphere", "sphere", (0.027,), 0.180),
        _kind("cylinder", "cylinder", (0.020, 0.025), 0.045),
        _kind("cube", "box", (0.0225, 0.0225, 0.0225), 0.065),
        _kind("apple", "ellipsoid", (0.035, 0.035, 0.032), 0.168),
    )
}


def object_kind(name: str, mass: float | None = None, scale: float = 1.0) -> ObjectKind:
    """Return a kind by name, with another mass [kg] (and the restitution that goes with it) or size where given.

    Raises:
        ConfigurationError: for an unknown name; lists the known ones or suggests the nearest.
    """
    if name not in KINDS:
        close = get_close_matches(name, KINDS, n=1)
        remedy = f"did you mean {close[0]!r}?" if close else f"choose from {', '.join(KINDS)}"
        raise ConfigurationError(f"pile.object = {name!r} is not known; {remedy}")
    kind = KINDS[name]
    if mass is not None:
        kind = replace(kind, mass=mass, surface=replace(kind.surface, restitution=restitution_for_mass(mass)))
    return replace(kind, half_size=tuple(scale * size for size in kind.half_size))
