"""The benchmark: its form, its comparisons and what its peers compute; how long anything takes is never judged here."""

import json
import sys

import numpy as np
import pytest

from pilegrasp_ctrl.cli import main
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.tasks.frame_task import pose_error
from pilegrasp_ctrl.validation.bench import benchmark, clock, peers
from pilegrasp_ctrl.validation.bench.clock import Timing, Work, garbage_kept, time_in_turns
from pilegrasp_ctrl.validation.bench.judgement import compare, judge
from pilegrasp_ctrl.validation.bench.motion import ARMS, RATE, record_line
from pilegrasp_ctrl.validation.bench.result import BenchResult, LoopRow, Row, load_result
from pilegrasp_ctrl.validation.bench.ticks import allocations, impedance, operational_space

NAMES = [source.name for source in ARMS]

TINY = benchmark.Size(
    blocks=2,
    block_time=2e-4,
    allocation_ticks=20,
    import_rounds=1,
    scenario="free_space_line",
    seeds=(0,),
    overrides={"line.displacement": [0.0, 0.03, 0.0]},
    quick=True,
)

ABSENT = peers.Peer("ghost", "nothing", "no_such_module", "pip install ghost", lambda line: lambda index: None)


def broken(line):
    raise AttributeError("module 'pink' has no attribute 'solve_ik'")


BROKEN = peers.Peer("namesake", "nothing", "json", "pip install namesake", broken)


@pytest.fixture(scope="module")
def lines():
    return {source.name: record_line(source, source.load()) for source in ARMS}


