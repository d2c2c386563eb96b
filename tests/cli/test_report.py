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
from pilegrasp_ctrl.viewer.study.page import DRAWN, Links, index_page
from pilegrasp_ctrl.viewer.study.pivots import pivots
from pilegrasp_ctrl.viewer.study.rows import read_attempts
from synthetic_recording import synthetic
from synthetic_study import CONDITIONS, SEEDS, SUCCESSES, rows, write_study

HOSTILE = '</script><script>window.pwned=1</script><img src="x" onerror="window.pwned=1">'


@pytest.fixture
def blind(monkeypatch):
    """A machine without a browser."""
    monkeypatch.setattr("pilegrasp_ctrl.viewer.pictures.chromium.find_chromium", lambda: None)


def table(document, name):
    """The rows of a table as lists of the texts of their cells."""
    (body,) = re.findall(rf'<table id="{name}"[^>]*>.*?<tbody>(.*?)</tbody>', document, flags=re.DOTALL)
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
        assert row[0] == f"{10 * SUCCESSES[config_hash]} %"
        assert row[2:6] == [
            f"{100 * interval.low:.0f}–{100 * interval.high:.0f} %",
            str(SEEDS),
            str(SUCCESSES[config_hash]),
            str(condition["pile.count"]),
        ]
        # One attempt of each holds two objects; every success was triggered by the force; one attempt raised.
        assert row[6:9] == ["1", str(SUCCESSES[config_hash]), "1" if config_hash == "aaaa" else ""]


def test_conditions_stand_in_the_order_in_which_they_were_asked_for(tmp_path):
    keep_scenarios(write_study(tmp_path), order=("bbbb", "aaaa"))
    found = table(index_page("study", read_attempts(tmp_path)), "conditions")
    assert [row[5] for row in found] == ["18", "5"]


def test_a_key_that_is_equal_in_all_attempts_stands_above_the_tables(tmp_path):
    document = index_page("study", read_attempts(write_study(tmp_path)))
    assert "All attempts: scenario = spheres_wall." in document
    assert "<th>scenario</th>" not in document


def test_failures_are_counted_by_reason_whatever_their_numbers(tmp_path):
    content = [
        ("a", seed, "{}", json.dumps({"success": False, "reason": f"object {seed} fell at {seed}.5 s"}), None)
        for seed in range(3)
    ]
    content.append(("a", 9, "{}", None, "the pile does not settle"))
    found = table(index_page("study", read_attempts(write_study(tmp_path, content=content))), "reasons")
    assert [row[:3] for row in found] == [
        ["3", "75 %", "object … fell at … s"],
        ["1", "25 %", "the pile does not settle"],
    ]


def test_attempts_are_counted_over_any_two_keys(tmp_path):
    content = [
        (f"{hand}{count}", seed, json.dumps({"hand": hand, "pile.count": count}), json.dumps({"success": won}), None)
        for hand, count, seed, won in (("a", 1, 0, True), ("a", 1, 1, False), ("a", 5, 0, True), ("b", 5, 0, False))
    ]
    by_keys = {(one["x"], one["by"]): one for one in pivots(read_attempts(write_study(tmp_path, content=content)))}
    assert set(by_keys) == {("hand", ""), ("pile.count", ""), ("hand", "pile.count"), ("pile.count", "hand")}
    both = by_keys["pile.count", "hand"]
    assert (both["values"], both["series"]) == (["1", "5"], ["a", "b"])
    assert [[cell and cell[:2] for cell in cells] for cells in both["cells"]] == [[[2, 1], [1, 1]], [None, [1, 0]]]
    interval = binomtest(1, 2).proportion_ci(0.95, "wilson")
    assert both["cells"][0][0][2:] == pytest.approx([interval.low, interval.high], abs=1e-4)
    assert [cell[:2] for cell in by_keys["pile.count", ""]["cells"][0]] == [[2, 1], [2, 1]]


def test_a_key_that_a_condition_leaves_out_has_the_value_of_its_scenario(tmp_path):
    won = json.dumps({"success": True})
    content = [
        ("aaaa", 0, json.dumps({"scenario": "spheres_wall", "pile.count": 5}), won, None),
        ("bbbb", 0, json.dumps({"scenario": "spheres_wall", "strategy.alpha_deg": 45}), won, None),
    ]
    keep_scenarios(write_study(tmp_path, content=content))
    rows = read_attempts(tmp_path)
    assert [row.values for row in rows] == [
        {"scenario": "spheres_wall", "pile.count": "5", "strategy.alpha_deg": "0"},
        {"scenario": "spheres_wall", "pile.count": "18", "strategy.alpha_deg": "45"},
    ]
    # The name of a condition holds what was asked for, its row in the table all.
    document = index_page("study", rows)
    assert '<option value="1">scenario spheres_wall, strategy.alpha_deg 45</option>' in document
    assert table(document, "conditions")[1][5:7] == ["18", "45"]
    assert [one["values"] for one in pivots(rows)][:2] == [["5", "18"], ["0", "45"]]


def test_numbers_of_a_plot_stand_by_size_and_words_as_they_were_asked_for(tmp_path):
    content = [
        (f"{k}", 0, json.dumps({"speed": speed, "hand": hand}), json.dumps({"success": True}), None)
        for k, (speed, hand) in enumerate(((0.5, "shovel"), (0.1, "rbo_hand2"), (1e-3, "shovel")))
    ]
    speed, hand, *_ = pivots(read_attempts(write_study(tmp_path, content=content)))
    assert speed["values"] == ["0.001", "0.1", "0.5"]
    assert hand["values"] == ["shovel", "rbo_hand2"]


