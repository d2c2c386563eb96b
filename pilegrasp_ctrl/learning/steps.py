"""An attempt that stops between its primitives and waits for the next one."""

from __future__ import annotations

import gc
from collections.abc import Mapping
from dataclasses import replace
from queue import SimpleQueue
from threading import Thread
from typing import Any

from ..episode import run_attempt
from ..primitives.primitive import Primitive
from ..primitives.retry import RunOne
from ..programs.attempt import Attempt
from ..programs.program import SingleCourse
from ..programs.result import EpisodeResult
from ..types import Outcome


class _Left(Exception):  # noqa: N818  (no error: the owner has no further primitive)
    """The owner of the attempt has left it."""


class StepwiseAttempt:
    """An attempt whose loop runs in a thread, one primitive at a time.

    The loop of an attempt calls its plan; an agent calls its environment. The thread turns the one into the other: it
    waits while the owner decides, and the owner waits while a primitive runs. They never run at the same time.

    Attributes:
        sample: Last signals of the attempt, by the names of a recording.
        result: Result at the end; None while the attempt goes on.
    """

    def __init__(self, attempt: Attempt, last: str) -> None:
        """Begin an attempt whose first primitive is that of its plan, and run this primitive.

        Args:
            attempt: Prepared attempt.
            last: Name of the primitive after which the attempt is judged.
        """
        first, *_ = attempt.plan.primitives
        plan = replace(attempt.plan, primitives=(first, self))
        course = SingleCourse(plan, attempt.posture, attempt.scenario.strategy.lift_height)
        self.sample: Mapping[str, Any] = {}
        self.result: EpisodeResult | None = None
        self._attempt, self._last = replace(attempt, course=course), last
        self._collects = gc.isenabled()
        self._primitives: SimpleQueue[Primitive | None] = SimpleQueue()
        self._answers: SimpleQueue[Outcome | BaseException | None] = SimpleQueue()
        self._thread = Thread(target=self._work, name="pilegrasp attempt", daemon=True)
        self._thread.start()
        self._wait()

    def step(self, primitive: Primitive) -> Outcome | None:
        """Run a primitive and return its outcome; `result` is there if it was the last one.

        Raises:
            PilegraspError: The simulation cannot be believed, or a primitive cannot begin.
        """
        self._primitives.put(primitive)
        return self._wait()

    def leave(self) -> None:
        """End the thread; an attempt that goes on has no result."""
        self._primitives.put(None)
        self._thread.join()

    def run(self, run_one: RunOne) -> list[Outcome]:
        """Run the primitives that the owner gives. The loop of the attempt calls this, in the thread."""
        outcomes: list[Outcome] = []
        while True:
            self._answers.put(outcomes[-1] if outcomes else None)
            # The loop pauses the collector of garbage; the owner's own program needs it.
            if self._collects:
                gc.enable()
            primitive = self._primitives.get()
            gc.disable()
            if primitive is None:
                raise _Left
            outcomes.append(run_one(primitive))
            if primitive.name == self._last or outcomes[-1].fault:
                return outcomes

    def _wait(self) -> Outcome | None:
        answer = self._answers.get()
        if isinstance(answer, BaseException):
            raise answer
        return answer

    def _work(self) -> None:
        try:
            self.result = run_attempt(self._attempt, on_sample=self._note)
            self._answers.put(self.result.outcomes[-1])
        except _Left:
            pass
        except BaseException as error:
            self._answers.put(error)

    def _note(self, sample: Mapping[str, Any]) -> None:
        self.sample = sample