@pytest.fixture(scope="module")
def few_interpreters():
    """Starting them is the slow part, and each is started alike."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(clock, "STATEMENTS", {"python": "pass", "import numpy": "import numpy"})
        yield


@pytest.fixture(scope="module")
def measured(few_interpreters):
    """A result and the progress that was shown on the way."""
    shown = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(benchmark, "PEERS", (*peers.PEERS, ABSENT, BROKEN))
        result = benchmark.run_benchmark(TINY, lambda share, what: shown.append((share, what)))
    return result, shown


@pytest.fixture
def result(measured):
    return measured[0]


@pytest.mark.parametrize("name", NAMES)
def test_every_tick_part_and_peer_has_its_line(result, name):
    ticks = ["operational space", "operational space, limits active", "operational space, osqp", "impedance"]
    parts = ["arm.update", "task and bounds", "friction", "QP", "torque", "QP, osqp"]
    for key in ticks + parts + [peer.key for peer in peers.PEERS]:
        assert result.row(f"{name} {key}") is not None, key


def test_lines_are_ordered_times_and_ratios_of_one_run(result):
    timed = [row for row in result.rows if row.count]
    assert all(0.0 < row.median_us <= row.p99_us <= row.worst_us for row in timed)
    assert all(len(row.blocks_us) == (1 if row.table == "import" else TINY.blocks) for row in timed)
    for row in timed:
        if row.against:
            other = result.row(row.against)
            ratios = np.divide(row.blocks_us, other.blocks_us)
            assert ratios.min() <= row.ratio <= ratios.max()
    assert {row.against for row in timed if row.table == "peer"} == {f"{name} operational space" for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_a_peer_that_is_absent_or_broken_is_a_line_that_says_so(result, name):
    ghost, namesake = result.row(f"{name} ghost"), result.row(f"{name} namesake")
    assert ghost.count == namesake.count == 0
    assert ghost.note == "not installed; pip install ghost"
    assert "solve_ik" in namesake.note


def test_bare_physics_is_stepped_along_the_loop_s_own_trajectory(result):
    assert result.replay_exact
    assert [line.phase for line in result.loop] == ["attempt", "attempt, compiled"]
    for line in result.loop:
        assert line.chunks >= 5
        assert line.period_us == pytest.approx(line.bare_us + line.control_us + line.glue_us)


def test_progress_grows_to_the_end(measured):
    shares = [share for share, _ in measured[1]]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert {what.split(":")[0] for _, what in measured[1]} == {*NAMES, "closed loop", "imports"}


def test_a_result_reads_back_as_it_was_written(result, tmp_path):
    file = tmp_path / "bench.json"
    file.write_text(result.model_dump_json(indent=1), encoding="utf-8")
    assert load_result(file) == result


def test_nothing_has_changed_since_itself(result):
    changes = compare(result, result)
    assert len(changes) == sum(row.ratio is not None for row in result.rows) + len(result.loop)
    assert all(change.factor == 1.0 and change.verdict == "within noise" for change in changes)


def with_ratio(result: BenchResult, key: str, ratio: float, spread: float) -> BenchResult:
    rows = [row.model_copy(update={"ratio": ratio, "spread": spread}) if row.key == key else row for row in result.rows]
    return result.model_copy(update={"rows": tuple(rows)})


@pytest.mark.parametrize(
    ("ratio", "spread", "verdict"),
    [(1.0, 0.1, "faster"), (4.0, 0.1, "slower"), (1.9, 0.1, "within noise"), (1.0, 2.0, "within noise")],
)
def test_a_change_counts_where_it_exceeds_the_noise(result, ratio, spread, verdict):
    key = "wam7 operational space"
    (change,) = [
        change
        for change in compare(with_ratio(result, key, 2.0, 0.0), with_ratio(result, key, ratio, spread))
        if change.key.startswith(f"{key} /")
    ]
    assert change.factor == pytest.approx(2.0 / ratio)
    assert change.verdict == verdict


@pytest.mark.parametrize(
    "text",
    ["", "not json", "[]", "{}", '{"form": "pilegrasp-bench-0"}', "\x00", '{"form": "pilegrasp-bench-1", "rows": 3}'],
)
def test_another_file_is_refused_in_one_sentence(tmp_path, text):
    file = tmp_path / "other.json"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigurationError, match=r"other\.json: is not a result of `pilegrasp bench --save`") as error:
        load_result(file)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("change", [{"surprise": 1}, {"versions": None}, {"replay_exact": "yes"}])
def test_a_result_that_was_tampered_with_is_refused(result, tmp_path, change):
    file = tmp_path / "bench.json"
    file.write_text(json.dumps(result.model_dump(mode="json") | change), encoding="utf-8")
    with pytest.raises(ConfigurationError, match=next(iter(change))):
        load_result(file)


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match="cannot be read"):
        load_result(tmp_path / "absent.json")


def tick_row(key: str, ratio: float | None, table: str = "peer") -> Row:
    return Row(key=key, table=table, count=1, median_us=10.0, p99_us=55.0, worst_us=60.0, tail=2.5, ratio=ratio)


def test_targets_are_judged_by_what_was_measured():
    loop = {"phase": "push", "chunks": 1, "ratio_p10": 1.0, "ratio_p90": 2.0, "period_us": 1.0, "bare_us": 1.0}
    rows = [
        tick_row("wam7 operational space", 2.0, "tick"),
        tick_row("wam7 operational space, compiled", 1.0, "tick"),
        tick_row("wam7 mink", 6.1),
        tick_row("wam7 pink", 5.9),
        tick_row("wam7 tsid", 0.5),
        tick_row("panda operational space", 2.0, "tick"),
    ]
    lines = [
        LoopRow(**loop | {"phase": phase}, ratio=ratio, control_us=1.0, glue_us=1.0, realtime_factor=7.5)
        for phase, ratio in (("push", 1.4), ("attempt", 1.5))
    ]
    verdicts = {target.name: (target.value, target.met) for target in judge(rows, lines)}
    assert verdicts["wam7: mink's tick over the project's"] == (6.1, True)
    assert verdicts["wam7: pink's tick over the project's"] == (5.9, False)
    assert verdicts["wam7: tick over tsid's"] == (2.0, False)
    assert verdicts["panda: tick over tsid's"] == (None, None)
    assert verdicts["closed loop over bare physics, push"] == (1.4, False)
    assert verdicts["closed loop over bare physics, attempt"] == (1.5, True)
    assert verdicts["real-time factor of an attempt, by processor time"] == (7.5, True)
    # Peers are compared with the tick in numpy; the compiled one takes half of it here.
    assert verdicts["wam7, compiled: mink's tick over the project's"] == (12.2, True)
    assert verdicts["wam7, compiled: tick over tsid's"] == (1.0, True)


def test_works_take_turns():
    order = []
    works = [Work(key, lambda index, key=key: order.append((key, index))) for key in "ab"]
    rounds = []
    with garbage_kept():
        timings = time_in_turns(works, 3, 1e-9, lambda: rounds.append(len(order)))
    turns = [key for position, (key, _) in enumerate(order) if position == 0 or order[position - 1][0] != key]
    # First each is warmed up, then there are three rounds.
    assert turns == ["a", "b"] * 4
    assert len(rounds) == 3
    assert all(timing.calls == 15 and len(timing.blocks) == 3 for timing in timings.values())


def test_the_statistics_are_those_of_the_durations():
    timing = Timing.of([np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 60.0])])
    assert timing.median == 3.5
    assert timing.worst == 60.0
    assert timing.blocks == (2.0, 5.0)


def test_one_long_break_does_not_make_a_tail():
    quiet, disturbed = np.ones(200), np.ones(200)
    disturbed[100] = 400.0
    assert Timing.of([disturbed, disturbed, quiet]).tail == 1.0
    assert Timing.of([np.linspace(1.0, 3.0, 201)] * 3).tail == pytest.approx(2.98 / 2.0)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("make", [operational_space, impedance])
def test_a_tick_leaves_no_memory_behind(lines, make, name):
    memory = allocations(make(lines[name]), 1000)
    # One float that every tick leaves would be 24,000 bytes; what the last tick keeps for the next differs a little.
    assert memory.growth_bytes < 12_000
    assert memory.growth_blocks < 200
    assert 0 < memory.kept_bytes <= memory.peak_bytes


def test_a_tick_that_hoards_is_found():
    hoard = []
    memory = allocations(lambda index: hoard.append(np.zeros(10)), 100)
    assert memory.growth_bytes > 100 * 80
    assert memory.growth_blocks >= 100


@pytest.mark.parametrize("solver", ["daqp", "osqp"])
def test_the_naive_tick_solves_the_project_s_problem(lines, solver):
    """The Panda's line is free of friction, singular postures and active limits, where the two would differ."""
    line = lines["panda"]
    controller = OperationalSpaceController(line.arm, posture=line.source.posture, rate=RATE)
    naive = peers.naive_tick(line, solver)
    for index in range(0, len(line.observations), 50):
        torque = controller.step(line.observations[index], line.references[index]).command.torque
        # OSQP's default tolerance is 1e-3, and the posture's weight is small against it.
        np.testing.assert_allclose(naive(index), torque, atol=1e-6 if solver == "daqp" else 1.0)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("peer", ["mink", "pink"])
