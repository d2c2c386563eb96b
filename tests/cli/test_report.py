"""The page of a study: from its database alone, with recordings, and with damaged or hostile content."""

from __future__ import annotations

import html
import json
import re
import sqlite3
from types import SimpleNamespace

import pytest
from scipy.stats import binomtest

import pilegrasp_ctrl.episode
from browser import Browser, find_chromium
from pilegrasp_ctrl import cli
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.index import Links, index_page
from pilegrasp_ctrl.viewer.index_rows import read_attempts
from synthetic_recording import synthetic
from synthetic_study import CONDITIONS, SEEDS, SUCCESSES, rows, write_study

HOSTILE = '</script><script>window.pwned=1</script><img src="x" onerror="window.pwned=1">'


@pytest.fixture
def blind(monkeypatch):
    """A machine without a browser."""
    monkeypatch.setattr("pilegrasp_ctrl.viewer.chromium.find_chromium", lambda: None)


def table(document, name):
    """The rows of a table as lists of the texts of their cells."""
    (body,) = re.findall(rf'<table id="{name}">.*?<tbody>(.*?)</tbody>', document, flags=re.DOTALL)
    cells = [re.findall(r"<td[^>]*>(.*?)</td>", row, flags=re.DOTALL) for row in body.split("</tr>")[:-1]]
    return [[html.unescape(re.sub(r"<[^>]+>", "", cell)).strip() for cell in row] for row in cells]


def report(folder, capsys, *options):
    status = cli.main(["report", str(folder), *options])
    out, err = capsys.readouterr()
    return status, out, err


def test_success_by_condition_has_wilsons_interval(tmp_path):
    document = index_page("study", read_attempts(write_study(tmp_path)))
    found = table(document, "conditions")
    assert len(found) == len(CONDITIONS)
    for (config_hash, condition), row in zip(CONDITIONS.items(), found, strict=True):
        interval = binomtest(SUCCESSES[config_hash], SEEDS).proportion_ci(0.95, "wilson")
        assert row[:2] == [condition["scenario"], str(condition["pile.count"])]
        assert row[2:6] == [
            str(SEEDS),
            str(SUCCESSES[config_hash]),
            f"{10 * SUCCESSES[config_hash]} %",
            f"{100 * interval.low:.0f}–{100 * interval.high:.0f} %",
        ]
        # One attempt of each holds two objects; every success was triggered by the force; one attempt raised.
        assert row[7:10] == ["1", str(SUCCESSES[config_hash]), "1" if config_hash == "aaaa" else ""]


def test_failures_come_first_and_say_why(tmp_path):
    found = table(index_page("study", read_attempts(write_study(tmp_path))), "attempts")
    assert [row[1] for row in found] == ["error"] + ["failure"] * 6 + ["success"] * 13
    assert found[0][2:] == ["the pile does not settle", "spheres_wall", "5", "9", "0", ""]
    assert found[1][2:] == ["push: travel limit of 0.36 m", "spheres_wall", "5", "4", "0", "10.0"]


def test_recordings_come_first_among_equals_and_open_their_page(tmp_path):
    rows = read_attempts(write_study(tmp_path))
    links = Links(pages={"aaaa-7": "recordings/aaaa-7.html"}, pictures={"aaaa-7": b"jpeg"}, pairs={"bbbb": "pair.html"})
    document = index_page("study", rows, links)
    assert table(document, "attempts")[1][5] == "7"
    assert '<a href="recordings/aaaa-7.html"><img alt="open the recording"' in document
    assert document.count('<a href="pair.html">side by side</a>') == 1


