"""The contact forces of a recording: a list of contacts for each frame, kept as flat arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .exceptions import RecordingError


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """K contacts in F frames; those of frame f are the rows `start[f]` to `start[f + 1]` of the other arrays.

    Attributes:
        start: (F + 1,) int64, from 0 to K, not decreasing.
        bodies: (K, 2) int32, indices of the two bodies in the recording.
        position: (K, 3) [m] in the scene's frame, float32.
        force: (K, 3) [N] in the scene's axes, what the second body does to the first, float32.

    Raises:
        RecordingError: where the arrays do not fit together, an index is negative or a value is not finite.
    """

    start: NDArray[np.int64]
    bodies: NDArray[np.int32]
    position: NDArray[np.float32]
    force: NDArray[np.float32]

    def __post_init__(self) -> None:
        start = _frozen(self.start, np.int64, "start")
        if start.ndim != 1 or not start.size or start[0] != 0 or (np.diff(start) < 0).any():
            raise RecordingError("the contacts' start is not a list of indices that begins at 0 and does not decrease")
        for name, dtype, width in (("bodies", np.int32, 2), ("position", np.float32, 3), ("force", np.float32, 3)):
            array = _frozen(getattr(self, name), dtype, name)
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

    @property
    def frames(self) -> int:
        """Return F."""
        return self.start.size - 1

    def at(self, frame: int) -> slice:
        """Return the rows of one frame."""
        return slice(int(self.start[frame]), int(self.start[frame + 1]))


def _frozen(value: ArrayLike, dtype: type, name: str) -> NDArray[Any]:
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            array: NDArray[Any] = np.array(value).astype(dtype)
            kept = np.issubdtype(dtype, np.floating) or np.array_equal(array, np.asarray(value))
    except (TypeError, ValueError, OverflowError) as error:
        raise RecordingError(f"the contacts' {name} is not an array of numbers") from error
    if not kept or not np.isfinite(array).all():
        raise RecordingError(f"the contacts' {name} holds a value that is not finite or not a whole number")
    array.setflags(write=False)
    return array
