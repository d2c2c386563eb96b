"""A damaged study: a flipped byte is noticed or changes nothing, and its row is named; older studies are read."""

import contextlib
import json
import random
import sqlite3
import time
from dataclasses import replace

import pytest

from pilegrasp_ctrl import cli
from pilegrasp_ctrl.exceptions import ConfigurationError, ExportError, PilegraspError
from pilegrasp_ctrl.files import STUDY_FILE
from pilegrasp_ctrl.stored_rows import COLUMNS, WITHOUT_DIGEST, row_digest
from pilegrasp_ctrl.study.condition import conditions
from pilegrasp_ctrl.study.origins import origins_of
from pilegrasp_ctrl.study.store import FORMER_FORMAT, StudyStore
from pilegrasp_ctrl.study.table import table
from pilegrasp_ctrl.viewer.study.rows import read_attempts
from study_tasks import short_attempt_report

SEEDS = 12
ONE = " AND config_hash = (SELECT min(config_hash) FROM attempts)"
CONFIGURATION = {"scenario": {"pile": {"count": 18}}, "set": {}, "varied": ["pile.count"]}


@pytest.fixture(scope="module")
def counts():
    return conditions("spheres_wall", {"pile.count": [3, 5]})


@pytest.fixture(scope="module")
def content(tmp_path_factory, counts):
    """The bytes of a study with two conditions of twelve seeds, one of which raised."""
    folder = tmp_path_factory.mktemp("study")
    with StudyStore(folder, create=True) as store:
        store.adopt(counts, origins_of([condition.scenario for condition in counts]), CONFIGURATION)
        store.add([(condition, short_attempt_report(condition, seed)) for condition in counts for seed in range(SEEDS)])
    return (folder / STUDY_FILE).read_bytes()


@pytest.fixture
def folder(tmp_path, content):
    (tmp_path / STUDY_FILE).write_bytes(content)
    return tmp_path


@contextlib.contextmanager
def changing(folder):
    connection = sqlite3.connect(folder / STUDY_FILE)
    with connection:
        yield connection
    connection.close()


def everything(folder, counts):
    """What the commands read from a study: table, page, scenarios, what is missing and what it holds."""
    attempts = [(condition, seed) for condition in counts for seed in range(SEEDS + 1)]
    with StudyStore(folder) as store:
        missing = store.missing(attempts)
        # As `run_study` does before it hands out what is missing.
        store.adopt(counts, store.origins(), CONFIGURATION)
        found = table(store), store.attempts(attempts), [store.scenario_values(each.config_hash) for each in counts]
    return *found, [(condition.config_hash, seed) for condition, seed in missing], read_attempts(folder)