def test_the_command_makes_pages_beside_the_recordings(tmp_path, capsys, blind):
    write_study(tmp_path, recorded=(("aaaa", 0), ("aaaa", 5), ("bbbb", 1)))
    status, out, _ = report(tmp_path, capsys, "--json")
    assert status == 0
    answer = json.loads(out)
    assert {key: answer[key] for key in ("attempts", "successes", "recordings", "recorded_now", "thumbnails")} == {
        "attempts": 20,
        "successes": 13,
        "recordings": 3,
        "recorded_now": 0,
        "thumbnails": 0,
    }
    document = (tmp_path / "index.html").read_text(encoding="utf-8")
    targets = re.findall(r'href="(recordings/[^"]+)"', document)
    assert sorted(targets) == [f"recordings/{name}.html" for name in ("aaaa-0", "aaaa-5", "aaaa-pair", "bbbb-1")]
    assert all((tmp_path / target).is_file() for target in targets)
    assert 'class="pair"' in (tmp_path / "recordings" / "aaaa-pair.html").read_text(encoding="utf-8")
    # A second report keeps the pages and writes the same.
    before = {file: file.stat().st_mtime_ns for file in (tmp_path / "recordings").iterdir()}
    assert report(tmp_path, capsys)[0] == 0
    assert {file: file.stat().st_mtime_ns for file in (tmp_path / "recordings").iterdir()} == before
    assert (tmp_path / "index.html").read_text(encoding="utf-8") == document


def keep_scenarios(folder):
    """Add the table from which attempts can be repeated; return the conditions' real hashes."""
    connection = sqlite3.connect(folder / "study.db")
    with connection:
        connection.execute("CREATE TABLE scenarios (number INTEGER PRIMARY KEY, config_hash TEXT, scenario TEXT)")
        for config_hash, condition in CONDITIONS.items():
            scenario = load_scenario("spheres_wall", {"pile.count": condition["pile.count"]})
            connection.execute(
                "INSERT INTO scenarios (config_hash, scenario) VALUES (?, ?)", (config_hash, scenario.model_dump_json())
            )
    connection.close()


def test_missing_recordings_are_made_on_request(tmp_path, capsys, blind, monkeypatch):
    write_study(tmp_path, recorded=(("aaaa", 0),))
    keep_scenarios(tmp_path)
    asked = []

    def run(scenario, *, seed, record):
        assert record
        asked.append((scenario.pile.count, seed))
        success = seed < SUCCESSES["aaaa" if scenario.pile.count == 5 else "bbbb"]
        grasped = (2 if seed == 0 else 1) if success else 0
        return SimpleNamespace(success=success, grasped=grasped, recording=synthetic(success, objects=3, frames=5))

    monkeypatch.setattr(pilegrasp_ctrl.episode, "run", run)
    status, out, err = report(tmp_path, capsys, "--recordings", "1", "--json")
    assert (status, err) == (0, "")
    # The first success of the first condition is there; its first failure has seed 4, the other condition's seed 9.
    assert sorted(asked) == [(5, 4), (18, 0), (18, 9)]
    assert json.loads(out)["recordings"] == 4
    assert Recording.load(tmp_path / "recordings" / "aaaa-4.npz").meta["success"] is False


def test_an_attempt_with_another_result_than_the_study_is_refused(tmp_path, capsys, blind, monkeypatch):
    write_study(tmp_path)
    keep_scenarios(tmp_path)
    other = SimpleNamespace(success=False, grasped=0, recording=None)
    monkeypatch.setattr(pilegrasp_ctrl.episode, "run", lambda scenario, **_: other)
    status, _, err = report(tmp_path, capsys, "--recordings", "1")
    assert status == 2
    assert "seed 0 of aaaa has another result now" in err


def test_a_study_without_scenarios_cannot_be_repeated(tmp_path, capsys, blind):
    status, _, err = report(write_study(tmp_path), capsys, "--recordings", "1")
    assert status == 2
    assert "keeps no scenario for aaaa" in err


