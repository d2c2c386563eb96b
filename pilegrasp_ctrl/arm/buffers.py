"""Pinocchio's buffers, one set for each thread."""

from __future__ import annotations

from threading import local
from typing import Any

import pinocchio as pin

from ..types import Array


class Buffers(local):
    """Buffers of the present thread for one model; a copy or a pickle starts without any.

    Attributes:
        x: Vector of the state that the buffers hold; None before the first one.
    """

    x: Array | None = None
    _data: pin.Data | None = None

    def of(self, model: pin.Model) -> pin.Data:
        """Return the buffers for `model`, always the same one."""
        if self._data is None:
            self._data = model.createData()
        return self._data

    def __reduce__(self) -> tuple[Any, ...]:
        return Buffers, ()
