"""The closed loop of an attempt: observation, setpoint, torque, physics."""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .analysis.kept_objects import NOTHING_HELD, are_held
from .config import Scenario, load_scenario
from .control.saturation_monitor import SaturationMonitor
from .exceptions import ConfigurationError
from .planning.strategy import Plan
from .primitives.primitive import ActivePrimitive, Ending, Primitive, PrimitiveInput, Setpoint
from .programs.attempt import Attempt, prepare
from .programs.pick_order import BinState
from .programs.result import EpisodeResult
from .provenance import versions
from .recorder import Recorder
from .sim.monitors import Watchdog
from .sim.readout import FrameFeed, Observer
from .types import Observation, Outcome, Reference

Progress = Callable[[float, str], None]
"""Function that is called with the simulated time [s] and the primitive's name."""

LOOP_PARTS = ("observe", "state", "primitive", "control", "record", "step", "check")
"""Parts of a control period, in their order: sensors; terms of the arm; events and setpoint of the primitive; torque;
recording and frames; physics; watchdog, saturation and rims."""

LoopObserver = Callable[[str], None]
"""Function that is called with the name of each part of a control period after the part."""

PROGRESS_PERIOD = 0.1
"""Simulated time between two calls of the progress function [s]; chosen."""

SETTLING_TIME = 0.5
"""Time for which the arm holds its start pose before the first primitive [s]; chosen. Fingers and sensor settle."""

TIME_LIMIT = 60.0
"""Longest simulated time of an attempt, and of each attempt of an order [s]; chosen."""


def run(
    scenario: str | Path | Scenario,
    *,
    seed: int = 0,
    record: bool = False,
    overrides: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    on_frame: Observer | None = None,
) -> EpisodeResult:
    """Run one attempt: build the scene, let the pile settle, approach, push, grasp, lift, judge.

    Args:
        scenario: Name of a scenario that ships, a TOML file, or a `Scenario`.
        seed: Seed of the pile and of the sensor's noise, not negative.
        record: Whether to keep a recording.
        overrides: Dotted keys and values on top of a named scenario or a file.
        progress: Function that is called with the simulated time [s] and the primitive's name while the attempt runs.
        on_frame: Function that is called at the times of a recording's frames and at the end of each primitive. The
            simulation waits for it. It must not change anything.

    Raises:
        PilegraspError: The scenario cannot be used, a pose is out of reach, the pile does not settle, or the simulation
            leaves the range in which it can be believed.
    """
    if isinstance(scenario, Scenario):
        if overrides:
            raise ConfigurationError(
                "overrides need the name or file of a scenario; call load_scenario(name, overrides) and pass its result"
            )
    else:
        scenario = load_scenario(scenario, overrides)
    if not isinstance(seed, int) or seed < 0:
        raise ConfigurationError(f"seed = {seed!r} must be a non-negative integer")
    return run_attempt(prepare(scenario, seed), record=record, progress=progress, on_frame=on_frame)


def run_attempt(
    attempt: Attempt,
    *,
    record: bool = False,
    progress: Progress | None = None,
    on_frame: Observer | None = None,
    on_part: LoopObserver | None = None,
) -> EpisodeResult:
    """Run a prepared attempt, once.

    Args:
        attempt: Attempt that `prepare` returned.
        record: Whether to keep a recording.
        progress: As for `run`.
        on_frame: As for `run`.
        on_part: Function that is called after each of `LOOP_PARTS` in every control period, for example to
            measure times. It may read `attempt.simulation` and must not change anything.

    Raises:
        SimulationError: The simulation leaves the range in which it can be believed.
    """
    return _Loop(attempt, record, progress, on_frame, on_part or _nothing).run()


def _nothing(part: str) -> None:
    """Ignore the end of a part."""


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Pause the garbage collector: the loop makes no cycles, and a collection takes several control periods."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


