"""Values of newer keys that mean the behaviour before the keys existed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .sections import IFCO_SIZE, IFCO_THICKNESS, ORDER_SIZE, KnownConfig

NEUTRAL_VALUES: dict[tuple[str, str], Any] = {
    ("support", "slope_error_deg"): 0.0,
    ("controller", "keep_clear"): False,
    ("hand_model", "advance"): None,
    ("hand_model", "pad_give"): 1.0,
    ("hand_model", "twist_stiffness"): 1.0,
    **{("known", key): 0.0 for key in KnownConfig.model_fields},
    ("pile", "friction_value"): None,
    ("pile", "mutual_contacts"): True,
    ("sensor", "delay"): 0.0,
    ("strategy", "pushing_hand"): None,
    ("strategy", "force_per_mass"): None,
    ("strategy", "close_on"): "force",
    ("sensor", "slow_drift"): 0.0,
    ("sim", "joint_friction"): 1.0,
    ("sim", "arm_mass"): 1.0,
    ("support", "bin_size"): list(IFCO_SIZE),
    ("support", "bin_wall_heights"): None,
    ("support", "bin_thickness"): list(IFCO_THICKNESS),
    ("support", "bin_position"): None,
    ("support", "bin_yaw_deg"): 0.0,
    ("pile", "frame_position"): None,
    ("pile", "spread"): {"size": 0.0, "mass": 0.0, "friction": 0.0},
    ("order", "operator"): "sees",
    ("order", "crate_size"): list(ORDER_SIZE),
    ("order", "crate_position"): None,
}
"""Values, by (section, key), of keys that were added after the kept study was made. Each value means the behaviour
before the key existed. `config_hash` leaves out a key that has this value, so that the study's hashes stay valid."""


def with_older_meaning(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the complete values of a kept scenario with the keys that did not exist when it was kept.

    A default may have changed since a key was added; a scenario without the key means the behaviour before it.
    """
    found = dict(values)
    for (section, key), value in NEUTRAL_VALUES.items():
        if isinstance(table := found.get(section), dict) and key not in table:
            found[section] = {**table, key: value}
    return found
