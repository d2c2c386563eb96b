"""Open-loop grasping from piles: control of the arm, simulation of the pile, and recordings.

Public names are imported on first use, so that `import pilegrasp_ctrl` loads no engine.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .arm.capsule import Capsule as Capsule
    from .arm.capsules import capsules_of as capsules_of
    from .arm.model import ArmModel as ArmModel
    from .config import Scenario as Scenario
    from .config import load_scenario as load_scenario
    from .control.contact_impedance import ContactImpedanceController as ContactImpedanceController
    from .control.disturbance_observer import DisturbanceObserver as DisturbanceObserver
    from .control.impedance import ImpedanceController as ImpedanceController
    from .control.inverse_dynamics import InverseDynamics as InverseDynamics
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
    from .limits.acceleration_limit import AccelerationLimit as AccelerationLimit
    from .limits.collision_limit import CollisionLimit as CollisionLimit
    from .limits.limit import Bounds as Bounds
    from .limits.limit import Limit as Limit
    from .limits.motion_limits import PositionLimit as PositionLimit
    from .limits.motion_limits import VelocityLimit as VelocityLimit
    from .limits.obstacles import Box as Box
    from .limits.obstacles import Plane as Plane
    from .limits.standard import limits_of as limits_of
    from .limits.torque_limit import TorqueLimit as TorqueLimit
    from .limits.torque_limit import TorqueRateLimit as TorqueRateLimit
    from .planning.strategy import Plan as Plan
    from .plant.arm_simulation import ArmSimulation as ArmSimulation
    from .plant.frequency_response import FrequencyResponse as FrequencyResponse
    from .plant.frequency_response import frequency_response as frequency_response
    from .plant.step_response import StepResponse as StepResponse
    from .plant.step_response import step_response as step_response
    from .plugins import use_plugins as use_plugins
    from .primitives.primitive import Primitive as Primitive
    from .primitives.retry import Retry as Retry
    from .programs.own_plan import PlanParts as PlanParts
    from .programs.result import EpisodeResult as EpisodeResult
    from .recording import Recording as Recording
    from .study.run import run_study as run_study
    from .tasks.axis_task import AxisTask as AxisTask
    from .tasks.frame_task import FrameTask as FrameTask
    from .tasks.gains import Impedance as Impedance
    from .tasks.gains import MotionGains as MotionGains
    from .tasks.gains import load_gains as load_gains
    from .tasks.impedance_task import ImpedanceTask as ImpedanceTask
    from .tasks.joint_task import CouplingTask as CouplingTask
    from .tasks.joint_task import JointImpedance as JointImpedance
    from .tasks.joint_task import JointTask as JointTask
    from .tasks.posture_task import DampingTask as DampingTask
    from .tasks.posture_task import PostureTask as PostureTask
    from .tasks.relative_frame_task import RelativeFrameTask as RelativeFrameTask
    from .tasks.task import Objective as Objective
    from .tasks.task import Task as Task
    from .trajectories.arc import Arc as Arc
    from .trajectories.straight_line import StraightLine as StraightLine
    from .types import ControllerOutput as ControllerOutput
    from .types import MassProperties as MassProperties
    from .types import Observation as Observation
    from .types import Pose as Pose
    from .types import Reference as Reference
    from .viewer import write_html as write_html

_MODULES = {
    "AccelerationLimit": "limits.acceleration_limit",
    "Arc": "trajectories.arc",
    "ArmModel": "arm.model",
    "ArmSimulation": "plant.arm_simulation",
    "AxisTask": "tasks.axis_task",
    "Bounds": "limits.limit",
    "Box": "limits.obstacles",
    "Capsule": "arm.capsule",
    "CollisionLimit": "limits.collision_limit",
    "ConfigurationError": "exceptions",
    "ContactImpedanceController": "control.contact_impedance",
    "ControllerOutput": "types",
    "CouplingTask": "tasks.joint_task",
    "DampingTask": "tasks.posture_task",
    "DisturbanceObserver": "control.disturbance_observer",
    "EpisodeResult": "programs.result",
    "ExportError": "exceptions",
    "FrameTask": "tasks.frame_task",
    "FrequencyResponse": "plant.frequency_response",
    "Impedance": "tasks.gains",
    "ImpedanceController": "control.impedance",
    "ImpedanceTask": "tasks.impedance_task",
    "InverseDynamics": "control.inverse_dynamics",
    "JointImpedance": "tasks.joint_task",
    "JointTask": "tasks.joint_task",
    "Limit": "limits.limit",
    "MassProperties": "types",
    "ModelError": "exceptions",
    "MotionGains": "tasks.gains",
    "Objective": "tasks.task",
    "Observation": "types",
    "OperationalSpaceController": "control.operational_space",
    "PileError": "exceptions",
    "PilegraspError": "exceptions",
    "Plan": "planning.strategy",
    "PlanParts": "programs.own_plan",
    "Plane": "limits.obstacles",
    "Pose": "types",
    "PositionLimit": "limits.motion_limits",
    "PostureTask": "tasks.posture_task",
    "Primitive": "primitives.primitive",
    "Recording": "recording",
    "RecordingError": "exceptions",
    "Reference": "types",
    "RelativeFrameTask": "tasks.relative_frame_task",
    "Scenario": "config",
    "Retry": "primitives.retry",
    "SimulationError": "exceptions",
    "SolverError": "exceptions",
    "StepResponse": "plant.step_response",
    "StraightLine": "trajectories.straight_line",
    "Task": "tasks.task",
    "TorqueLimit": "limits.torque_limit",
    "TorqueRateLimit": "limits.torque_limit",
    "UnreachablePoseError": "exceptions",
    "VelocityLimit": "limits.motion_limits",
    "capsules_of": "arm.capsules",
    "frequency_response": "plant.frequency_response",
    "limits_of": "limits.standard",
    "load_gains": "tasks.gains",
    "load_scenario": "config",
    "run": "episode",
    "run_study": "study.run",
    "step_response": "plant.step_response",
    "use_plugins": "plugins",
    "write_html": "viewer",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module(".provenance", __name__).VERSION
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES[name]}", __name__), name)


def __dir__() -> list[str]:
    return [*_MODULES, "__version__"]
