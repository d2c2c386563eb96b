"""Where a bin stands, where the crate of an order stands beside it, and where the pile drops. Pure geometry."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..exceptions import ConfigurationError, PileError
from ..sections import IFCO_THICKNESS, OrderConfig, PileConfig, SupportConfig
from ..types import Array
from .crate import Crate

CRATE_GAP = 0.04
"""Gap between the bin and the crate of an order [m]; chosen."""

CRATE_SETBACK = 0.12
"""Distance by which the middle of an order's crate is nearer to the arm than that of the bin [m]; chosen, within easy
reach."""


def place_bin(support: SupportConfig, wall_distance: float, base_radius: float) -> tuple[Crate, float]:
    """Return the bin in the scene's axes, and the yaw of the arm's base in them [rad].

    The scene's x axis runs along the bin's length, so a bin that is turned to the left turns the arm to the right.

    Args:
        support: Size, walls and pose of the bin.
        wall_distance: Distance from the arm's axis to the far wall of a bin whose position is not stated [m].
        base_radius: Radius of the area that the arm's base takes [m].

    Raises:
        ConfigurationError: The bin stands on the arm's base.
    """
    length, width, height = support.bin_size
    x, y = support.bin_position or (wall_distance - 0.5 * length, 0.0)
    if yaw := math.radians(support.bin_yaw_deg):
        cosine, sine = math.cos(yaw), math.sin(yaw)
        x, y = cosine * x + sine * y, cosine * y - sine * x
    heights = support.bin_wall_heights or (height, height, height, height)
    crate = Crate("bin", (x, y), support.bin_size, support.bin_thickness, heights)
    if (distance := crate.distance_to((0.0, 0.0))) < base_radius:
        raise ConfigurationError(
            f"support.bin_size = {[length, width, height]} leaves {1000 * distance:.0f} mm from the arm's axis to the "
            f"bin, and the arm's base takes {1000 * base_radius:.0f} mm; make the bin shorter or move it by "
            "support.bin_position"
        )
    if x - 0.5 * length < 0.0:
        raise ConfigurationError(
            f"support.bin_position = {list(support.bin_position or (x, y))} puts the bin beside or behind the arm; "
            "move it in front of the arm, whose x axis points to it"
        )
    return crate, -yaw


def place_order_crate(order: OrderConfig, bin_crate: Crate) -> Crate:
    """Return the crate that collects an order: where the scenario puts it, or on the left of the bin.

    Raises:
        ConfigurationError: It overlaps the bin.
    """
    thickness = IFCO_THICKNESS
    room = 0.5 * bin_crate.inner[1] + bin_crate.thickness[1] + thickness[1] + 0.5 * order.crate_size[1]
    beside = bin_crate.center[0] - CRATE_SETBACK, bin_crate.center[1] + room + CRATE_GAP
    height = order.crate_size[2]
    crate = Crate("order", order.crate_position or beside, order.crate_size, thickness, (height,) * 4)
    gaps = (
        abs(crate.center[axis] - bin_crate.center[axis])
        - 0.5 * (crate.inner[axis] + bin_crate.inner[axis])
        - crate.thickness[axis]
        - bin_crate.thickness[axis]
        for axis in (0, 1)
    )
    if max(gaps) < 0.0:
        raise ConfigurationError(
            f"order.crate_position = {list(crate.center)} puts the order's crate into the bin; "
            f"at order.crate_position = [{beside[0]:.3g}, {beside[1]:.3g}] it stands beside it"
        )
    return crate


def place_frame(pile: PileConfig, size: float, crate: Crate, corner: bool) -> Array:
    """Return the middle (2,) of the dropping frame in a bin [m].

    The frame touches the middle of the far wall, or lies in the left corner, unless `pile.frame_position` says where.

    Raises:
        PileError: The frame does not fit into the bin.
    """
    length, width, _ = crate.inner
    for side, room in (("width", width), ("length", length)):
        if size > room:
            raise PileError(
                f"the frame of {1000 * size:.0f} mm does not fit into the bin's {side} of {1000 * room:.0f} mm; "
                "lower pile.frame_size or pile.count"
            )
    if pile.frame_position is None:
        return np.array([crate.far - 0.5 * size, crate.center[1] + (0.5 * (width - size) if corner else 0.0)])
    free = 0.5 * (length - size), 0.5 * (width - size)
    if any(abs(offset) > room + 1e-9 for offset, room in zip(pile.frame_position, free, strict=True)):
        raise PileError(
            f"pile.frame_position = {list(pile.frame_position)} puts the frame of {1000 * size:.0f} mm through a wall "
            f"of the bin; it must be within [{free[0]:.3g}, {free[1]:.3g}] of the bin's middle"
        )
    return np.array(crate.center) + np.array(pile.frame_position)


def frame_in_bin(size: float, pile: PileConfig, inner: Sequence[float]) -> float:
    """Return the inner side of the dropping frame in a bin: `size`, or less in a narrow bin unless it is stated [m]."""
    return size if pile.frame_size is not None else min(size, inner[0], inner[1])