def test_losses_have_a_column_if_the_study_knows_them(tmp_path):
    won = json.dumps({"success": True, "grasped": 1, "carried": {"taken": 3, "kept": 1, "lost": 2}})
    old = json.dumps({"success": True, "grasped": 1})
    content = [("a", 0, "{}", won, None), ("a", 1, "{}", old, None)]
    found = table(index_page("study", read_attempts(write_study(tmp_path, content=content))), "attempts")
    assert [row[3:] for row in found] == [["0", "1", "2", ""], ["1", "1", "", ""]]


def test_failures_come_first_and_say_why(tmp_path):
    found = table(index_page("study", read_attempts(write_study(tmp_path))), "attempts")
    assert [row[1] for row in found] == ["error"] + ["failure"] * 6 + ["success"] * 13
    assert found[0][2:] == ["the pile does not settle", "5", "9", "0", ""]
    assert found[1][2:] == ["push: travel limit of 0.36 m", "5", "4", "0", "10.0"]


def test_recordings_come_first_among_equals_and_open_their_page(tmp_path):
    rows = read_attempts(write_study(tmp_path))
    links = Links(pages={"aaaa-7": "recordings/aaaa-7.html"}, pictures={"aaaa-7": b"jpeg"}, pairs={"bbbb": "pair.html"})
    document = index_page("study", rows, links)
    assert table(document, "attempts")[1][4] == "7"
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


@pytest.mark.browser
def test_pages_may_share_one_viewer(tmp_path, capsys, blind):
    write_study(tmp_path, recorded=(("aaaa", 0), ("bbbb", 1)))
    assert report(tmp_path, capsys)[0] == 0
    alone = (tmp_path / "recordings" / "aaaa-0.html").read_text(encoding="utf-8")
    assert report(tmp_path, capsys, "--shared")[0] == 0
    (viewer,) = (tmp_path / "recordings").glob("*.js")
    page = (tmp_path / "recordings" / "aaaa-0.html").read_text(encoding="utf-8")
    assert len(page) < len(alone) - 600_000
    assert f'<script src="{viewer.name}">' in page
    # What stands in its place is not believed.
    viewer.write_text("window.pwned = 1", encoding="utf-8")
    assert report(tmp_path, capsys, "--shared")[0] == 0
    executable = find_chromium()
    if executable is None:
        pytest.skip("Chromium is not installed")
    with Browser(executable) as browser:
        browser.open(tmp_path / "recordings" / "aaaa-0.html")
        assert browser.evaluate("pilegrasp.ready.then(() => Boolean(pilegrasp.viewer))") is True
        assert browser.evaluate("typeof window.pwned") == "undefined"
        assert browser.console_errors() == []


def keep_scenarios(folder, order=tuple(CONDITIONS)):
    """Add the table from which attempts can be repeated; return the conditions' real hashes."""
    connection = sqlite3.connect(folder / "study.db")
    with connection:
        connection.execute("CREATE TABLE scenarios (number INTEGER PRIMARY KEY, config_hash TEXT, scenario TEXT)")
        for config_hash in order:
            scenario = load_scenario("spheres_wall", {"pile.count": CONDITIONS[config_hash]["pile.count"]})
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
    assert document.count("<script") == 2  # the page's own, and the block of its numbers
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
        # Sorted by the seed, downwards; the table that is saved holds what is shown, in that order.
        for _ in range(2):
            browser.evaluate("[...document.querySelectorAll('#attempts th button')].at(3).click()")
        choose("verdict", "'error'")
        assert browser.evaluate("study.csv()").splitlines() == [
            "verdict,why it ended,pile.count,seed,held,time [s]",
            "error,the pile does not settle,5,9,0,",
        ]
        choose("verdict", "'failure'")
        seeds = (
            "[...document.querySelectorAll('#attempts tbody tr:not([hidden])')].map((row) => row.cells[4].textContent)"
        )
        assert browser.evaluate(seeds) == sorted(browser.evaluate(seeds), key=int, reverse=True)
        browser.evaluate("document.querySelector('button[data-reason]').click()")
        assert browser.evaluate(shown) == 6
        # The plot is there, with a mark for each value of the key.
        assert browser.evaluate("document.querySelectorAll('#chart g g path').length") == len(CONDITIONS)
        assert browser.evaluate("document.querySelector('#chart g g title').textContent") == (
            "pile.count 5: 4 of 10, 40 % (17–69 %)"
        )
        choose("reason", "''")
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
        # A key that few conditions name is not what the plot opens with.
        keys = (
            {"hand": "a", "count": 1},
            {"hand": "b", "count": 5},
            {"hand": "a", "count": 5},
            {"rare": 1},
            {"rare": 2},
        )
        content = [(f"{k}", 0, json.dumps(key), "{}", None) for k, key in enumerate(keys)]
        content += [("0", seed, json.dumps(keys[0]), "{}", None) for seed in range(1, 2 * DRAWN + 100)]
        other = write_study(tmp_path / "other", content=content)
        report(other, capsys)
        browser.open(other / "index.html", 1280, 800)
        assert browser.evaluate("['over', 'by'].map((name) => document.getElementById(name).value)") == [
            "count",
            "hand",
        ]
        # A long table is drawn as far as the reader scrolls; what is saved and counted is all of it.
        assert browser.evaluate(shown) == DRAWN
        for more in (2 * DRAWN, len(content)):
            browser.evaluate("document.querySelector('.pane.tall').scrollTop = 1e6")
            browser.wait_for(f"{shown} === {more}")
        assert len(browser.evaluate("study.csv()").splitlines()) == 1 + len(content)
        browser.evaluate("[...document.querySelectorAll('#attempts th button')].at(-3).click()")
        assert browser.evaluate(shown) == DRAWN
        assert browser.evaluate("document.getElementById('count').textContent") == str(len(content))
