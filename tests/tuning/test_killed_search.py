"""A search that is killed between any two statements to its store goes on as if it had not been; damage is named."""

import os
import sqlite3

import pytest

from made_up_search import made_up, search, table
from pilegrasp_ctrl.exceptions import ConfigurationError, ExportError
from pilegrasp_ctrl.tuning.search import run_search

TRIALS = 3


class CountedCursor(sqlite3.Cursor):
    """A cursor whose process is killed before the statement with the number `last`."""

    last = None
    count = 0

    def execute(self, *arguments):
        CountedCursor.count += 1
        if CountedCursor.count == CountedCursor.last:
            os._exit(9)
        return super().execute(*arguments)


class CountedConnection(sqlite3.Connection):
    def cursor(self, factory=CountedCursor):
        return super().cursor(factory)


def run_counted(folder, last=None):
    """Run a search in this process; return the number of statements."""
    CountedCursor.last, CountedCursor.count = last, 0
    connect = sqlite3.connect
    with pytest.MonkeyPatch.context() as patch:
        for module in (sqlite3, sqlite3.dbapi2):
            patch.setattr(module, "connect", lambda *a, **k: connect(*a, **{**k, "factory": CountedConnection}))
        run_search(search(folder), TRIALS, function=made_up)
    return CountedCursor.count


def kill(folder, last):
    """Run a search in a child that is killed before the statement `last`."""
    child = os.fork()
    if not child:
        try:
            run_counted(folder, last)
        finally:
            os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return table(run_search(search(tmp_path_factory.mktemp("whole")), TRIALS, function=made_up))


@pytest.mark.slow
def test_killed_before_a_statement_a_search_ends_as_if_it_had_not_been(tmp_path, whole):
    total = run_counted(tmp_path / "count")
    moments = range(1, total + 1, 41)
    assert len(moments) > 7
    for last in moments:
        folder = tmp_path / str(last)
        kill(folder, last)
        assert table(run_search(search(folder), TRIALS, function=made_up)) == whole


def change(folder, statement, *values):
    with sqlite3.connect(folder / "tuning.db") as database:
        changed = database.execute(statement, values).rowcount
    database.close()
    assert changed != 0


def test_a_trial_without_its_last_number_is_completed(tmp_path, whole):
    def interrupted(task):
        if task.number:
            raise KeyboardInterrupt
        return made_up(task)

    with pytest.raises(KeyboardInterrupt):
        run_search(search(tmp_path), TRIALS, function=interrupted)
    running = "trial_id = (SELECT MAX(trial_id) FROM trials WHERE state = 'RUNNING')"
    change(tmp_path, f"DELETE FROM trial_params WHERE param_name = 'damping_ratio' AND {running}")
    assert table(run_search(search(tmp_path), TRIALS, function=made_up)) == whole


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("UPDATE trial_params SET param_value = param_value + 1.0", "trial 0 is damaged"),
        (
            "UPDATE trial_user_attributes SET value_json = replace(value_json, 'ringing', 'rinking')",
            "trial 0 is damaged",
        ),
        ("UPDATE trial_user_attributes SET value_json = replace(value_json, '8.0', '9.0')", "trial 0 is damaged"),
        ("UPDATE trial_user_attributes SET value_json = '{'", "is damaged, or cannot be written"),
        ("UPDATE trial_user_attributes SET value_json = CAST(x'ff' AS TEXT)", "is damaged, or cannot be written"),
        ("UPDATE trial_values SET value = value + 1.0", "the scores of trial 0 are damaged"),
        ("DELETE FROM trial_user_attributes", "trial 0 is damaged"),
        ("DROP TABLE trial_params", "trial 0 is damaged"),
    ],
)
def test_a_damaged_store_is_named_with_its_trial(tmp_path, statement, words):
    run_search(search(tmp_path), 1, function=made_up)
    change(tmp_path, statement)
    with pytest.raises(ExportError, match=f"tuning.db.*{words}"):
        run_search(search(tmp_path), 1, function=made_up).records()


@pytest.mark.slow
def test_every_byte_of_a_store_may_be_damaged(tmp_path, whole):
    run_search(search(tmp_path), TRIALS, function=made_up)
    file = tmp_path / "tuning.db"
    content = file.read_bytes()
    told, used = 0, [place for place, byte in enumerate(content) if byte]
    for place in used[:: len(used) // 15]:
        file.write_bytes(content[:place] + bytes([content[place] ^ 0x55]) + content[place + 1 :])
        try:
            found = table(run_search(search(tmp_path), TRIALS, function=made_up))
        except (ExportError, ConfigurationError):
            told += 1
        else:
            assert found == whole
    assert told > 1


def test_a_note_that_is_damaged_is_made_anew(tmp_path):
    store = run_search(search(tmp_path), 1, function=made_up)
    store.note("margin", {"factor": 4.0})
    assert store.noted("margin") == {"factor": 4.0}
    change(
        tmp_path, "UPDATE study_user_attributes SET value_json = replace(value_json, '4.0', '5.0') WHERE key = 'margin'"
    )
    assert run_search(search(tmp_path), 1, function=made_up).noted("margin") is None


@pytest.mark.parametrize("name", ["a?b=c#d%20", "é", os.fsdecode(b"\xe9")])
def test_a_folder_of_any_name_holds_its_store(tmp_path, whole, name):
    store = run_search(search(tmp_path / name), TRIALS, function=made_up)
    assert table(store) == whole
    assert (tmp_path / name / "tuning.db").stat().st_size > 0
    assert [file.name for file in tmp_path.iterdir()] == [name]


def test_a_store_must_be_a_regular_file(tmp_path):
    os.mkfifo(tmp_path / "tuning.db")
    with pytest.raises(ExportError, match="is not a regular file"):
        run_search(search(tmp_path), 1, function=made_up)