class _Loop:
    """State of one attempt while it runs."""

    def __init__(
        self,
        attempt: Attempt,
        record: bool,
        progress: Progress | None,
        on_frame: Observer | None,
        on_part: LoopObserver,
    ) -> None:
        self._attempt, self._progress, self._done = attempt, progress, on_part
        label = f"{attempt.scenario.config_hash()}-{attempt.seed}"
        self._watchdog = Watchdog(label)
        self._saturation = SaturationMonitor(attempt.period)
        self._fallbacks = self._limited = 0
        self._recorder = Recorder(attempt) if record else None
        self._frames = FrameFeed(attempt.simulation, on_frame) if on_frame else None
        self._ticks: list[float] = []
        self._next_progress = 0.0
        self._setpoint = Setpoint(Reference(attempt.plan.start), attempt.plan.closure)
        self._zero = np.zeros(6)
        self._overload = ""
        self._attempt_start = 0.0
        self._retreating = False

    def run(self) -> EpisodeResult:
        """Run every primitive until one fails, then judge the attempt."""
        attempt = self._attempt
        start = time.perf_counter()
        with _no_garbage_collection():
            self._settle()
            if attempt.order:
                outcomes, reason = attempt.order.fill(self._bin_state, self._begin, self._run_primitives)
            else:
                outcomes = self._run_primitives(attempt.plan.primitives)
        wall_time = time.perf_counter() - start - (self._frames.seconds if self._frames else 0.0)
        if attempt.order:
            grasped = sum(pick.delivered for pick in attempt.order.attempts)
        else:
            grasped, reason = self._judge(outcomes)
        result = EpisodeResult(
            scenario=attempt.scenario.name,
            seed=attempt.seed,
            config_hash=attempt.scenario.config_hash(),
            success=not reason,
            grasped=grasped,
            reason=reason or "",
            outcomes=tuple(outcomes),
            sim_time=float(attempt.simulation.data.time),
            wall_time=wall_time,
            tick_times=np.array(self._ticks),
            limited_ticks=self._limited,
            fallback_ticks=self._fallbacks,
            packing_density=attempt.pile.packing_density,
            attempts=tuple(attempt.order.attempts) if attempt.order else (),
        )
        return replace(result, recording=self._recorder.finish(_meta(attempt, result))) if self._recorder else result

    def _run_primitives(self, primitives: Sequence[Primitive], retreating: bool = False) -> list[Outcome]:
        """Run primitives until one fails. While the arm retreats, an earlier fault does not count again."""
        self._retreating = retreating
        outcomes: list[Outcome] = []
        for primitive in primitives:
            outcomes.append(self._run_primitive(primitive))
            if outcomes[-1].status == "failed":
                self._overload = ""
                break
        return outcomes

    def _begin(self, plan: Plan) -> None:
        """Prepare for an attempt of an order; the hand is empty and at rest."""
        simulation = self._attempt.simulation
        self._attempt_start = float(simulation.data.time)
        self._saturation = SaturationMonitor(self._attempt.period)
        simulation.tare()
        if self._recorder:
            self._recorder.push_direction = plan.direction

    def _bin_state(self) -> BinState:
        """Return the state on which the next step of an order depends."""
        simulation = self._attempt.simulation
        poses = simulation.data.qpos[simulation.scene.object_qpos :].reshape(-1, 7).copy()
        q = simulation.data.qpos[: self._attempt.arm.nv].copy()
        tool = self._attempt.arm.update(q, np.zeros(self._attempt.arm.nv)).pose.translation
        return BinState(poses, tool, q, float(simulation.data.time))

    def _settle(self) -> None:
        """Hold the start pose until fingers, friction and the sensor's filter have settled, then tare."""
        attempt, simulation, done = self._attempt, self._attempt.simulation, self._done
        self._torque = attempt.arm.update(simulation.observe().q, np.zeros(attempt.arm.nv)).h
        simulation.apply(self._torque, self._setpoint.closure)
        for _ in range(round(SETTLING_TIME / attempt.period)):
            simulation.step()
            done("step")
            self._watchdog.check(simulation.data)
            done("check")
            observation = simulation.observe()
            done("observe")
            state = attempt.arm.update(observation.q, observation.v)
            done("state")
            # The wrench is left out: nothing touches the hand, and the reading before the tare contains the offset.
            unloaded = Observation(observation.time, observation.q, observation.v)
            self._torque = attempt.control(unloaded, self._setpoint, state).command.torque
            simulation.apply(self._torque, self._setpoint.closure)
            done("control")
        self._overload = observation.saturated
        simulation.tare()

    def _run_primitive(self, primitive: Primitive) -> Outcome:
        """Run a primitive until its own event or a fault ends it."""
        attempt, simulation, arm, done = self._attempt, self._attempt.simulation, self._attempt.arm, self._done
        active: ActivePrimitive | None = None
        travel = peak = 0.0
        fault: str | None = None
        while True:
            observation = simulation.observe()
            done("observe")
            tick = time.perf_counter()
            state = arm.update(observation.q, observation.v)
            done("state")
            inputs = PrimitiveInput(observation.time, state.pose, observation.wrench)
            if active is None:
                active, begun, last = primitive.begin(inputs, self._setpoint), inputs, inputs
                self._zero = inputs.wrench if primitive.tares else self._zero
            travel += math.dist(inputs.pose.translation, last.pose.translation)
            last = inputs
            peak = max(peak, active.force(inputs))
            ending = active.ending(inputs)
            overload = self._overload or observation.saturated
            if overload and not self._retreating:
                # A saturated reading is a fault, even if it crossed the primitive's threshold before.
                ending = Ending(f"wrist sensor saturated: {overload}", failed=True)
            late = inputs.time - self._attempt_start > TIME_LIMIT and not self._retreating
            if ending is None and (fault or late):
                ending = Ending(fault or f"time limit of {TIME_LIMIT:.0f} s", failed=True)
            if ending is not None:
                if self._recorder:
                    # The last sample shows the reading that ended the primitive.
                    self._recorder.sample(observation, state, self._setpoint, self._torque, self._zero, always=True)
                if self._frames:
                    self._frames.show(observation.time, primitive.name, always=True)
                status = "failed" if ending.failed else "ended"
                return Outcome(primitive.name, status, ending.trigger, begun.time, inputs.time, travel, peak)
            self._setpoint = active.setpoint(inputs)
            done("primitive")
            output = attempt.control(observation, self._setpoint, state)
            self._ticks.append(time.perf_counter() - tick)
            self._torque = output.command.torque
            self._limited += bool(output.active_limits)
            self._fallbacks += bool(output.fallback)
            simulation.apply(self._torque, self._setpoint.closure)
            done("control")
            if self._recorder:
                self._recorder.sample(observation, state, self._setpoint, self._torque, self._zero)
            if self._frames:
                self._frames.show(observation.time, primitive.name)
            done("record")
            simulation.step()
            done("step")
            self._watchdog.check(simulation.data)
            if not self._retreating:
                fault = self._saturation.update(output) or attempt.rims.find_collision(simulation.data)
            if self._progress and observation.time >= self._next_progress:
                self._next_progress = observation.time + PROGRESS_PERIOD
                self._progress(observation.time, primitive.name)
            done("check")

    def _judge(self, outcomes: list[Outcome]) -> tuple[int, str | None]:
        """Return the number of objects held and the reason of a failure, if any."""
        attempt = self._attempt
        if outcomes[-1].status == "failed":
            return 0, f"{outcomes[-1].name}: {outcomes[-1].trigger}"
        if attempt.scenario.program != "grasp":
            return 0, None
        simulation = attempt.simulation
        pose = attempt.arm.update(simulation.observe().q, np.zeros(attempt.arm.nv)).pose
        tool = (attempt.transform_known_to_scene @ pose).translation
        lift = attempt.scenario.strategy.lift_height
        positions = simulation.data.xpos[list(simulation.scene.objects)]
        grasped = int(np.count_nonzero(are_held(positions, tool, attempt.pile.poses[:, 2], lift)))
        return grasped, None if grasped else NOTHING_HELD


def _meta(attempt: Attempt, result: EpisodeResult) -> dict[str, Any]:
    """Return the `meta` of the recording."""
    scenario = attempt.scenario
    return {
        "scenario": scenario.name,
        "summary": scenario.summary,
        "seed": attempt.seed,
        "config_hash": result.config_hash,
        "config": scenario.model_dump(mode="json"),
        "hand": scenario.hand,
        "grasp_force": scenario.strategy.grasp_force,
        "success": result.success,
        "grasped": result.grasped,
        "reason": result.reason,
        "outcomes": [outcome.as_dict() for outcome in result.outcomes],
        "packing_density": result.packing_density,
        "attempts": [pick.as_dict() for pick in result.attempts],
        "versions": versions(),
    }
