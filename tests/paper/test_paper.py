"""`pilegrasp paper`: its plan, its cost, its errors, and a small real run."""

import json
import re
from graphlib import TopologicalSorter

import pytest

from pilegrasp_ctrl.cli import main
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.programs.attempt import check
from pilegrasp_ctrl.scenarios import FOLDER
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, SHOVEL, grasp, sized, spheres
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import ROBOT, SIMULATED, Experiment, ExperimentCondition
from pilegrasp_ctrl.scenarios.paper.figures_objects import (
    FIG06,
    FIG08,
    STRATEGY_CASES,
    roundness_grid,
    with_other_controller,
)
from pilegrasp_ctrl.scenarios.paper.figures_piles import COUNTS, FIG10, UNSUPPORTED, USUAL_PUSH, VELOCITY_FORCE
from pilegrasp_ctrl.scenarios.paper.ledger import CLAIMS, choose_examples
from pilegrasp_ctrl.scenarios.paper.plan import EXPERIMENTS, count_remaining, find_experiment, plan
from pilegrasp_ctrl.study.attempt import AttemptReport, AttemptRow
from pilegrasp_ctrl.study.store import StudyStore


def test_no_condition_is_refused_before_its_pile_is_made():
    for part in plan(EXPERIMENTS.values()):
        check(part.condition.scenario)


def test_the_papers_numbers_are_the_default():
    for name, experiment in EXPERIMENTS.items():
        for part in experiment.conditions:
            assert part.attempts in (10, ROBOT, SIMULATED)
            assert part.shortened(None) == part.attempts
            if name != "table1" and part.condition != UNSUPPORTED:
                assert (part.attempts == SIMULATED) == (part.condition.scenario.hand == SHOVEL) or name == "fig08"
    assert [part.attempts for part in FIG10.conditions if part.condition == UNSUPPORTED] == [10]


def test_a_shortened_run_makes_at_most_the_attempts_asked_for_and_fewer_in_the_cells_of_a_grid():
    part = ExperimentCondition(grasp("cube"), 50, 0.25)
    assert [part.shortened(n) for n in (None, 1, 2, 20, 1000)] == [50, 1, 1, 5, 50]
    assert ExperimentCondition(grasp("cube"), 20).shortened(20) == 20


def test_the_grids_are_those_of_the_paper():
    assert len(roundness_grid("cube", HAND)) == 16
    assert all(cell.scenario.pile.mass == 0.06 for cell in roundness_grid("cylinder", SHOVEL))
    assert len(STRATEGY_CASES) == 6
    assert {part.condition.scenario.pile.count for part in FIG10.conditions} == {18, *COUNTS}


def test_each_hand_is_also_run_under_the_other_controller():
    for hand, controller in ((HAND, "impedance"), (SHOVEL, "operational_space")):
        assert grasp("light_sphere", hand=hand).scenario.controller.kind != controller
        assert with_other_controller(hand).scenario.controller.kind == controller


def test_equal_conditions_of_several_figures_are_run_once():
    planned = plan([FIG06, FIG08, VELOCITY_FORCE])
    hashes = [part.condition.config_hash for part in planned]
    assert len(hashes) == len(set(hashes))
    shared = grasp("light_sphere").config_hash
    assert [part.experiment for part in planned if part.condition.config_hash == shared] == ["fig06"]
    assert spheres(0.18, "corner").config_hash == USUAL_PUSH.config_hash
    assert sized(0.45).config_hash == grasp("light_sphere", "corner", SHOVEL).config_hash


def test_the_largest_number_of_attempts_asked_for_is_run():
    fewer, more = ExperimentCondition(grasp("cube"), 10), ExperimentCondition(grasp("cube"), 30)
    experiments = [Experiment("x", "", "", (part,), FIG08.draw) for part in (fewer, more)]
    assert [part.attempts for part in plan(experiments)] == [30]


def test_finished_attempts_are_not_missing_and_give_the_expected_cost(tmp_path):
    planned = plan([VELOCITY_FORCE], 3)
    fresh = count_remaining(planned, 7)
    assert (fresh.attempts, fresh.missing) == (6, 6)
    with StudyStore(tmp_path, create=True) as store:
        condition = planned[0].condition
        store.adopt([condition], {})
        store.add([(condition, AttemptReport(condition.config_hash, 8, "{}", None, False, None, 100.0, 100.0, "host"))])
        left = count_remaining(planned, 7, store)
    assert left.missing == 5
    assert left.seconds == pytest.approx(2 * 100.0 + 3 * planned[1].cost())


