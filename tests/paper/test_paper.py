"""`pilegrasp paper`: what it plans, what it costs, what it refuses; and a small real run."""

import json

import pytest

from pilegrasp_ctrl.analysis.motion import table_force
from pilegrasp_ctrl.cli import main
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.programs.attempt import check
from pilegrasp_ctrl.recording import Body, Recording, Shape
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, SHOVEL, grasp, sized, spheres
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import ROBOT, SIMULATED, Experiment, ExperimentCondition
from pilegrasp_ctrl.scenarios.paper.figures_objects import FIG06, FIG08, STRATEGY_CASES, roundness_grid
from pilegrasp_ctrl.scenarios.paper.figures_piles import FIG10, UNSUPPORTED, USUAL_PUSH, VELOCITY_FORCE
from pilegrasp_ctrl.scenarios.paper.ledger import CLAIMS, choose_examples
from pilegrasp_ctrl.scenarios.paper.plan import EXPERIMENTS, count_remaining, find_experiment, plan
from pilegrasp_ctrl.study.attempt import AttemptRow
from pilegrasp_ctrl.study.store import StudyStore


def test_every_condition_can_be_prepared_as_far_as_that_can_be_known_without_a_pile():
    for part in plan(EXPERIMENTS.values()):
        check(part.condition.scenario)


def test_the_papers_numbers_are_the_default():
    for name, experiment in EXPERIMENTS.items():
        for row in experiment.conditions:
            assert row.attempts in (10, ROBOT, SIMULATED)
            assert row.shortened(None) == row.attempts
            if name != "table1" and row.condition != UNSUPPORTED:
                assert (row.attempts == SIMULATED) == (row.condition.scenario.hand == SHOVEL) or name == "fig08"
    assert [row.attempts for row in FIG10.conditions if row.condition == UNSUPPORTED] == [10]


def test_a_shortened_run_makes_no_more_than_asked_and_fewer_in_the_cells_of_a_grid():
    row = ExperimentCondition(grasp("cube"), 50, 0.25)
    assert [row.shortened(n) for n in (None, 1, 2, 20, 1000)] == [50, 1, 1, 5, 50]
    assert ExperimentCondition(grasp("cube"), 20).shortened(20) == 20


def test_grids_are_the_papers():
    assert len(roundness_grid("cube", HAND)) == 16
    assert all(cell.scenario.pile.mass == 0.06 for cell in roundness_grid("cylinder", SHOVEL))
    assert len(STRATEGY_CASES) == 6
    assert {row.condition.scenario.pile.count for row in FIG10.conditions} == {
        3,
        5,
        10,
        15,
        18,
        20,
        25,
        30,
        60,
        90,
    }


def test_equal_conditions_of_several_figures_are_run_once():
    work = plan([FIG06, FIG08, VELOCITY_FORCE])
    hashes = [part.condition.config_hash for part in work]
    assert len(hashes) == len(set(hashes))
    shared = grasp("light_sphere").config_hash
    assert [part.experiment for part in work if part.condition.config_hash == shared] == ["fig06"]
    assert spheres(0.18, "corner").config_hash == USUAL_PUSH.config_hash
    assert sized(0.45).config_hash == grasp("light_sphere", "corner", SHOVEL).config_hash


def test_the_largest_number_that_is_asked_for_counts():
    fewer, more = ExperimentCondition(grasp("cube"), 10), ExperimentCondition(grasp("cube"), 30)
    experiments = [Experiment("x", "", "", (part,), FIG08.draw) for part in (fewer, more)]
    assert [part.attempts for part in plan(experiments)] == [30]


def test_what_is_expected_shrinks_with_what_is_there(tmp_path):
    work = plan([VELOCITY_FORCE], 3)
    fresh = count_remaining(work, 7)
    assert (fresh.attempts, fresh.missing) == (6, 6)
    with StudyStore(tmp_path, create=True) as store:
        from pilegrasp_ctrl.study.attempt import AttemptReport

        condition = work[0].condition
        store.adopt([condition], {})
        store.add([(condition, AttemptReport(condition.config_hash, 8, "{}", None, False, None, 100.0, 100.0, "host"))])
        left = count_remaining(work, 7, store)
    assert left.missing == 5
    assert left.seconds == pytest.approx(2 * 100.0 + 3 * work[1].cost())


def test_an_unknown_experiment_is_refused_with_the_known_ones(tmp_path, capsys):
    with pytest.raises(ConfigurationError, match="choose from fig06, fig07"):
        find_experiment("fig12")
    assert main(["paper", "fig12", "--out", str(tmp_path)]) == 2
    assert "there is no experiment 'fig12'" in capsys.readouterr().err


def test_a_dry_run_counts_and_touches_nothing(tmp_path, capsys):
    assert (
        main(["paper", "all", "--attempts", "20", "--jobs", "2", "--dry-run", "--json", "--out", str(tmp_path / "x")])
        == 0
    )
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


def test_typical_is_the_commonest_way_and_there_the_median():
    rows = [row(0, True, 2, 30.0), *(row(k, True, 1, 10.0 + k) for k in (1, 2, 3)), row(4, False, 0, 5.0, "no")]
    claim = next(claim for claim in CLAIMS if claim.name == "C1")
    found = choose_examples(claim, Evidence.from_rows(rows, [grasp("light_sphere")]))
    assert [(example.outcome, example.row.seed) for example in found] == [("success", 2), ("failure", 4)]


def recorded(vertical, outcomes):
    time = 0.1 * range(len(vertical)).stop
    times = [0.1 * k for k in range(len(vertical))]
    assert time > 0.0
    return Recording(
        meta={"outcomes": outcomes},
        bodies=(Body("table", "support", (Shape("plane", (1.0, 1.0)),)),),
        frame_time=[0.0],
        body_position=[[[0.0, 0.0, 0.0]]],
        body_quaternion=[[[1.0, 0.0, 0.0, 0.0]]],
        signal_time=times,
        signals={"wrench": [[0.0, 0.0, force, 0.0, 0.0, 0.0] for force in vertical]},
    )


def test_the_tables_force_counts_from_the_air():
    outcomes = [{"name": "approach", "start": 0.0, "end": 0.45}, {"name": "push", "start": 0.45, "end": 0.75}]
    found = table_force(recorded([0.5, 0.5, 0.5, 0.5, 2.5, 4.5, 8.5, 6.5, 0.5], outcomes))
    assert found == pytest.approx({"mean": 6.0, "peak": 8.0})
    assert table_force(recorded([0.5] * 9, outcomes[:1])) is None


def test_a_small_real_run_can_be_continued_and_shows_what_it_found(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    out = tmp_path / "results"
    command = [
        "paper",
        "velocity_force",
        "--attempts",
        "1",
        "--jobs",
        "2",
        "--seeds-from",
        "3",
        "--json",
        "--out",
        str(out),
    ]
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


def test_a_shortened_run_keeps_all_attempts_where_a_cell_is_judged_alone():
    planned = {work.condition.config_hash: work.attempts for work in plan([FIG10], 20)}
    for count, attempts in ((5, 20), (10, 10)):
        assert planned[spheres(0.06, "wall", SHOVEL, count).config_hash] == attempts
    assert planned[spheres(0.06, "none", SHOVEL, 5).config_hash] == 10