def test_every_row_has_a_digest(folder):
    with changing(folder) as connection:
        digests = {digest for (digest,) in connection.execute("SELECT digest FROM digests")}
        rows = [
            row_digest(name, row)
            for name, columns in COLUMNS.items()
            if name not in WITHOUT_DIGEST
            for row in connection.execute(f"SELECT {', '.join(columns)} FROM {name}")
        ]
    assert set(rows) == digests
    assert len(rows) == 2 * 2 * SEEDS + 2 + 2


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            "UPDATE attempts SET result = '{\"success\": true}' WHERE seed = 3",
            "the row of attempts with .*, seed '3'",
        ),
        (
            "UPDATE attempts SET result = replace(result, 'false', 'true') WHERE seed = 3",
            "seed '3' is damaged; run",
        ),
        ("UPDATE attempts SET seed = 77 WHERE seed = 3", "seed '77' is damaged; run `sqlite3 .* AND seed = 77"),
        ("UPDATE attempts SET condition = x'ff00'", "seed '0' is damaged"),
        ("UPDATE attempts SET error = CAST(x'ff41' AS TEXT), result = NULL WHERE seed = 4", "seed '4' is damaged"),
        (
            "UPDATE attempts SET config_hash = 'a`rm -rf ~`' WHERE seed = 3" + ONE,
            "is damaged; take the file from",
        ),
        ("UPDATE costs SET processor_time = 9.0 WHERE seed = 2", "the row of costs with .*, seed '2' is damaged"),
        (
            "UPDATE scenarios SET scenario = replace(scenario, '18', '19')",
            "row of scenarios with number '1'",
        ),
        ("UPDATE scenarios SET number = 9 WHERE number = 1", "the row of scenarios with number '9', config_hash"),
        (
            "UPDATE about SET value = '{' WHERE key = 'configuration'",
            "row of about with key 'configuration'",
        ),
        ("DELETE FROM digests", "is damaged; take the file from a copy, or choose another folder"),
        ("DROP TABLE digests", "is not a study that this version can read; choose another folder"),
        (
            "UPDATE about SET value = 'pilegrasp-study 1' WHERE key = 'format'",
            "the row of about with key 'format' is damaged",
        ),
    ],
)
def test_a_row_that_is_not_as_it_was_written_is_named_with_the_remedy(folder, counts, capsys, change, words):
    with changing(folder) as connection:
        connection.execute(change)
    with pytest.raises(ExportError, match=words) as error:
        everything(folder, counts)
    assert "\n" not in str(error.value)
    assert cli.main(["export", str(folder), str(folder / "table.csv")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"error: {error.value}"
    assert not (folder / "table.csv").exists()


@pytest.mark.parametrize("column", ["type", "name"])
def test_a_list_of_tables_whose_texts_became_blobs_hides_no_table(folder, counts, column):
    expected = everything(folder, counts)
    with changing(folder) as connection:
        connection.execute("PRAGMA writable_schema = ON")
        connection.execute(f"UPDATE sqlite_master SET {column} = CAST({column} AS BLOB) WHERE type = 'table'")
    assert fault_of(folder, counts, expected) is None


@pytest.mark.parametrize("verb", [("report",), ("export", "table.csv")])
def test_a_damaged_attempt_is_never_shown(folder, capsys, verb, monkeypatch):
    monkeypatch.chdir(folder)
    with changing(folder) as connection:
        connection.execute("UPDATE attempts SET result = replace(result, 'false', 'true') WHERE seed = 3")
    assert cli.main([verb[0], str(folder), *verb[1:]]) == 2
    assert "seed '3' is damaged" in capsys.readouterr().err
    assert sorted(path.name for path in folder.iterdir()) == [STUDY_FILE]


def test_the_remedy_makes_the_study_whole(folder, counts):
    before = everything(folder, counts)
    with changing(folder) as connection:
        connection.execute("UPDATE attempts SET error = 'another', result = NULL WHERE seed = 3" + ONE)
    with pytest.raises(ExportError) as error:
        everything(folder, counts)
    with changing(folder) as connection:
        connection.execute(str(error.value).partition('"')[2].partition('"')[0])
    with StudyStore(folder) as store:
        ((condition, seed),) = store.missing([(condition, seed) for condition in counts for seed in range(SEEDS)])
        store.add([(condition, short_attempt_report(condition, seed))])
    assert everything(folder, counts) == before


def test_rows_that_are_taken_out_are_missing_and_nothing_else(folder, counts):
    with changing(folder) as connection:
        connection.execute("DELETE FROM attempts WHERE error IS NOT NULL")
    with StudyStore(folder) as store:
        missing = store.missing([(condition, seed) for condition in counts for seed in range(SEEDS)])
        assert [seed for _, seed in missing] == [7, 7]
        assert len(store.attempts()) == 2 * SEEDS - 2


def without_digests(folder):
    """Make the study one of the former format."""
    with changing(folder) as connection:
        connection.execute("DROP TABLE digests")
        connection.execute("UPDATE about SET value = ? WHERE key = 'format'", (FORMER_FORMAT,))


def test_a_study_of_the_former_format_is_read_and_continued(folder, counts):
    before = everything(folder, counts)
    without_digests(folder)
    assert everything(folder, counts) == before
    with StudyStore(folder) as store:
        store.add([(counts[0], short_attempt_report(counts[0], SEEDS))])
        assert len(store.attempts()) == 2 * SEEDS + 1


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE attempts SET result = '{' WHERE seed = 3",
        "UPDATE attempts SET result = '[1]' WHERE seed = 3",
        "UPDATE attempts SET result = '{}' WHERE seed = 3",
        "UPDATE attempts SET result = NULL WHERE seed = 3",
        'UPDATE attempts SET result = \'{"success": 1, "grasped": 1, "outcomes": []}\' WHERE seed = 3',
        'UPDATE attempts SET result = \'{"success": true, "grasped": 1, "outcomes": [{}]}\' WHERE seed = 3',
        "UPDATE attempts SET result = CAST(x'ff' AS TEXT) WHERE seed = 3",
        "UPDATE attempts SET condition = '7' WHERE seed = 3",
        "UPDATE attempts SET config_hash = 'b' WHERE seed = 3" + ONE,
        "UPDATE attempts SET seed = 'b' WHERE seed = 3",
        "UPDATE costs SET processor_time = 'b' WHERE seed = 3",
        "UPDATE scenarios SET scenario = '[' || scenario",
        "UPDATE about SET value = '{' WHERE key = 'configuration'",
    ],
)
def test_json_that_is_damaged_is_a_sentence_in_a_study_without_digests_too(folder, counts, change):
    without_digests(folder)
    with changing(folder) as connection:
        connection.execute(change)
    with pytest.raises((ExportError, ConfigurationError)) as error, StudyStore(folder) as store:
        store.adopt(counts, {}, {"another": "study"}) if "about" in change else table(store)
    assert "is damaged" in str(error.value)


