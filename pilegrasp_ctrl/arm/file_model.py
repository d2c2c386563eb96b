"""What a file says about an arm, whatever its format."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import pinocchio as pin

from ..types import Array


class FileModel(NamedTuple):
    """What a file says about an arm.

    Attributes:
        model: Model with the joints that are kept; its gravity is the file's.
        followers: Joints that follow another one (mimic) -> the joint that they follow.
        friction: Options of `ArmModel` for joint friction -> their values (nv,), where the file has them.
    """

    model: pin.Model
    followers: Mapping[str, str]
    friction: Mapping[str, Array]
