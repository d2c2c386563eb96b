"""A whole run of the benchmark: its lines, its file and its verb; no test judges a time."""

import json
import sys

import numpy as np
import pytest

from pilegrasp_ctrl.cli import main
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.validation.bench import benchmark, clock, loop, peers
from pilegrasp_ctrl.validation.bench.judgement import compare
from pilegrasp_ctrl.validation.bench.motion import ARMS
from pilegrasp_ctrl.validation.bench.result import BenchResult, load_result

pytestmark = pytest.mark.slow

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
def few_interpreters():
    """Starting them is the slow part, and each is started alike."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(clock, "STATEMENTS", {"python": "pass", "import numpy": "import numpy"})
        yield


@pytest.fixture(scope="module")
def measured(few_interpreters):
    """Return a result, and the progress that was shown."""
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
    ticks += ["operational space, Python task"]
    parts = ["arm.update", "tasks, friction, limits", "QP", "torque", "QP, osqp"]
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
    assert [line.phase for line in result.loop] == ["attempt"]
    for line in result.loop:
        assert line.chunks >= 5
        assert line.period_us == pytest.approx(line.bare_us + line.control_us + line.glue_us)


def test_a_pile_of_cylinders_is_replayed_with_suspicious_contacts_computed_again_as_in_the_loop():
    timing = loop.time_loop("cylinders_wall", (1,), {"pile.count": 8})
    assert len(timing.chunks) > 20
    assert all(chunk.same for chunk in timing.chunks)


def test_progress_grows_to_the_end(measured):
    shares = [share for share, _ in measured[1]]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert {what.split(":")[0] for _, what in measured[1]} == {*NAMES, "closed loop", "imports"}


def test_a_result_reads_back_as_it_was_written(result, tmp_path):
    file = tmp_path / "bench.json"
    file.write_text(result.model_dump_json(indent=1), encoding="utf-8")
    assert load_result(file) == result


def test_a_result_compared_with_itself_shows_no_change(result):
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
def test_a_change_counts_if_it_exceeds_the_noise(result, ratio, spread, verdict):
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


@pytest.mark.parametrize(("key", "value"), [("chunks", 0), ("chunks", -3), ("ratio", 0.0), ("ratio", -1.0)])
def test_a_damaged_number_of_a_saved_result_is_refused(result, tmp_path, key, value):
    document = result.model_dump(mode="json")
    document["loop"] = [document["loop"][0] | {key: value}]
    file = tmp_path / "bench.json"
    file.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(ConfigurationError, match=rf"is not a result of .*loop\.0\.{key}"):
        load_result(file)


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match="no such file"):
        load_result(tmp_path / "absent.json")


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
