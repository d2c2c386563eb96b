"""The closed loop of an attempt: observation, setpoint, torque, physics."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .analysis.kept_objects import are_held
from .config import Scenario, load_scenario
from .control.saturation_monitor import SaturationMonitor
from .exceptions import ConfigurationError, EnvironmentRefusal
from .kernels.algebra import distance
from .planning.strategy import Plan
from .plugins import adopt
from .primitives.primitive import ActivePrimitive, Ending, Primitive, PrimitiveInput, Setpoint
from .primitives.retry import Composite, run_in_order
from .program_traits import PLAN_PARAMETERS
from .programs.attempt import Attempt, prepare
from .programs.operator import BinState
from .programs.own_plan import PlanParts
from .programs.quiet_loop import no_garbage_collection
from .programs.result import EpisodeResult
from .programs.workplace import Station
from .recorder import FrameFeed, HandWatch, Observer, Recorder, SampleFeed, SampleObserver
from .sim.backend import Backend, check_backend
from .types import Array, Observation, Outcome, Pose, Reference
from .vectors import rotated

Progress = Callable[[float, str], None]
"""Function that is called with the simulated time [s] and the primitive's name."""

LOOP_PARTS = ("observe", "state", "primitive", "control", "record", "step", "check")
"""Parts of a control period, in order: sensors, terms of the arm, events and setpoint of the primitive, torque,
recording and frames, the backend's step, saturation and collisions."""

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
    plan: Callable[[PlanParts], Plan] | None = None,
    progress: Progress | None = None,
    on_frame: Observer | None = None,
    on_sample: SampleObserver | None = None,
) -> EpisodeResult:
    """Run one attempt: build the scene, let the pile settle, approach, push, grasp, lift, judge.

    Args:
        scenario: Name of a scenario that ships, a TOML file, or a `Scenario`.
        seed: Seed of the pile and of the sensor's noise, not negative.
        record: Whether to keep a recording.
        overrides: Dotted keys and values on top of a named scenario or a file.
        plan: Function `plan(parts)` that replaces the scenario's program; its source counts in `config_hash`.
        progress: Function that is called with the simulated time [s] and the primitive's name while the attempt runs.
        on_frame: Function that is called at the times of a recording's frames and at the end of each primitive. The
            simulation waits for it. It must not change anything.
        on_sample: Function that is called with the signals of a recording at the times of its samples, before
            `on_frame`. The simulation waits for it. It must not change anything.

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
    if plan is not None:
        scenario = scenario.model_copy(update={"program": adopt(plan, "plan", PLAN_PARAMETERS, named=True)})
    if not isinstance(seed, int) or seed < 0:
        raise ConfigurationError(f"seed = {seed!r} must be a non-negative integer")
    attempt = prepare(scenario, seed)
    return run_attempt(attempt, record=record, progress=progress, on_frame=on_frame, on_sample=on_sample)


def run_attempt(
    attempt: Attempt,
    backend: Backend | None = None,
    *,
    record: bool = False,
    progress: Progress | None = None,
    on_frame: Observer | None = None,
    on_sample: SampleObserver | None = None,
    on_part: LoopObserver | None = None,
) -> EpisodeResult:
    """Run a prepared attempt, once.

    Args:
        attempt: Attempt that `prepare` returned.
        backend: Robot and scene, at the attempt's start posture; by default `attempt.simulation`.
        record: Whether to keep a recording.
        progress: As for `run`.
        on_frame: As for `run`.
        on_sample: As for `run`.
        on_part: Function that is called after each of `LOOP_PARTS` in every control period, for example to
            measure times. It may read `attempt.simulation` and must not change anything.

    Raises:
        ConfigurationError: The backend lacks a method, or draws nothing although it is to be recorded or shown.
        SimulationError: The simulation leaves the range in which it can be believed.
    """
    simulated = backend is None
    if backend is None:
        backend = attempt.simulation
    else:
        check_backend(backend, drawn=record or on_frame is not None)
    return _Loop(attempt, backend, simulated, record, progress, on_frame, on_sample, on_part or _nothing).run()


def _nothing(part: str) -> None:
    """Ignore the end of a part."""


class _Loop:
    """State of one attempt while it runs; for programs it is the `Runner`."""

    def __init__(
        self,
        attempt: Attempt,
        backend: Backend,
        simulated: bool,
        record: bool,
        progress: Progress | None,
        on_frame: Observer | None,
        on_sample: SampleObserver | None,
        on_part: LoopObserver,
    ) -> None:
        self._attempt, self._backend, self._progress, self._done = attempt, backend, progress, on_part
        self._saturation = SaturationMonitor(attempt.period)
        self._fallbacks = self._limited = 0
        view = backend.view if record or on_frame else None
        self._recorder = Recorder(attempt, view) if record and view is not None else None
        self._frames = FrameFeed(view, on_frame) if on_frame and view is not None else None
        samples = SampleFeed(attempt, on_sample) if on_sample else None
        self._samplers = [sampler for sampler in (self._recorder, samples) if sampler]
        self._feeds = [feed for feed in (self._frames, samples) if feed]
        # A laboratory's camera is not asked in each frame; a simulation's poses cost nothing.
        self._hand = HandWatch() if simulated else None
        self._ticks: list[float] = []
        self._next_progress = 0.0
        self._setpoint = Setpoint(Reference(attempt.plan.start), attempt.plan.closure)
        self._zero = np.zeros(6)
        self._rest_height = backend.object_poses()[:, 2]
        self._overload = ""
        self._attempt_start = 0.0
        self._retreating = False

    def run(self) -> EpisodeResult:
        """Run every primitive until one fails, then judge the attempt."""
        attempt = self._attempt
        start = time.perf_counter()
        with no_garbage_collection():
            self._settle()
            outcomes, grasped, reason = attempt.course.run(self)
        wall_time = time.perf_counter() - start - math.fsum(feed.seconds for feed in self._feeds)
        result = EpisodeResult(
            scenario=attempt.scenario.name,
            seed=attempt.seed,
            config_hash=attempt.scenario.config_hash(),
            success=not reason,
            grasped=grasped,
            reason=reason or "",
            outcomes=tuple(outcomes),
            sim_time=float(self._observation.time),
            wall_time=wall_time,
            tick_times=np.array(self._ticks),
            limited_ticks=self._limited,
            fallback_ticks=self._fallbacks,
            packing_density=attempt.pile.packing_density,
            notes=attempt.notes,
            attempts=tuple(attempt.course.attempts),
            carried=self._carried(outcomes),
        )
        return replace(result, recording=self._recorder.finish(result)) if self._recorder else result

    def run_primitives(self, primitives: Sequence[Primitive | Composite], retreating: bool = False) -> list[Outcome]:
        """Run primitives until one fails. While the arm retreats, an earlier fault does not count again."""
        self._retreating = retreating
        outcomes = run_in_order(primitives, self._run_primitive)
        if outcomes[-1].status == "failed":
            self._overload = ""
        return outcomes

    def begin(self, plan: Plan) -> None:
        """Prepare for an attempt of an order; the hand is empty and at rest."""
        self._attempt_start = float(self._observation.time)
        self._saturation = SaturationMonitor(self._attempt.period)
        self._backend.tare()
        for sampler in self._samplers:
            sampler.signals.push_direction = plan.direction

    def state(self) -> BinState:
        """Return the present state of objects and arm."""
        observation = self._observation
        tool = self._tool_in_scene()
        return BinState(self._backend.object_poses(), tool, observation.q, float(observation.time))

    def tool(self) -> Pose:
        """Return the pose of the tool as the arm knows it, at the joint angles of the last observation."""
        arm = self._attempt.arm
        return arm.update(self._observation.q, np.zeros(arm.nv)).pose

    def exchange(self, station: Station, plan: Plan) -> None:
        """Go on with another station, at rest at the start of `plan`; hold there until fingers and sensor have settled.

        A recording shows the bodies of both. Frames for an observer end here, because their bodies must not change.

        Raises:
            ConfigurationError: The attempt does not run in its own simulation.
        """
        if self._backend is not self._attempt.simulation:
            raise ConfigurationError(
                "hands can be exchanged in the attempt's own simulation alone; leave out the backend"
            )
        station.simulation.set_time(float(self._observation.time))
        arm, simulation, control = station
        self._attempt = replace(self._attempt, arm=arm, simulation=simulation, control=control)
        self._backend, self._frames = simulation, None
        self._setpoint = Setpoint(Reference(plan.start), plan.closure)
        for sampler in self._samplers:
            sampler.exchange(self._attempt, simulation.view)
        self._settle()
        self._saturation = SaturationMonitor(self._attempt.period)

    def _tool_in_scene(self) -> Array:
        """Return the position (3,) of the tool in the scene at the joint angles of the last observation [m]."""
        attempt, pose = self._attempt, self.tool()
        return (attempt.transform_known_to_scene @ pose).translation

    def _settle(self) -> None:
        """Hold the start pose until fingers, friction and the sensor's filter have settled, then tare."""
        attempt, backend, done = self._attempt, self._backend, self._done
        self._torque = attempt.arm.update(backend.observe().q, np.zeros(attempt.arm.nv)).h
        backend.apply(self._torque, self._setpoint.closure)
        for _ in range(round(SETTLING_TIME / attempt.period)):
            backend.step()
            done("step")
            done("check")
            observation = backend.observe()
            done("observe")
            state = attempt.arm.update(observation.q, observation.v)
            done("state")
            # The wrench is left out: nothing touches the hand, and the reading before the tare contains the offset.
            unloaded = Observation(observation.time, observation.q, observation.v)
            self._torque = attempt.control(unloaded, self._setpoint, state).command.torque
            backend.apply(self._torque, self._setpoint.closure)
            done("control")
        self._observation, self._overload = observation, observation.saturated
        backend.tare()

    def _run_primitive(self, primitive: Primitive) -> Outcome:
        """Run a primitive until its own event or a fault ends it."""
        attempt, backend, arm, done = self._attempt, self._backend, self._attempt.arm, self._done
        active: ActivePrimitive | None = None
        travel = peak = 0.0
        fault: str | None = None
        while True:
            observation = backend.observe()
            done("observe")
            tick = time.perf_counter()
            state = arm.update(observation.q, observation.v)
            done("state")
            inputs = PrimitiveInput(observation.time, state.pose, observation.wrench, *observation.touch)
            if active is None:
                active, begun, last = primitive.begin(inputs, self._setpoint), inputs, inputs
                self._zero = inputs.wrench if primitive.tares else self._zero
            travel += distance(inputs.pose.translation, last.pose.translation)
            last = inputs
            peak = max(peak, active.force(inputs))
            ending = active.ending(inputs)
            overload = self._overload or observation.saturated
            saturated = bool(overload) and not self._retreating
            if saturated:
                # A saturated reading is a fault, even if it crossed the primitive's threshold before.
                ending = Ending(f"wrist sensor saturated: {overload}", failed=True)
            late = inputs.time - self._attempt_start > TIME_LIMIT and not self._retreating
            faulty = saturated or (ending is None and bool(fault or late))
            if ending is None and faulty:
                ending = Ending(fault or f"time limit of {TIME_LIMIT:.0f} s", failed=True)
            if ending is not None:
                self._observation = observation
                for sampler in self._samplers:
                    # The last sample shows the reading that ended the primitive.
                    sampler.sample(observation, state, self._setpoint, self._torque, self._zero, always=True)
                if self._frames:
                    self._frames.show(observation.time, primitive.name, always=True)
                status = "failed" if ending.failed else "ended"
                return Outcome(primitive.name, status, ending.trigger, begun.time, inputs.time, travel, peak, faulty)
            self._setpoint = active.setpoint(inputs)
            done("primitive")
            output = attempt.control(observation, self._setpoint, state)
            if output.refused:
                raise EnvironmentRefusal(output.fallback)
            self._ticks.append(time.perf_counter() - tick)
            self._torque = output.command.torque
            self._limited += bool(output.active_limits)
            self._fallbacks += bool(output.fallback)
            backend.apply(self._torque, self._setpoint.closure)
            done("control")
            for sampler in self._samplers:
                sampler.sample(observation, state, self._setpoint, self._torque, self._zero)
            if self._frames:
                self._frames.show(observation.time, primitive.name)
            if self._hand and self._hand.is_due(observation.time):
                to_scene = attempt.transform_known_to_scene
                tool = to_scene.translation + rotated(to_scene.rotation, state.pose.translation)
                self._hand.sample(observation.time, tool, backend.object_poses()[:, :3])
            done("record")
            backend.step()
            done("step")
            if not self._retreating:
                fault = self._saturation.update(output) or backend.find_collision()
            if self._progress and observation.time >= self._next_progress:
                self._next_progress = observation.time + PROGRESS_PERIOD
                self._progress(observation.time, primitive.name)
            done("check")

    def _carried(self, outcomes: list[Outcome]) -> dict[str, Any]:
        """Return counts of what the hand carried; nothing if no simulation tells."""
        if self._hand is None:
            return {}
        return self._hand.count(outcomes, [pick.start for pick in self._attempt.course.attempts])

    def count_held(self, lift_height: float) -> int:
        """Return the number of objects that have come up with the hand, for a lift of `lift_height` [m]."""
        positions = self._backend.object_poses()[:, :3]
        return int(np.count_nonzero(are_held(positions, self._tool_in_scene(), self._rest_height, lift_height)))