def test_the_kinematic_peers_move_the_same_arm(lines, name, peer):
    """Where no limit binds, their step is the least-squares one with the project's own Jacobian and pose error."""
    line = lines[name]
    # On the line itself the error is too small to tell anything, and much farther ahead the speed limits bind.
    ahead = line._replace(references=line.references[3:], observations=line.observations[:-3])
    (tick,) = [item.tick(ahead) for item in peers.PEERS if item.key == peer]
    if isinstance(tick, str):
        pytest.skip(tick)
    for index in (200, 400):
        q = ahead.observations[index].q
        state = line.arm.update(q, np.zeros(line.arm.nv))
        error = pose_error(state, ahead.references[index])
        assert np.linalg.norm(error) > 5e-4
        posture = 1e-4 * (line.source.posture - q)
        step = np.linalg.solve(state.J.T @ state.J + 1e-4 * np.eye(len(q)), state.J.T @ error + posture)
        np.testing.assert_allclose(np.asarray(tick(index)) / RATE, step, atol=1e-3 * np.abs(step).max())


@pytest.fixture
def tiny_verb(monkeypatch, few_interpreters):
    monkeypatch.setattr(benchmark, "QUICK", TINY)
    monkeypatch.setattr(benchmark, "ARMS", ARMS[1:])


def test_the_verb_prints_one_document_and_saves_the_same(tiny_verb, capsys, tmp_path):
    file = tmp_path / "bench.json"
    assert main(["bench", "--quick", "--json", "--save", str(file)]) == 0
    out = capsys.readouterr().out
    assert json.loads(out) == json.loads(file.read_text(encoding="utf-8"))
    assert load_result(file).settings.quick
    assert main(["bench", "--quick", "--json", "--compare", str(file)]) == 0
    changes = json.loads(capsys.readouterr().out)["changes"]
    assert {"key", "old", "new", "factor", "noise", "verdict"} == changes[0].keys()


def test_the_verb_shows_tables(tiny_verb, capsys, monkeypatch, tmp_path, result):
    file = tmp_path / "bench.json"
    file.write_text(result.model_dump_json(), encoding="utf-8")
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    assert main(["bench", "--quick", "--compare", str(file)]) == 0
    out = capsys.readouterr().out
    for words in ("panda operational space", "panda mink", "closed loop of free_space_line", "real-time factor"):
        assert words in out
    assert "not measured" in out  # the push, in a scenario without one
    assert "OMP_NUM_THREADS is not 1" in out
    assert f"since {file}" in out


def test_the_verb_refuses_before_it_measures(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(benchmark, "run_benchmark", lambda *arguments: sys.exit("measured"))
    file = tmp_path / "garbage.json"
    file.write_text("{}", encoding="utf-8")
    for arguments in (["--compare", str(file)], ["--save", str(tmp_path / "absent" / "a.json")], ["--save", "a.txt"]):
        assert main(["bench", "--quick", *arguments]) == 2
        error = capsys.readouterr().err
        assert error.startswith("error: ")
        assert error.count("\n") == 1