def test_a_folder_without_a_study_is_an_error_of_one_sentence(tmp_path, capsys):
    assert "no such study; `pilegrasp sweep" in report(tmp_path, capsys)[2]
    (tmp_path / "study.db").write_bytes(b"not a database, and long enough to be read as one" * 50)
    status, _, err = report(tmp_path, capsys)
    assert status == 2
    assert "is no study or is damaged" in err
    assert err.count("\n") == 1
    (tmp_path / "study.db").unlink()
    sqlite3.connect(tmp_path / "study.db").close()
    with pytest.raises(ExportError, match="is no study or is damaged: no such table: attempts"):
        read_attempts(tmp_path)


def test_an_empty_study_is_a_page(tmp_path, capsys, blind):
    status, _, _ = report(write_study(tmp_path, content=[]), capsys)
    assert status == 0
    assert "0 attempts, 0 successful" in (tmp_path / "index.html").read_text(encoding="utf-8")


def test_hostile_rows_stay_text(tmp_path):
    content = [
        (HOSTILE, 0, json.dumps({HOSTILE: HOSTILE}), json.dumps({"success": False, "reason": HOSTILE}), None),
        ("../../etc", 1, "not JSON", "{", None),
        ("b", "x", "[1]", json.dumps({"success": "yes", "grasped": "many", "outcomes": [3, None]}), None),
        ("c", 2, None, None, HOSTILE),
        (b"blob", 2**40, json.dumps({"deep": [[[[]]]]}), json.dumps({"success": True, "sim_time": 1e400}), None),
    ]
    found = read_attempts(write_study(tmp_path, content=content))
    assert [row.success for row in found] == [False, None, None, None, True]
    assert found[1].words == "the result cannot be read"
    assert all(re.fullmatch(r"[\w-]*-\d+", row.stem) for row in found)
    document = index_page(HOSTILE, found)
    assert "<img" not in document
    assert document.count("<script") == 1
    assert len(table(document, "attempts")) == len(content)


@pytest.mark.slow
@pytest.mark.browser
def test_the_page_in_a_browser_filters_and_opens_a_recording(tmp_path, capsys):
    executable = find_chromium()
    if executable is None:
        pytest.skip("Chromium is not installed")
    write_study(tmp_path, recorded=(("aaaa", 5),))
    assert json.loads(report(tmp_path, capsys, "--json")[1])["thumbnails"] == 1
    shown = "[...document.querySelectorAll('#attempts tbody tr')].filter((row) => !row.hidden).length"
    with Browser(executable) as browser:
        for width, height in ((1280, 800), (400, 850)):
            browser.open(tmp_path / "index.html", width, height)
            assert browser.console_errors() == []
            assert browser.evaluate("document.documentElement.scrollWidth") <= width
        assert browser.evaluate(shown) == len(rows())

        def choose(name, value):
            browser.evaluate(f"""(() => {{
              const field = document.getElementById("{name}");
              field.type === "checkbox" ? (field.checked = {value}) : (field.value = {value});
              field.dispatchEvent(new Event("input", {{ bubbles: true }}));
            }})()""")

        choose("verdict", "'failure'")
        assert browser.evaluate(shown) == 6
        choose("words", "'travel 18'")
        assert browser.evaluate(shown) == 1
        choose("words", "''")
        browser.evaluate("document.querySelectorAll('[data-only]')[0].click()")
        assert browser.evaluate(shown) == 5
        assert browser.evaluate("document.getElementById('count').textContent") == "5 of 20"
        choose("recorded", "true")
        assert browser.evaluate(shown) == 1
        picture = browser.evaluate("(({ naturalWidth: w, naturalHeight: h }) => [w, h])(document.images[0])")
        assert picture == [320, 200]
        browser.evaluate("document.querySelector('#attempts a').click()")
        browser.wait_for("Boolean(window.pilegrasp)")
        assert browser.evaluate("pilegrasp.ready.then(() => Boolean(pilegrasp.viewer))") is True
        assert browser.evaluate("document.querySelector('.verdict').textContent") == "Failed"
