"""The one rule that decides whether the program answered well."""

from __future__ import annotations

import json

from question import Answer, Question

MAX_SENTENCE = 4000
"""Longest error on standard error [characters] (chosen): a list of all keys fits, a file that is echoed does not."""

MAX_REFUSAL_TIME = 10.0
"""Most processor time that an error may take [s] (chosen); imports are done before."""

MAX_MEMORY = 1 << 30
"""Most memory that an answer may take [bytes] (chosen)."""

STATUSES = (0, 2)
"""Exit statuses of a command that nobody interrupts."""


def fault_of(question: Question, answer: Answer) -> str | None:
    """Return what is wrong with an answer, or None if it is well.

    Well is: status 0, and then what was asked for; or status 2 and one sentence. Neither leaves anything behind that
    was not asked for, takes long or much memory, or shows a traceback.
    """
    if answer.status is None:
        return f"no answer in {answer.wall:.0f} s"
    if answer.status < 0:
        return f"the process was ended by signal {-answer.status}"
    if answer.status not in STATUSES:
        return f"status {answer.status}"
    for text in (answer.err, answer.out):
        if "Traceback" in text or "internal error" in text:
            return f"a traceback or an internal error: {text[-300:]}"
    if "Warning:" in answer.err:
        return f"a warning of Python: {answer.err[:300]}"
    if answer.left:
        return f"left behind: {', '.join(answer.left)}"
    if answer.memory > MAX_MEMORY:
        return f"{answer.memory >> 20} MB of memory"
    return _fault_of_error(question, answer) if answer.status == 2 else _fault_of_success(question, answer)


def _fault_of_error(question: Question, answer: Answer) -> str | None:
    lines = answer.err.splitlines()
    if len(lines) != 1 or not answer.err.endswith("\n") or not lines[0].startswith("error: "):
        return f"status 2 without exactly one line of error: {answer.err[:300]!r}"
    if len(answer.err) > MAX_SENTENCE:
        return f"an error of {len(answer.err)} characters: {answer.err[:200]!r}"
    if not lines[0].isprintable():
        return f"an error with control characters: {lines[0][:300]!r}"
    if answer.out:
        return f"status 2 with something on standard output: {answer.out[:200]!r}"
    if answer.processor > MAX_REFUSAL_TIME:
        return f"an error after {answer.processor:.1f} s of processor time: {answer.err[:200]}"
    extra = [path for path in answer.changed if not path.startswith(question.writes or ("\0",))]
    return f"status 2 and {', '.join(extra)} appeared or changed" if extra else None


def _fault_of_success(question: Question, answer: Answer) -> str | None:
    if "--json" in question.call and not answer.accepted:
        try:
            json.loads(answer.out, parse_constant=_no_constant)
        except ValueError:
            return f"--json did not print one JSON document: {answer.out[:200]!r}"
    if "error:" in answer.err:
        return f"status 0 with an error: {answer.err[:300]!r}"
    return None


def _no_constant(text: str) -> None:
    raise ValueError(f"{text} is no JSON")
