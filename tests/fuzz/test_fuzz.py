"""Whatever a file or command line says, the program answers in order: a result, or one sentence, in time.

A few inputs of each kind are drawn here; `make fuzz` draws thousands. What once failed is asked again from `corpus/`.
"""

import contextlib
import os
import signal
from dataclasses import replace
from pathlib import Path

import pytest

from answering import Responder
from kinds import KINDS, judge
from question import SPECIAL, Answer, Question
from rule import fault_of
from signals import Trial, fault_of_trial
from table import draw, main

CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.json"))
FEW = 8
QUICK = [kind for kind in KINDS if kind != "corner"]
GOOD = Answer(2, "", "error: no scenario is called 'a'\n", False, 0.1, 0.1, 0, (), ())


@pytest.fixture(scope="module")
def responder():
    with Responder() as found:
        yield found


@pytest.mark.parametrize("kind", QUICK)
def test_drawn_inputs_are_answered_well(responder, kind):
    questions = draw(kind, 0, FEW)
    for question in (next(questions) for _ in range(FEW)):
        answer = responder.ask(question)
        assert judge(question, answer) is None, f"{question.to_json()}\n{answer}"


@pytest.mark.parametrize("file", CORPUS, ids=lambda file: file.stem)
def test_what_once_failed_is_answered_well(responder, file):
    question = Question.from_json(file.read_text())
    answer = responder.ask(question)
    assert judge(question, answer) is None, answer


@pytest.mark.slow
def test_an_attempt_in_a_corner_of_the_documented_ranges_ends_in_order(responder):
    corners = draw("corner", 0, 2)
    for question in (next(corners) for _ in range(2)):
        answer = responder.ask(question)
        assert judge(question, answer) is None, f"{question.files}\n{answer}"


@pytest.mark.slow
@pytest.mark.parametrize(
    "trial",
    [Trial("list", signal.SIGINT, 0.1), Trial("run", signal.SIGTERM, 1.2), Trial("sweep", signal.SIGINT, 3.0)],
    ids=lambda trial: f"{trial.command}-{trial.signal.name}",
)
def test_a_signal_at_any_moment_leaves_nothing_half_done(trial):
    assert fault_of_trial(trial) is None


ASKED = Question("command line", ("run", "a"), writes=("study",))


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({}, None),
        ({"status": 0, "err": "", "out": "done"}, None),
        ({"changed": ("study/study.db",)}, None),
        ({"status": None}, "no answer in"),
        ({"status": -11}, "ended by signal 11"),
        ({"status": 1}, "status 1"),
        ({"err": "error: internal error (KeyError: 'a')\n"}, "a traceback or an internal error"),
        ({"err": "Traceback (most recent call last):\n"}, "a traceback or an internal error"),
        ({"err": ""}, "status 2 without exactly one line"),
        ({"err": "error: a\nerror: b\n"}, "status 2 without exactly one line"),
        ({"err": "error: a"}, "status 2 without exactly one line"),
        ({"err": f"error: {'a' * 9000}\n"}, "an error of 9008 characters"),
        ({"err": "error: \x1b[31m\n"}, "an error with control characters"),
        ({"out": "a"}, "status 2 with something on standard output"),
        ({"processor": 60.0}, "an error after 60.0 s"),
        ({"memory": 2 << 30}, "2048 MB of memory"),
        ({"left": ("tmp1",)}, "left behind: tmp1"),
        ({"changed": ("a.html",)}, "a.html appeared or changed"),
        ({"status": 0, "err": "x.py:1: RuntimeWarning: divide by zero\n"}, "a warning of Python"),
        ({"status": 0}, "status 0 with an error"),
    ],
)
def test_the_rule_tells_a_good_answer_from_a_bad_one(change, fault):
    found = fault_of(ASKED, replace(GOOD, **change))
    assert found is None if fault is None else fault in found


@pytest.mark.parametrize(
    ("out", "good"), [('{"a": 1}\n', True), ("", False), ("{}\n{}\n", False), ('{"a": NaN}', False)]
)
def test_json_is_one_document(out, good):
    asked = replace(ASKED, call=("list", "--json"))
    assert (fault_of(asked, replace(GOOD, status=0, err="", out=out)) is None) is good


@pytest.mark.parametrize(
    ("call", "status", "part"),
    [
        (("--version",), 0, ""),
        (("run", "nothing.toml"), 2, "no such file"),
        (("run", "free_space_line"), 0, ""),
    ],
)
def test_the_answering_process_answers_as_the_program_does(responder, call, status, part):
    answer = responder.ask(Question("command line", call))
    assert answer.status == status
    assert part in answer.err
    assert answer.accepted is (call == ("run", "free_space_line"))
    assert not Path(f"/proc/{os.getpid()}/cwd/nothing.toml").exists()


def test_a_question_survives_the_corpus(tmp_path):
    files = {"a.toml": b"\xff\x00", **{what.replace("/", "-"): what for what in SPECIAL}}
    question = Question("object file", ("run", "é"), files, ("study",), None, 3.0)
    assert Question.from_json(question.to_json()) == question
    question.lay(tmp_path / "q")
    assert (tmp_path / "q" / "work" / "a.toml").read_bytes() == b"\xff\x00"


def test_the_same_seed_draws_the_same_inputs():
    for kind in QUICK:
        first, second = (draw(kind, 3, 3) for _ in range(2))
        assert [next(first).to_json() for _ in range(3)] == [next(second).to_json() for _ in range(3)]


def test_the_table_counts_and_keeps_what_is_not_answered_well(responder, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("table.Responder", lambda: contextlib.nullcontext(responder))
    faults = iter((None, "too slow", "too slow"))
    monkeypatch.setattr("table.judge", lambda question, answer: next(faults))
    monkeypatch.setattr("sys.argv", ["table.py", "--inputs", "3", "--keep", str(tmp_path / "kept"), "robot"])
    assert main() == 1
    out, err = capsys.readouterr()
    assert "| robot | 3 |" in out
    assert "2 x too slow" in err
    kept = [Question.from_json(file.read_text()) for file in (tmp_path / "kept").glob("*.json")]
    assert {question.kind for question in kept} == {"robot"}