def test_thousands_of_conditions_are_read_in_linear_time(tmp_path, counts):
    scenario, numbers = counts[0].placed.model_dump_json(), range(5000)
    with StudyStore(tmp_path, create=True) as store:
        store.adopt(counts[:1], {})
    without_digests(tmp_path)
    with changing(tmp_path) as connection:
        connection.executemany(
            "INSERT INTO scenarios (config_hash, scenario) VALUES (?, ?)",
            ((f"{n:016x}", scenario) for n in range(5000)),
        )
        connection.executemany(
            "INSERT INTO attempts VALUES (?, 0, '{}', ?, NULL)",
            ((f"{n:016x}", json.dumps({"success": True, "grasped": 1, "outcomes": []})) for n in numbers),
        )
    begin = time.process_time()
    with StudyStore(tmp_path) as store:
        assert len(table(store)) == 5000
    assert time.process_time() - begin < 10.0


def test_names_that_differ_from_row_to_row_are_no_columns_without_end(tmp_path, counts):
    with StudyStore(tmp_path, create=True) as store:
        store.adopt(counts, {})
        for seed in range(3):
            report = short_attempt_report(counts[0], seed)
            measures = {f"{seed}-{n}": n for n in range(2000)}
            result = json.dumps(json.loads(report.result) | {"measures": measures})
            store.add([(counts[0], replace(report, result=result))])
        with pytest.raises(ExportError, match="different names, and a table at most 4096 columns"):
            table(store)


def flipped(content, place, bit):
    return content[:place] + bytes([content[place] ^ (1 << bit)]) + content[place + 1 :]


def fault_of(folder, counts, expected):
    """Return what is wrong with the answer to a damaged study, or None: the same table, or one sentence."""
    try:
        found = everything(folder, counts)
    except PilegraspError as error:
        return "several lines" if "\n" in str(error) else None
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None if found == expected else "another table"


def test_no_flipped_byte_at_a_beginning_of_a_page_changes_a_table(folder, content, counts):
    expected = everything(folder, counts)
    faults = {}
    for place in [*range(0, 112, 4), *range(4096, len(content), 4096), *range(4099, len(content), 8192)]:
        (folder / STUDY_FILE).write_bytes(flipped(content, place, place % 8))
        faults[place] = fault_of(folder, counts, expected)
    assert {place: fault for place, fault in faults.items() if fault} == {}


@pytest.mark.slow
def test_no_flipped_byte_anywhere_changes_a_table(folder, content, counts, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    expected, draw = everything(folder, counts), random.Random(24)
    # Three of four bytes are those of rows; the rest is anywhere, most of it unused.
    used = [place for place, byte in enumerate(content) if byte]
    places = [*range(0, 100, 2), *draw.sample(used, 150), *draw.sample(range(len(content)), 50)]
    faults = {}
    for place in places:
        (folder / STUDY_FILE).write_bytes(flipped(content, place, draw.randrange(8)))
        faults[place] = fault_of(folder, counts, expected)
        for extra in folder.glob("study.db-*"):
            extra.unlink()
    assert len(faults) > 200
    assert {place: fault for place, fault in faults.items() if fault} == {}
