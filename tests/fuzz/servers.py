"""Servers and addresses that are no scheduler: each is answered by one sentence within 15 s."""

from __future__ import annotations

from answering import Responder
from misbehaving_servers import ADDRESSES, SERVERS, serve
from question import Answer, Question
from rule import fault_of

MAX_SERVER_TIME = 15.0
"""Longest time of the answer on the wall clock [s], as promised in docs/cluster.md."""

CASES = (*SERVERS, *ADDRESSES)
"""Names of servers, and texts that are no address."""


def ask_case(responder: Responder, case: str) -> tuple[Question, Answer]:
    """Run a sweep whose scheduler is a server or address by name."""
    if case not in SERVERS:
        question = _question(case.replace("\x00", "?"))
        return question, responder.ask(question)
    with serve(case) as port:
        question = _question(f"tcp://127.0.0.1:{port}")
        return question, responder.ask(question)


def _question(address: str) -> Question:
    return Question("server", ("@cluster", address), patience=60.0)


def fault_of_case(responder: Responder, case: str) -> str | None:
    """Return what is wrong with the answer to a server or address, or None."""
    question, answer = ask_case(responder, case)
    fault = fault_of(question, answer)
    if fault is None and answer.status == 0:
        return "it is taken for a scheduler"
    if fault is None and answer.wall > MAX_SERVER_TIME:
        return f"the answer took {answer.wall:.1f} s"
    return fault
