"""`pilegrasp paper`: its plan, its cost, its errors, and a small real run."""

import json
import re
from graphlib import TopologicalSorter

import pytest

from pilegrasp_ctrl.cli import main
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.hand_folder import parameters
from pilegrasp_ctrl.programs.attempt import check
from pilegrasp_ctrl.scenarios import FOLDER, object_files
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, SHOVEL, grasp, sized, spheres
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import Experiment, ExperimentCondition
from pilegrasp_ctrl.scenarios.paper.figures_mechanism import NOISY, OPERATORS, ORDER_NAMES, order_condition
from pilegrasp_ctrl.scenarios.paper.figures_nulls import FEW_BALLS, LOOSE, SWAPPED, TIPS
from pilegrasp_ctrl.scenarios.paper.figures_objects import (
    FIG06,
    FIG08,
    ROUNDNESS_NAMES,
    STRATEGY_CASES,
    roundness_grid,
    strategy_pair,
    with_other_controller,
)
from pilegrasp_ctrl.scenarios.paper.figures_piles import COUNTS, FIG10, UNSUPPORTED, USUAL_PUSH, VELOCITY_FORCE
from pilegrasp_ctrl.scenarios.paper.ledger import CLAIMS, choose_examples
from pilegrasp_ctrl.scenarios.paper.plan import (
    EXPERIMENTS,
    Remaining,
    count_remaining,
    find_experiment,
    plan,
    with_settings,
)
from pilegrasp_ctrl.sim.object_file import read_object
from pilegrasp_ctrl.study.attempt import AttemptReport, AttemptRow
from pilegrasp_ctrl.study.store import StudyStore


def test_no_condition_is_refused_before_its_pile_is_made():
    for part in plan(EXPERIMENTS.values()):
        check(part.condition.scenario)


def attempts_at(condition, experiments=None, limit=None):
    planned = plan(experiments or EXPERIMENTS.values(), limit)
    return {part.condition.config_hash: part.attempts for part in planned}[condition.config_hash]


def test_fifty_attempts_a_condition_a_hundred_near_95_percent_and_twenty_in_a_cell():
    assert attempts_at(grasp("cube")) == attempts_at(UNSUPPORTED) == attempts_at(sized(0.3)) == 50
    assert {attempts_at(grasp(kind)) for kind in ("light_sphere", "heavy_sphere", "cylinder")} == {100}
    assert {attempts_at(part) for case in STRATEGY_CASES for part in strategy_pair(*case)} == {100}
    assert {attempts_at(cell) for cell in roundness_grid("cube", HAND)[4:]} == {20}
    assert attempts_at(spheres(0.06, "none", SHOVEL, 90)) == 20
    assert {attempts_at(spheres(0.06, where, HAND, 5)) for where in ("wall", "corner")} == {50}
    assert {attempts_at(order_condition(kind, who)) for kind in ORDER_NAMES for who in OPERATORS} == {15}
    assert sum(attempts_at(part) for part in NOISY) == 200


def test_a_shortened_run_makes_at_most_the_attempts_asked_for():
    part = ExperimentCondition(grasp("cube"), 50)
    assert [part.shortened(n) for n in (None, 1, 20, 1000)] == [50, 1, 20, 50]
    assert attempts_at(grasp("light_sphere"), limit=20) == 20


def test_the_null_models_are_those_of_the_claims():
    assert {part.scenario.pile.count for part in FEW_BALLS.values()} == {1, 2, 3, 5}
    assert {part.scenario.known.pile_y for part in FEW_BALLS.values()} == {0.0, 0.02, -0.02, 0.04, -0.04}
    assert all(part.scenario.strategy.pushing_hand == "plate" for part in SWAPPED.values())
    assert all(
        whole.scenario.pile.mutual_contacts > loose.scenario.pile.mutual_contacts for whole, loose in LOOSE.values()
    )
    shipped = parameters(HAND)["fingers"]["radius_tip"]
    radii = {round(part.scenario.hand_model.fingertip_radius * shipped, 6) for part in TIPS.values()}
    assert radii == {0.0035, 0.005, 0.006, 0.007, 0.00875}


def test_the_shovel_of_the_roundness_grid_meets_simulated_objects_of_one_friction():
    cells = [cell.scenario.pile for kind in ROUNDNESS_NAMES for cell in roundness_grid(kind, SHOVEL)]
    assert {pile.variant for pile in cells} == {"sim"}
    files = object_files()
    assert len({read_object(files[pile.object], "sim").surface.lateral for pile in cells}) == 1


def test_seeds_begin_at_30000_unless_told_otherwise(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(
        "pilegrasp_ctrl.cli.paper._remaining", lambda planned, seed, out: asked.append(seed) or Remaining(0, 0, 0.0)
    )
    assert main(["paper", "fig08", "--dry-run", "--out", str(tmp_path)]) == 0
    assert main(["paper", "fig08", "--dry-run", "--seeds-from", "3", "--out", str(tmp_path)]) == 0
    assert asked == [30_000, 3]


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
    assert sized(0.72).config_hash == grasp("light_sphere", "corner", SHOVEL).config_hash


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


def test_settings_change_every_condition_and_the_claims_still_find_their_attempts():
    settings = {"hand_model.fingertip_radius": 1.25}
    usual, changed = plan([VELOCITY_FORCE]), plan([VELOCITY_FORCE], settings=settings)
    assert not {part.condition.config_hash for part in usual} & {part.condition.config_hash for part in changed}
    wanted = grasp("light_sphere")
    run_as = with_settings(wanted, settings)
    assert run_as.scenario.hand_model.fingertip_radius == 1.25
    assert run_as.scenario.pile == wanted.scenario.pile
    made = AttemptRow(run_as.config_hash, 3, {}, {"success": True, "grasped": 1}, None)
    found = Evidence.from_rows([made], [wanted], {wanted.config_hash: run_as.config_hash})
    assert found.sample(wanted).rows == (made,)
    assert Evidence.from_rows([made], [wanted]).sample(wanted).n == 0


def test_settings_that_do_not_fit_a_condition_are_refused_with_it(tmp_path, capsys):
    assert main(["paper", "fig10", "--set", "known.support_x=0.01", "--dry-run", "--out", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert "--set does not fit the condition hand = " in error
    assert "known.support_x has no effect without a support" in error
    assert main(["paper", "velocity_force", "--set", "known.support_x=0.01", "--dry-run", "--out", str(tmp_path)]) == 0


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
    assert {row["verdict"] for row in (*document["claims"], *document["nulls"])} == {None}
    assert document["missing"] > 100
    assert "p =" not in tenth["parts"][0]["statement"]
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
