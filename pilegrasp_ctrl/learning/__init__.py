"""Attempts as an environment for gymnasium: an agent decides which primitive comes next. Needs `pilegrasp[gym]`."""

from __future__ import annotations

from ..exceptions import ConfigurationError

try:
    import gymnasium
except ImportError:
    raise ConfigurationError(
        "pilegrasp_ctrl.learning needs gymnasium; install it with `pip install pilegrasp[gym]`"
    ) from None

from .environment import BACK_OFF, FIELDS, GRASP, LIFT, PUSH, GraspEnvironment

__all__ = ["BACK_OFF", "FIELDS", "GRASP", "LIFT", "PUSH", "GraspEnvironment"]

gymnasium.register(id="pilegrasp/Grasp-v0", entry_point=f"{__name__}.environment:GraspEnvironment")
