"""The contact forces of a recording: a list of contacts for each frame, kept as flat arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .exceptions import RecordingError


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """K contacts in F frames. The rows `start[f]` to `start[f + 1]` of the other arrays belong to frame f.

    Attributes:
        start: (F + 1,) int64 row indices from 0 to K, not decreasing.
        bodies: (K, 2) int32 indices of the two bodies in the recording.
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
        RecordingError: A value is not a number, is not finite in `dtype`, or is not whole although `dtype` is.
    """
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            array: NDArray[Any] = np.array(value, dtype=dtype)
        whole = np.issubdtype(dtype, np.floating) or np.array_equal(array, np.asarray(value))
    except (TypeError, ValueError, OverflowError) as error:
        raise RecordingError(f"{name} is not an array of numbers") from error
    if not whole:
        raise RecordingError(f"{name} holds a value that is not a whole number")
    if not np.isfinite(array).all():
        raise RecordingError(f"{name} holds a value that is not finite")
    array.setflags(write=False)
    return array
