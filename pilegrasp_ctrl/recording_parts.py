"""The parts of a recording: shapes, bodies and contacts, each checked when it is made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .exceptions import RecordingError

ROLES = ("arm", "hand", "object", "support", "sensor")
"""Roles of a body."""

SIZE_LENGTH = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3, "plane": 2, "mesh": 3}
"""Number of entries of `Shape.size` by `Shape.kind`."""

MAX_NAME = 300
"""Longest name of a body [characters]; chosen."""

MAX_TRIANGLES = 20_000
"""Largest number of triangles of a recorded mesh [-]; chosen: a page of more is slow to open."""

UNIT_TOLERANCE = 1e-3
"""Largest deviation of a quaternion's norm from 1 [-]; chosen above the rounding of float32."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A geometric primitive that is fixed to a body.

    Attributes:
        kind: Name of the primitive: sphere, capsule, cylinder, box, ellipsoid or plane; or mesh.
        size: Half sizes as in MuJoCo [m]: sphere (radius), capsule and cylinder (radius, half length along the local z
            axis, without the caps), box (half extents), ellipsoid (radii), plane (half extents along x and y; 0 for an
            unbounded plane), mesh (half extents of a box about the shape's origin). Further entries are dropped.
        position: (3,) position in the body's frame [m].
        quaternion: (4,) rotation of the shape to the body, wxyz.
        rgba: (4,) colour, in 0..1.
        vertices: (n, 3) vertices of a mesh, in the shape's frame [m]; empty for primitives.
        faces: (m, 3) indices of the vertices of each triangle, anticlockwise seen from outside.

    Raises:
        RecordingError: The kind is unknown, a length is wrong, or a value is not finite or out of range.
    """

    kind: str
    size: Sequence[float]
    position: Sequence[float] = (0.0, 0.0, 0.0)
    quaternion: Sequence[float] = (1.0, 0.0, 0.0, 0.0)
    rgba: Sequence[float] = (0.7, 0.7, 0.7, 1.0)
    vertices: Sequence[Sequence[float]] = ()
    faces: Sequence[Sequence[int]] = ()

    def __post_init__(self) -> None:
        length = SIZE_LENGTH.get(self.kind) if isinstance(self.kind, str) else None
        if length is None:
            raise RecordingError(f"a shape's kind is {self.kind!r}; it must be one of {', '.join(SIZE_LENGTH)}")
        try:
            size = _finite_tuple(tuple(self.size)[:length], length, f"the size of a {self.kind}")
        except TypeError as error:
            raise RecordingError(f"the size of a {self.kind} is {self.size!r}; numbers are expected") from error
        if min(size) < 0.0 or (min(size) == 0.0 and self.kind != "plane"):
            raise RecordingError(f"the size of a {self.kind} is {list(size)}; it must be positive")
        rgba = _finite_tuple(self.rgba, 4, "a shape's rgba")
        if min(rgba) < 0.0 or max(rgba) > 1.0:
            raise RecordingError(f"a shape's rgba is {list(rgba)}; it must lie in 0..1")
        if self.kind == "mesh" or len(self.vertices) or len(self.faces):
            vertices, faces = _mesh(self.kind, self.vertices, self.faces)
            object.__setattr__(self, "vertices", vertices)
            object.__setattr__(self, "faces", faces)
        object.__setattr__(self, "size", size)
        object.__setattr__(self, "position", _finite_tuple(self.position, 3, "a shape's position"))
        object.__setattr__(self, "quaternion", _unit_quaternion(self.quaternion, "a shape's quaternion"))
        object.__setattr__(self, "rgba", rgba)

    def as_dict(self) -> dict[str, Any]:
        """Return the attributes for a file; a primitive has no vertices."""
        names = SHAPE_KEYS if self.kind == "mesh" else SHAPE_KEYS[:5]
        return {name: getattr(self, name) for name in names}

    def half_extents(self) -> tuple[float, float, float]:
        """Return the half extents [m] of the box around the shape, in the shape's own axes."""
        match self.kind:
            case "sphere":
                return (self.size[0],) * 3
            case "capsule":
                return (self.size[0], self.size[0], self.size[0] + self.size[1])
            case "cylinder":
                return (self.size[0], self.size[0], self.size[1])
            case "plane":
                return (self.size[0], self.size[1], 0.0)
        return (self.size[0], self.size[1], self.size[2])


SHAPE_KEYS = ("kind", "size", "position", "quaternion", "rgba", "vertices", "faces")
"""Attributes of a `Shape` in the order in which a file holds them."""


@dataclass(frozen=True, slots=True)
class Body:
    """A rigid body with its shapes.

    Attributes:
        name: Name of the body.
        role: Role of the body: arm, hand, object, support or sensor.
        shapes: Shapes fixed to the body.

    Raises:
        RecordingError: The name is empty or too long, the role is unknown, or an entry of `shapes` is not a Shape.
    """

    name: str
    role: str
    shapes: tuple[Shape, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise RecordingError(f"a body's name is {self.name!r}; it must be a non-empty text")
        if len(self.name) > MAX_NAME:
            raise RecordingError(f"a body's name has {len(self.name)} characters; at most {MAX_NAME} are allowed")
        if self.role not in ROLES:
            raise RecordingError(
                f"the role of body {self.name!r} is {self.role!r}; it must be one of {', '.join(ROLES)}"
            )
        shapes = tuple(self.shapes)
        if not all(isinstance(shape, Shape) for shape in shapes):
            raise RecordingError(f"the shapes of body {self.name!r} are not all of type Shape")
        object.__setattr__(self, "shapes", shapes)


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """K contacts in F frames, kept as flat arrays.

    The rows `start[f]` to `start[f + 1]` of the other arrays belong to frame f.

    Attributes:
        start: (F + 1,) non-decreasing row indices from 0 to K, int64.
        bodies: (K, 2) indices of the two bodies in the recording, int32.
        position: (K, 3) contact points in the scene's frame, float32 [m].
        force: (K, 3) forces of the second body on the first, in the scene's axes, float32 [N].

    Raises:
        RecordingError: The arrays do not fit together, an index is negative, or a value is not finite.
    """

    start: NDArray[np.int64]
    bodies: NDArray[np.int32]
    position: NDArray[np.float32]
    force: NDArray[np.float32]

    def __post_init__(self) -> None:
        start = finite_array(self.start, np.int64, "the contacts' start")
        if start.ndim != 1 or not start.size or start[0] != 0 or (np.diff(start) < 0).any():
            raise RecordingError("the contacts' start is not a list of indices that begins at 0 and does not decrease")
        for name, dtype, width in (("bodies", np.int32, 2), ("position", np.float32, 3), ("force", np.float32, 3)):
            array = finite_array(getattr(self, name), dtype, f"the contacts' {name}")
            if array.size == 0:
                array = array.reshape(-1, width)
            if array.shape != (start[-1], width):
                raise RecordingError(
                    f"the contacts' {name} has shape {array.shape}; {(int(start[-1]), width)} is expected"
                )
            object.__setattr__(self, name, array)
        if (self.bodies < 0).any():
            raise RecordingError("the contacts' bodies hold a negative index")
        object.__setattr__(self, "start", start)

    def __repr__(self) -> str:
        return f"Contacts({len(self.force)} contacts in {self.frames} frames)"

    @property
    def frames(self) -> int:
        """Number of frames F."""
        return self.start.size - 1

    def at(self, frame: int) -> slice:
        """Return the rows of one frame."""
        return slice(int(self.start[frame]), int(self.start[frame + 1]))


def finite_array(value: ArrayLike, dtype: type, name: str) -> NDArray[Any]:
    """Return a read-only copy of `value`.

    Args:
        value: Numbers.
        dtype: Type of the numbers in the copy.
        name: Name of the array in an error.

    Raises:
        RecordingError: A value is not a number, is not finite in `dtype`, or is not an integer for an integer `dtype`.
    """
    try:
        given = np.asarray(value)
        if given.dtype.kind not in "biuf":  # texts and complex numbers would be converted
            raise TypeError
        with np.errstate(over="ignore", invalid="ignore"):
            array: NDArray[Any] = np.array(given, dtype=dtype)
        whole = np.issubdtype(dtype, np.floating) or np.array_equal(array, given)
    except (TypeError, ValueError, OverflowError) as error:
        raise RecordingError(f"{name} is not an array of numbers") from error
    if not whole:
        raise RecordingError(f"{name} holds a value that is not a whole number")
    if not np.isfinite(array).all():
        raise RecordingError(f"{name} holds a value that is not finite")
    array.setflags(write=False)
    return array


def _finite_tuple(value: Any, length: int, name: str) -> tuple[float, ...]:
    """Return `length` finite floats; `name` is that of the value in an error."""
    try:
        numbers = tuple(float(x) for x in value)
    except (TypeError, ValueError) as error:
        raise RecordingError(f"{name} is {value!r}; {length} numbers are expected") from error
    if len(numbers) != length or not all(map(math.isfinite, numbers)):
        raise RecordingError(f"{name} is {list(numbers)}; {length} finite numbers are expected")
    return numbers


def _unit_quaternion(value: Any, name: str) -> tuple[float, ...]:
    numbers = _finite_tuple(value, 4, name)
    if abs(math.hypot(*numbers) - 1.0) > UNIT_TOLERANCE:
        raise RecordingError(f"{name} is {list(numbers)}, which is not a unit quaternion (wxyz)")
    return numbers


def _mesh(kind: str, vertices: Any, faces: Any) -> tuple[tuple[tuple[float, ...], ...], tuple[tuple[int, ...], ...]]:
    """Return the checked vertices and faces of a mesh."""
    if kind != "mesh":
        raise RecordingError(f"a {kind} has vertices or faces; only a mesh has them")
    try:
        points = finite_array(vertices, np.float64, "the vertices of a mesh")
        triangles = np.asarray(faces)
    except (TypeError, ValueError) as error:
        raise RecordingError("the vertices or faces of a mesh are not lists of three numbers each") from error
    if points.ndim != 2 or points.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
        raise RecordingError("the vertices or faces of a mesh are not lists of three numbers each")
    if len(triangles) > MAX_TRIANGLES:
        raise RecordingError(f"a mesh has {len(triangles)} triangles; at most {MAX_TRIANGLES} are allowed")
    if triangles.dtype.kind not in "iu" or triangles.min() < 0 or triangles.max() >= len(points):
        raise RecordingError("a face of a mesh names a vertex that it does not have")
    return tuple(map(tuple, points.tolist())), tuple(map(tuple, triangles.tolist()))
