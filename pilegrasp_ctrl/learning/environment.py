"""The environment: what an agent may do, what it feels, and what it gets for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
from numpy.typing import NDArray

from ..config import Scenario, load_scenario
from ..exceptions import ConfigurationError, PilegraspError
from ..primitives.free_motions import Move
from ..primitives.primitive import Primitive
from ..primitives.retry import BACK_SPEED
from ..programs.attempt import prepare
from ..types import Outcome
from .steps import StepwiseAttempt

PUSH, BACK_OFF, GRASP, LIFT = range(4)
"""Actions: push until the force reaches F_grasp, move back, close the hand or tilt the shovel, lift and end."""

BACK = 0.06
"""Distance of backing off [m]; chosen, about the width of a light sphere."""

MIN_TRAVEL = 0.02
"""Shortest way of a push that is repeated [m]; chosen."""

MAX_STEPS = 12
"""Largest number of primitives of an episode [-]; chosen: five pushes, and what belongs to them."""

FIELDS = (
    ("time", "s", 0.0, 120.0),
    ("way along the push", "m", -1.0, 1.0),
    ("height above touch-down", "m", -1.0, 1.0),
    ("force x", "N", -500.0, 500.0),
    ("force y", "N", -500.0, 500.0),
    ("force z", "N", -500.0, 500.0),
    ("moment x", "N m", -100.0, 100.0),
    ("moment y", "N m", -100.0, 100.0),
    ("moment z", "N m", -100.0, 100.0),
    ("force against the push", "N", -500.0, 500.0),
    ("closure", "1", 0.0, 1.0),
    ("peak force of the last primitive", "N", 0.0, 500.0),
    ("whether the last primitive failed", "1", 0.0, 1.0),
)
"""Entries of an observation: name, unit, smallest and largest value. What lies beyond is cut."""


class GraspEnvironment(gymnasium.Env[NDArray[np.float32], np.int64]):
    """An attempt as an environment: a step is a primitive.

    The observation holds what the arm knows: its own motion and the wrench of the wrist sensor, never the pose of an
    object. The reward is 1 for an object in the hand after the lift, and 0 otherwise.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012  (gymnasium declares it so)
    fields: ClassVar[tuple[tuple[str, str, float, float], ...]] = FIELDS

    def __init__(
        self,
        scenario: str | Path | Scenario = "spheres_wall",
        *,
        overrides: Mapping[str, Any] | None = None,
        max_steps: int = MAX_STEPS,
        render_mode: str | None = None,
    ) -> None:
        """Take the scenario.

        Args:
            scenario: Name, file or `Scenario` whose program is `grasp`.
            overrides: Dotted keys and values on top of a name or file.
            max_steps: Number of primitives after which an episode is truncated.
            render_mode: None; nothing is drawn. `pilegrasp_ctrl.run` makes pages.

        Raises:
            ConfigurationError: The scenario cannot be used.
        """
        if render_mode is not None:
            raise ConfigurationError(f"render_mode = {render_mode!r} is not allowed: an environment draws nothing")
        self._given, self._overrides = scenario, dict(overrides or {})
        self._max_steps, self.render_mode = max_steps, render_mode
        self._scenario({})
        self.action_space = gymnasium.spaces.Discrete(4)
        low, high = (np.array([field[place] for field in FIELDS], dtype=np.float32) for place in (2, 3))
        self.observation_space = gymnasium.spaces.Box(low, high, dtype=np.float32)
        self._running: StepwiseAttempt | None = None
        self._steps = self._seed = 0
        self._origin: NDArray[np.float64] = np.zeros(3)

    def _scenario(self, overrides: Mapping[str, Any]) -> Scenario:
        if isinstance(self._given, Scenario):
            if overrides or self._overrides:
                raise ConfigurationError("overrides need the name or file of a scenario; change the Scenario instead")
            chosen = self._given
        else:
            chosen = load_scenario(self._given, {**self._overrides, **overrides})
        if chosen.program != "grasp":
            raise ConfigurationError(f"program = {chosen.program!r} has no environment; it must be 'grasp'")
        return chosen

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Settle a pile and run the approach.

        Args:
            seed: Seed of pile and sensor noise, as for `run`; drawn from the environment's own numbers if absent.
            options: `{"overrides": {...}}` changes keys for this episode.

        Raises:
            PilegraspError: The scenario cannot be used, or the pile does not settle.
        """
        super().reset(seed=seed)
        self.close()
        drawn = int(self.np_random.integers(2**31)) if seed is None else seed
        self._attempt = prepare(self._scenario((options or {}).get("overrides", {})), drawn)
        self._running = StepwiseAttempt(self._attempt, last="lift")
        self._steps, self._seed, self._origin = 0, drawn, self._running.sample["tool_position"]
        return self._observation(self._running, None), {
            "seed": drawn,
            "config_hash": self._attempt.scenario.config_hash(),
        }

    def step(self, action: np.int64) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Run one primitive.

        Raises:
            ConfigurationError: There is no such action, or the episode is over; call `reset` first.
        """
        running = self._running
        if running is None:
            raise ConfigurationError("the episode has not begun; call reset first")
        if not self.action_space.contains(action):
            raise ConfigurationError(f"action = {action!r} is not allowed: it must be 0 to 3")
        self._steps += 1
        outcome: Outcome | None = None
        info: dict[str, Any] = {"seed": self._seed}
        over = running.result is not None
        try:
            if not over:
                outcome = running.step(self._primitive(int(action), running))
            told = outcome.as_dict() if outcome else {"name": None}
            info |= {"primitive": told.pop("name"), **told}
        except PilegraspError as error:
            info |= {"primitive": None, "error": str(error)}
            over = True
        result = running.result
        if result is not None:
            info |= {"success": result.success, "grasped": result.grasped, "reason": result.reason}
        terminated = over or result is not None
        observation = self._observation(running, outcome)
        reward = float(result is not None and result.success)
        if terminated:
            self.close()
        return observation, reward, terminated, not terminated and self._steps >= self._max_steps, info

    def _primitive(self, action: int, running: StepwiseAttempt) -> Primitive:
        """Return the primitive of an action, with the numbers of the shipped plan."""
        shipped: Any = self._attempt.plan.primitives
        _, push, grasp, lift = shipped
        if action == BACK_OFF:
            return Move(-BACK * np.asarray(push.direction), BACK_SPEED, push.closure, "back_off")
        again: Primitive = replace(push, travel=max(push.travel - max(self._way(running), 0.0), MIN_TRAVEL))
        by_action: dict[int, Primitive] = {PUSH: push if self._steps == 1 else again, GRASP: grasp, LIFT: lift}
        return by_action[action]

    def _way(self, running: StepwiseAttempt) -> float:
        moved = running.sample["tool_position"] - self._origin
        return float(moved @ self._attempt.plan.direction)

    def _observation(self, running: StepwiseAttempt, outcome: Outcome | None) -> NDArray[np.float32]:
        sample = running.sample
        values = [
            sample["time"],
            self._way(running),
            sample["tool_position"][2] - self._origin[2],
            *sample["wrench"],
            sample["push_force"],
            sample["closure"],
            outcome.peak_force if outcome else 0.0,
            float(outcome is not None and outcome.status == "failed"),
        ]
        low, high = (np.array([field[place] for field in FIELDS], dtype=np.float32) for place in (2, 3))
        return np.clip(np.array(values, dtype=np.float32), low, high)

    def close(self) -> None:
        """End the present episode."""
        if self._running is not None:
            self._running.leave()
            self._running = None
