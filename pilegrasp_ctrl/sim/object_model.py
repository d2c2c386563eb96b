"""The model of an object: shape, size, mass, inertia and surface, and its MuJoCo body."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import mujoco
import numpy as np

from ..vectors import norm
from .contact import OBJECT_RANK, Surface, restitution_for_mass
from .hull import Hull
from .net import Net
from .solid import Solid

OBJECT_BIT = 2
"""Contact affinity of the objects, chosen. The arm's links have it as contact type; all other pairs are explicit."""

COLLISION_GROUP = 3
"""MuJoCo's geom group of shapes that only collide; they are not drawn."""

SMOOTH = Surface(lateral=0.25, spinning=0.001, rolling=0.001, restitution=0.72, rank=OBJECT_RANK)
"""Surface of an object whose file states none. Cross (2002, Tables I-II) measured the sliding coefficient 0.25 of
a ball on smooth wood. The 0.001 m are the paper's numbers for the end-effector (V-A)."""

Shape = Literal["sphere", "ellipsoid", "capsule", "cylinder", "box", "mesh"]


@dataclass(frozen=True, slots=True)
class ObjectModel:
    """Model of an object; equal models describe equal objects.

    Attributes:
        name: Name as in `pile.object`.
        shape: Shape of the body.
        half_size: MuJoCo's half sizes [m]: radius; radii; radius and half length (without a capsule's caps); half
            edges; a mesh's half widths.
        mass: Mass [kg].
        inertia_factor: Ratio of the inertia to that of the solid body [-]; a hollow ball has more than 1.
        surface: Friction and restitution.
        bounces_by_mass: Whether the restitution follows from the mass.
        hull: Body of a mesh: its convex hull, or a solid of convex pieces; None for other shapes.
        net: Net that ties groups of the objects together; None without nets.
    """

    name: str
    shape: Shape
    half_size: tuple[float, ...]
    mass: float
    inertia_factor: float
    surface: Surface
    bounces_by_mass: bool = True
    hull: Hull | Solid | None = None
    net: Net | None = None

    @property
    def bounding_radius(self) -> float:
        """Radius of the enclosing sphere about the centre of mass [m]."""
        if self.hull is not None:
            return self.hull.bounding_radius
        if self.shape == "cylinder":
            return float(np.hypot(self.half_size[0], self.half_size[1]))
        if self.shape == "capsule":
            return self.half_size[0] + self.half_size[1]
        return norm(self.half_size) if self.shape == "box" else max(self.half_size)

    @property
    def diameter(self) -> float:
        """Smallest width [m]."""
        return 2.0 * (self.half_size[0] if self.shape == "capsule" else min(self.half_size))

    @property
    def flank_radius(self) -> float:
        """Radius of the upright cylinder about the centre of mass that encloses the modelled object [m]."""
        if self.hull is not None:
            return float(np.linalg.norm(np.array(self.hull.vertices)[:, :2], axis=1).max())
        if self.shape == "box":
            return float(np.hypot(self.half_size[0], self.half_size[1]))
        return max(self.half_size[:2]) if self.shape == "ellipsoid" else self.half_size[0]

    @property
    def volume(self) -> float:
        """Volume of the modelled object [m³]."""
        a, *rest = self.half_size
        if self.hull is not None:
            return self.hull.volume
        if self.shape == "box":
            return 8.0 * a * rest[0] * rest[1]
        if self.shape == "cylinder":
            return 2.0 * math.pi * a**2 * rest[0]
        ball = 4.0 / 3.0 * math.pi
        if self.shape == "capsule":
            return ball * math.pow(a, 3) + 2.0 * math.pi * a**2 * rest[0]
        return ball * a * rest[0] * rest[1] if self.shape == "ellipsoid" else ball * math.pow(a, 3)

    def assign_models(self, count: int) -> list[ObjectModel]:
        """Return the model of each of `count` objects: this one."""
        return [self] * count

    def solid_inertia(self) -> tuple[float, float, float]:
        """Return the principal moments of the homogeneous solid [kg·m²]."""
        m = self.mass
        if self.hull is not None:
            a, b, c = self.hull.moments
            return m * a, m * b, m * c
        if self.shape == "cylinder":
            r, h = self.half_size[0], 2.0 * self.half_size[1]
            across = m * (3.0 * r * r + h * h) / 12.0
            return across, across, 0.5 * m * r * r
        if self.shape == "capsule":
            return _capsule_inertia(m, self.half_size[0], 2.0 * self.half_size[1])
        factor = m / 3.0 if self.shape == "box" else m / 5.0
        a, b, c = self.half_size if len(self.half_size) == 3 else (self.half_size[0],) * 3
        return factor * (b * b + c * c), factor * (a * a + c * c), factor * (a * a + b * b)

    def with_mass(self, mass: float) -> ObjectModel:
        """Return the model with another mass [kg] and the restitution that follows from it."""
        restitution = restitution_for_mass(mass) if self.bounces_by_mass else self.surface.restitution
        return replace(self, mass=mass, surface=replace(self.surface, restitution=restitution))

    def with_sliding_friction(self, value: float | None) -> ObjectModel:
        """Return the model with the sliding friction `value` [-], or the model itself for None."""
        return self if value is None else replace(self, surface=replace(self.surface, lateral=value))

    def with_friction(self, factor: float) -> ObjectModel:
        """Return the model with its sliding, spinning and rolling friction multiplied by `factor`."""
        varied = {name: factor * getattr(self.surface, name) for name in ("lateral", "spinning", "rolling")}
        return replace(self, surface=replace(self.surface, **varied))

    def scaled(self, factor: float) -> ObjectModel:
        """Return the model with its lengths multiplied by `factor`, and with the same mass."""
        return replace(
            self,
            half_size=tuple(factor * size for size in self.half_size),
            hull=self.hull and self.hull.scaled(factor),
            net=self.net and self.net.scaled(factor),
        )

    def geom_names(self, name: str) -> tuple[str, ...]:
        """Return the names of the geoms that touch other bodies, for a body `name`: one, or one for each piece."""
        count = len(self.hull.pieces) if isinstance(self.hull, Solid) else 1
        return (name, *(f"{name}_{number}" for number in range(1, count)))

    def add_to(self, spec: mujoco.MjSpec, index: int, rgba: tuple[float, float, float, float]) -> None:
        """Add a free body `object_{index}` with a geom for each piece, and with a site if a net ties it."""
        name = f"object_{index}"
        # Without `ipos` the centre of mass of an explicit inertia would be at the body's position in the world.
        body = spec.worldbody.add_body(name=name, explicitinertial=True, mass=self.mass, ipos=[0.0, 0.0, 0.0])
        body.inertia = [self.inertia_factor * moment for moment in self.solid_inertia()]
        body.add_freejoint(name=name)
        size = np.zeros(3)
        size[: len(self.half_size)] = self.half_size
        solid = self.hull if isinstance(self.hull, Solid) else None
        if self.hull is not None:
            self.hull.add_to(spec, self.name)
        for number, geom_name in enumerate(self.geom_names(name)):
            geom = body.add_geom(
                name=geom_name,
                type=getattr(mujoco.mjtGeom, f"mjGEOM_{self.shape.upper()}"),
                size=size,
                rgba=rgba,
                contype=0,
                conaffinity=OBJECT_BIT,
            )
            if self.hull is not None:
                geom.meshname = f"{self.name}_{number}" if number else self.name
            if solid and solid.faces:
                geom.group = COLLISION_GROUP
        if solid and solid.faces:
            body.add_geom(
                name=f"{name}_drawn",
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=f"{self.name}_drawn",
                rgba=rgba,
                contype=0,
                conaffinity=0,
            )
        if self.net is not None:
            body.add_site(name=name)
            # MuJoCo scales a tendon's limit in this pose. With all bodies at one point, the limit would have no effect.
            body.pos = self.net.start_position(index, self.flank_radius)


def _capsule_inertia(mass: float, radius: float, length: float) -> tuple[float, float, float]:
    """Return the principal moments [kg·m²] of a cylinder of `length` with half balls, by the parallel axis theorem."""
    cylinder = length / (length + 4.0 * radius / 3.0) * mass
    caps = mass - cylinder
    along = 0.5 * cylinder * radius**2 + 0.4 * caps * radius**2
    # The centre of mass of a half ball is 3/8 of its radius from its flat side.
    across = cylinder * (3.0 * radius**2 + length**2) / 12.0
    across += caps * (0.4 * radius**2 + 0.25 * length**2 + 0.375 * radius * length)
    return across, across, along
