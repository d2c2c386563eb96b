"""The controller of a scenario, with its gains."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..config import Scenario
from ..control.contact_impedance import ContactImpedanceController
from ..control.operational_space import OperationalSpaceController
from ..exceptions import ConfigurationError
from ..kernels.algebra import multiply
from ..limits.limit import Limit
from ..limits.standard import LIMITS
from ..planning.walls import Wall
from ..primitives.primitive import Setpoint
from ..robots import gains_file
from ..sim.hand import Hand
from ..tasks.gains import Impedance, MotionGains, load_gains
from ..tasks.tool_axes import move_wrench
from ..types import Array, ControllerOutput, Observation
from .keep_clear import keep_clear

Control = Callable[[Observation, Setpoint, ArmState], ControllerOutput]
"""Function that returns the torque for an observation, a setpoint and the arm's state at the observation."""

ControllerFactory = Callable[[ArmModel, Array], Control]
"""Function that makes the controller of an arm with a preferred posture (nv,) [rad]."""


def controller_factory(scenario: Scenario, hand: Hand, walls: Sequence[Wall]) -> ControllerFactory:
    """Read the gains and return a function that makes the controller.

    A wrong file is therefore found before the pile settles, and before the arm and its posture are known. The walls
    count if the scenario says `controller.keep_clear`.

    Raises:
        ConfigurationError: The file of gains cannot be used, or does not fit the controller or the program.
    """
    settings = scenario.controller
    name = settings.kind or hand.controller
    gains = load_gains(settings.gains or gains_file(scenario.robot, name))
    expected = MotionGains if name == "operational_space" else Impedance
    if not isinstance(gains, expected):
        raise ConfigurationError(
            f"{settings.gains}: holds {type(gains).__name__}, but controller.kind = {name!r} takes "
            f"{expected.__name__}; change controller.kind or the table's name"
        )
    if isinstance(gains, MotionGains):
        return _motion_controller(scenario, gains, walls)
    return _impedance_controller(scenario, hand, gains, walls)


def _limits(scenario: Scenario, arm: ArmModel, walls: Sequence[Wall]) -> list[str | Limit]:
    return [*LIMITS, *keep_clear(scenario, arm, walls)] if scenario.controller.keep_clear else [*LIMITS]


def _motion_controller(scenario: Scenario, gains: MotionGains, walls: Sequence[Wall]) -> ControllerFactory:
    settings = scenario.controller

    def make(arm: ArmModel, posture: Array) -> Control:
        limits = _limits(scenario, arm, walls)
        controller = OperationalSpaceController(
            arm, gains, posture, limits=limits, solver=settings.solver, rate=settings.rate
        )
        return lambda observation, setpoint, state: controller.step(observation, setpoint.reference, state=state)

    return make


def _impedance_controller(scenario: Scenario, hand: Hand, gains: Impedance, walls: Sequence[Wall]) -> ControllerFactory:
    settings = scenario.controller
    free = _free_gains(scenario, hand, gains)
    flange_to_tool = hand.transform_tool_to_flange.inverse().translation
    # The delay of the wrist sensor's filter and one control period.
    lag = 0.5 / (math.pi * scenario.sensor.cutoff) + 1.0 / settings.rate

    def make(arm: ArmModel, posture: Array) -> Control:
        controller = ContactImpedanceController.create(
            *(arm, gains, posture, settings.solver, settings.rate),
            free=free,
            wrench_lag=lag,
            limits=_limits(scenario, arm, walls),
        )

        def step(observation: Observation, setpoint: Setpoint, state: ArmState) -> ControllerOutput:
            if gains.inertia is not None:
                # The sensor's wrench is at the flange; this controller needs it at the tool.
                lever = np.empty(3)
                multiply(state.rotation, flange_to_tool, lever)
                wrench = move_wrench(observation.wrench, lever)
                observation = Observation(observation.time, observation.q, observation.v, wrench)
            return controller.step(observation, setpoint.reference, state, setpoint.desired_force)

        return step

    return make


def _free_gains(scenario: Scenario, hand: Hand, gains: Impedance) -> Impedance | None:
    """Return the arm's shipped gains for free motion if the scenario's gains ask for a force; None otherwise."""
    if not gains.desired_force.any():
        return None
    if not scenario.traits.touches or hand.use.normal_force == 0.0:
        raise ConfigurationError(
            f"{scenario.controller.gains}: desired_force has no effect, because hand = '{scenario.hand}' with "
            f"program = '{scenario.program}' never asks for a force; leave it out"
        )
    file = gains_file(scenario.robot, "impedance")
    free = load_gains(file)
    if not isinstance(free, Impedance):
        raise ConfigurationError(f"{file}: holds {type(free).__name__}, but an [impedance] is needed to move the arm")
    return free
