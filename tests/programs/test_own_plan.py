"""A user's plan: found by name, checked, run, and counted in the configuration's hash; a failed push is tried again."""

import json
from dataclasses import replace

import numpy as np
import pytest

import pilegrasp_ctrl as pg
from command_line import answer
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError, UnreachablePoseError
from pilegrasp_ctrl.plugins import use_plugins
from pilegrasp_ctrl.primitives.guarded_motions import Push
from pilegrasp_ctrl.primitives.retry import Retry, push_again, run_in_order
from pilegrasp_ctrl.program_traits import PROGRAM_TRAITS
from pilegrasp_ctrl.programs.attempt import check, prepare
from pilegrasp_ctrl.programs.registry import PROGRAMS
from pilegrasp_ctrl.types import Outcome

EMPTY = {"pile.count": 0}
HEAD = """
from dataclasses import replace
import numpy as np
from pilegrasp_ctrl import Pose
"""


def with_plan(folder, body, **keys):
    """Return a scenario whose plan has the body `body`."""
    (folder / "mine.py").write_text(f"{HEAD}\ndef plan(parts):\n    {body}\n")
    use_plugins([folder])
    return load_scenario("push_wall", {"program": "mine:plan", **keys})


def down_alone(parts):
    """Come down, and nothing else."""
    shipped = parts.push_plan()
    return replace(shipped, primitives=shipped.primitives[:1])


def test_every_shipped_program_has_traits():
    assert PROGRAMS.keys() == PROGRAM_TRAITS.keys()


def test_a_plan_by_name_runs_like_the_shipped_one_that_it_returns(tmp_path):
    own = pg.run(with_plan(tmp_path, "return parts.push_plan()"))
    shipped = pg.run("push_wall")
    assert own.outcomes == shipped.outcomes
    assert own.success
    assert own.config_hash != shipped.config_hash


def test_a_function_of_the_process_is_a_plan():
    result = pg.run("push_wall", plan=down_alone)
    assert [outcome.name for outcome in result.outcomes] == ["approach"]
    assert result.success
    assert result.config_hash != load_scenario("push_wall").config_hash()


def test_two_plans_of_one_module_are_two_configurations(tmp_path):
    first = with_plan(tmp_path, "return parts.push_plan()\n\ndef plan_2(parts):\n    return parts.grasp_plan()")
    assert first.config_hash() != load_scenario("push_wall", {"program": "mine:plan_2"}).config_hash()


def test_a_plan_that_shall_grasp_fails_without_an_object():
    def plan(parts):
        return replace(down_alone(parts), grasps=True)

    result = pg.run("push_wall", plan=plan)
    assert (result.success, result.reason) == (False, "nothing was in the hand after the lift")


def test_the_hash_follows_the_source_and_the_keys_alone(tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    hashes = []
    for folder, body in ((one, "return parts.push_plan()"), (other, "return parts.push_plan()"), (other, "return 1")):
        folder.mkdir(exist_ok=True)
        hashes.append(with_plan(folder, body).config_hash())
    assert hashes[0] == hashes[1] != hashes[2]
    assert with_plan(other, "return 1", **{"strategy.speed": 0.2}).config_hash() != hashes[2]


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        ("return 1 / 0", r"raised while it planned: ZeroDivisionError: division by zero \(mine.py, line 7\)"),
        ("return None", r"returned None, but it must return a pilegrasp_ctrl\.Plan, as parts\.grasp_plan\(\) does"),
        ("return replace(parts.push_plan(), primitives=())", "returned a plan without primitives"),
        ("return replace(parts.push_plan(), primitives=(3,))", "3, which is no primitive, because it has no name"),
        ("return replace(parts.push_plan(), closure=2.0)", "closure is 2.0; it must be between 0 and 1"),
        ("return replace(parts.push_plan(), direction=np.zeros(2))", "direction is .*; give a unit vector"),
        ("return replace(parts.push_plan(), end=np.zeros(3))", r"are no pilegrasp_ctrl\.Pose"),
    ],
)
def test_what_is_no_plan_is_refused_in_one_sentence(tmp_path, body, sentence):
    scenario = with_plan(tmp_path, body)
    check(scenario)
    with pytest.raises(ConfigurationError, match=rf"^program = 'mine:plan' .*{sentence}") as caught:
        prepare(scenario, 0)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("pose", ["start", "waypoints", "end"])
