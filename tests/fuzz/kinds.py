"""The kinds of inputs that are fuzzed, and how an answer to each is judged."""

from __future__ import annotations

from hypothesis import strategies as st

import command_inputs
import file_inputs
import scenario_inputs
from question import Answer, Question
from rule import MAX_REFUSAL_TIME, fault_of

KINDS: dict[str, st.SearchStrategy[Question]] = {
    "scenario file": scenario_inputs.scenario_files(),
    "object file": scenario_inputs.object_inputs(),
    "gains file": scenario_inputs.gains_files(),
    "robot": file_inputs.robots(),
    "hand": file_inputs.hands(),
    "recording": file_inputs.recordings(),
    "study": file_inputs.studies(),
    "cache": file_inputs.caches(),
    "command line": command_inputs.command_lines(),
    "corner": scenario_inputs.corners(),
}
"""Strategy of each kind of input."""


def judge(question: Question, answer: Answer) -> str | None:
    """Return what is wrong with an answer, or None; a damaged cache must also change no result."""
    fault = fault_of(question, answer)
    if question.kind == "corner" and answer.status == 2 and answer.processor > MAX_REFUSAL_TIME:
        fault = None  # an attempt may end in an error after a while, as for a pile that does not settle
    if fault is None and question.kind == "cache" and answer.out != file_inputs.settled_pile():
        return f"the pile of a damaged cache is another one: {answer.out or answer.err:.200}"
    return fault