def test_an_unknown_experiment_is_refused_and_the_known_ones_are_listed(tmp_path, capsys):
    with pytest.raises(ConfigurationError, match="choose from fig06, fig07"):
        find_experiment("fig12")
    assert main(["paper", "fig12", "--out", str(tmp_path)]) == 2
    assert "there is no experiment 'fig12'" in capsys.readouterr().err


def test_a_dry_run_counts_the_attempts_and_writes_nothing(tmp_path, capsys):
    command = ["paper", "all", "--attempts", "20", "--jobs", "2", "--dry-run", "--json", "--out", str(tmp_path / "x")]
    assert main(command) == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert (
        document["attempts"] == document["missing"] == sum(row["attempts"] for row in document["experiments"].values())
    )
    assert set(document["experiments"]) == set(EXPERIMENTS)
    assert "min on 2 processes" in captured.err
    assert not (tmp_path / "x").exists()


def row(seed, success, grasped=1, sim_time=10.0, reason=""):
    result = {"success": success, "grasped": grasped, "sim_time": sim_time, "reason": reason}
    return AttemptRow(grasp("light_sphere").config_hash, seed, {}, result, None)


def test_the_typical_attempt_is_the_median_of_the_commonest_outcome():
    rows = [row(0, True, 2, 30.0), *(row(k, True, 1, 10.0 + k) for k in (1, 2, 3)), row(4, False, 0, 5.0, "no")]
    claim = next(claim for claim in CLAIMS if claim.name == "C1")
    found = choose_examples(claim, Evidence.from_rows(rows, [grasp("light_sphere")]))
    assert [(example.outcome, example.row.seed) for example in found] == [("success", 2), ("failure", 4)]


@pytest.mark.slow
def test_a_real_run_can_be_continued_and_links_its_recordings(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    out = tmp_path / "results"
    command = ["paper", "velocity_force", "--attempts", "1", "--jobs", "2", "--seeds-from", "3", "--json"]
    command += ["--out", str(out)]
    assert main(command) == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    tenth = document["claims"][9]
    assert tenth["verdict"] == "not decided"
    assert [sample["n"] for sample in tenth["conditions"].values()] == [1, 1]
    pages = [file for claim in document["claims"] for file in claim["recordings"].values() if file]
    assert pages
    assert all((out / page).stat().st_size > 10_000 for page in pages)
    with StudyStore(out) as store:
        assert all(
            {"motion", "table_force"} <= attempt.result["measures"].keys()
            for attempt in store.attempts()
            if attempt.result
        )
    assert main(command) == 0
    again = capsys.readouterr()
    assert "0 of them missing" in again.err
    assert json.loads(again.out) == document
    (out / pages[0]).unlink()
    assert main([*command, "--no-recordings"]) == 0
    linked = [file for claim in json.loads(capsys.readouterr().out)["claims"] for file in claim["recordings"].values()]
    assert {*linked} - {None} == {*pages} - {pages[0]}
    assert main([*command[:6], "--seeds-from", "4", *command[8:]]) == 2
    assert "first seed = 3" in capsys.readouterr().err


def test_a_shortened_run_keeps_all_attempts_of_a_cell_that_is_judged_alone():
    planned = {part.condition.config_hash: part.attempts for part in plan([FIG10], 20)}
    for count, attempts in ((5, 20), (10, 10)):
        assert planned[spheres(0.06, "wall", SHOVEL, count).config_hash] == attempts
    assert planned[spheres(0.06, "none", SHOVEL, 5).config_hash] == 10


def test_the_modules_import_one_another_in_one_direction():
    arrows = {}
    for file in (FOLDER / "paper").glob("[!_]*.py"):
        source = file.read_text(encoding="utf-8")
        arrows[file.stem] = set(re.findall(r"scenarios\.paper\.(\w+) import", source))
        for names in re.findall(r"scenarios\.paper import (.*)", source):
            arrows[file.stem].update(names.split(", "))
    assert {"conditions", "run"} <= arrows.keys()
    order = list(TopologicalSorter(arrows).static_order())
    assert order.index("conditions") < order.index("experiment") < order.index("plan") < order.index("run")
