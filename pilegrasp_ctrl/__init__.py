"""Open-loop grasping from piles: control of the arm, simulation of the pile, and recordings.

Public names are imported on first use, so that `import pilegrasp_ctrl` loads no engine.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .provenance import VERSION

if TYPE_CHECKING:
    from .arm.model import ArmModel as ArmModel
    from .config import Scenario as Scenario
    from .config import load_scenario as load_scenario
    from .control.contact_impedance import ContactImpedanceController as ContactImpedanceController
    from .control.disturbance_observer import DisturbanceObserver as DisturbanceObserver
    from .control.impedance import ImpedanceController as ImpedanceController
    from .control.operational_space import OperationalSpaceController as OperationalSpaceController
    from .episode import run as run
    from .exceptions import ConfigurationError as ConfigurationError
    from .exceptions import ExportError as ExportError
    from .exceptions import ModelError as ModelError
    from .exceptions import PileError as PileError
    from .exceptions import PilegraspError as PilegraspError
    from .exceptions import RecordingError as RecordingError
    from .exceptions import SimulationError as SimulationError
    from .exceptions import SolverError as SolverError
    from .exceptions import UnreachablePoseError as UnreachablePoseError
    from .planning.strategy import Plan as Plan
    from .plant.arm_simulation import ArmSimulation as ArmSimulation
    from .plant.frequency_response import FrequencyResponse as FrequencyResponse
    from .plant.frequency_response import frequency_response as frequency_response
    from .plant.step_response import StepResponse as StepResponse
    from .plant.step_response import step_response as step_response
    from .primitives.primitive import Primitive as Primitive
    from .programs.result import EpisodeResult as EpisodeResult
    from .recording import Recording as Recording
    from .study.run import run_study as run_study
    from .tasks.gains import Impedance as Impedance
    from .tasks.gains import MotionGains as MotionGains
    from .tasks.gains import load_gains as load_gains
    from .tasks.posture_task import PostureTask as PostureTask
    from .trajectories.arc import Arc as Arc
    from .trajectories.straight_line import StraightLine as StraightLine
    from .types import ControllerOutput as ControllerOutput
    from .types import Observation as Observation
    from .types import Pose as Pose
    from .types import Reference as Reference
    from .viewer import write_html as write_html

_MODULES = {
    "Arc": "trajectories.arc",
    "ArmModel": "arm.model",
    "ArmSimulation": "plant.arm_simulation",
    "ConfigurationError": "exceptions",
    "ContactImpedanceController": "control.contact_impedance",
    "ControllerOutput": "types",
    "DisturbanceObserver": "control.disturbance_observer",
    "EpisodeResult": "programs.result",
    "ExportError": "exceptions",
    "FrequencyResponse": "plant.frequency_response",
    "Impedance": "tasks.gains",
    "ImpedanceController": "control.impedance",
    "ModelError": "exceptions",
    "MotionGains": "tasks.gains",
    "Observation": "types",
    "OperationalSpaceController": "control.operational_space",
    "PileError": "exceptions",
    "PilegraspError": "exceptions",
    "Plan": "planning.strategy",
    "Pose": "types",
    "PostureTask": "tasks.posture_task",
    "Primitive": "primitives.primitive",
    "Recording": "recording",
    "RecordingError": "exceptions",
    "Reference": "types",
    "Scenario": "config",
    "SimulationError": "exceptions",
    "SolverError": "exceptions",
    "StepResponse": "plant.step_response",
    "StraightLine": "trajectories.straight_line",
    "UnreachablePoseError": "exceptions",
    "frequency_response": "plant.frequency_response",
    "load_gains": "tasks.gains",
    "load_scenario": "config",
    "run": "episode",
    "run_study": "study.run",
    "step_response": "plant.step_response",
    "write_html": "viewer",
}

__version__ = VERSION


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES[name]}", __name__), name)


def __dir__() -> list[str]:
    return [*_MODULES, "__version__"]