def test_a_pose_out_of_reach_is_refused_in_one_sentence(tmp_path, pose):
    far = "(Pose([3.0, 0.0, 0.2]),)" if pose == "waypoints" else "Pose([3.0, 0.0, 0.2])"
    scenario = with_plan(tmp_path, f"return replace(parts.push_plan(), {pose}={far})")
    with pytest.raises(UnreachablePoseError, match=r"program = 'mine:plan'.*cannot reach \(3\.00, 0\.00, 0\.20\)"):
        prepare(scenario, 0)


def test_a_primitive_that_raises_ends_the_attempt_in_one_sentence(tmp_path):
    body = "return replace(parts.push_plan(), primitives=(Broken(),))"
    (tmp_path / "mine.py").write_text(
        f"{HEAD}\nclass Broken:\n    name, tares = 'broken', True\n    def begin(self, inputs, last):\n"
        f"        raise KeyError('x')\n\ndef plan(parts):\n    {body}\n"
    )
    use_plugins([tmp_path])
    with pytest.raises(ConfigurationError, match=r"raised while it ran: KeyError: 'x' \(mine.py, line 9\)"):
        pg.run("push_wall", overrides={"program": "mine:plan"})


def test_the_command_line_takes_the_folder_of_a_plan(tmp_path, capsys):
    with_plan(tmp_path, "return parts.push_plan()")
    use_plugins([])
    command = ["run", "push_wall", "--set", "program=mine:plan", "--json"]
    status, _, error = answer(capsys, *command)
    assert status == 2
    assert "program = 'mine:plan': no module 'mine' is in the installed packages; name its folder by --plugins" in error
    status, out, _ = answer(capsys, *command, "--plugins", tmp_path)
    assert (status, json.loads(out)["success"]) == (0, True)


def test_a_word_that_is_no_program_is_refused_with_those_that_are():
    with pytest.raises(ConfigurationError, match=r"must be 'grasp', 'push', 'line', 'order', 'swap', or your own plan"):
        load_scenario("push_wall", {"program": "pusch"})


def push(travel=0.3):
    return Push(np.array([1.0, 0.0, 0.0]), 0.1, 17.0, travel, 0.006, 0.0, 0.3)


class Loop:
    """A loop in which primitives end as a script says: "ended", "failed" or "fault"."""

    def __init__(self, *script):
        self.script, self.run = list(script), []

    def __call__(self, primitive):
        self.run.append((primitive.name, getattr(primitive, "travel", None)))
        word = self.script.pop(0)
        status = "ended" if word == "ended" else "failed"
        return Outcome(primitive.name, status, word, 0.0, 1.0, 0.0, 0.0, word == "fault")


@pytest.mark.parametrize(
    ("script", "names"),
    [
        (["ended"], ["push"]),
        (["failed", "ended", "ended"], ["push", "back_off", "push"]),
        (["failed", "ended", "failed", "ended", "failed"], ["push", "back_off", "push", "back_off", "push"]),
        (["fault"], ["push"]),
        (["failed", "fault"], ["push", "back_off"]),
    ],
)
def test_a_failed_push_backs_off_and_pushes_again_as_often_as_it_may(script, names):
    loop = Loop(*script)
    outcomes = run_in_order([push_again(push(), 0.06, tries=3)], loop)
    assert [outcome.name for outcome in outcomes] == names
    assert not loop.script
    # The second push covers the distance of backing off, so that it ends where the first one did.
    assert all(travel in (0.06, None) for _, travel in loop.run[1:])


def test_what_follows_runs_only_after_a_try_that_did_not_fail():
    for last, names in (("ended", ["push", "push", "after"]), ("failed", ["push", "push"])):
        loop = Loop("failed", last, "ended")
        after = replace(push(), name="after")
        outcomes = run_in_order([Retry(push(), (push(),)), after], loop)
        assert [outcome.name for outcome in outcomes] == names
