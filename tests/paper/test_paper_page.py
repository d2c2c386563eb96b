"""The ledger as files: JSON, page and figures, from a synthetic store."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from scipy.stats import fisher_exact

from browser import Browser, find_chromium
from paper_world import rows as made
from paper_world import standard, usual
from pilegrasp_ctrl.scenarios.paper import ledger
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, spheres
from pilegrasp_ctrl.scenarios.paper.figures_objects import strategy_pair
from pilegrasp_ctrl.scenarios.paper.plan import EXPERIMENTS
from pilegrasp_ctrl.scenarios.paper.printed import printed_numbers
from pilegrasp_ctrl.scenarios.paper.run import gather_evidence, write_results
from pilegrasp_ctrl.study.attempt import AttemptReport
from pilegrasp_ctrl.study.store import StudyStore

pytestmark = pytest.mark.slow

PNG = b"\x89PNG\r\n\x1a\n"


def report(row):
    text = None if row.result is None else json.dumps(row.result)
    return AttemptReport(row.config_hash, row.seed, text, row.error, row.success, None, 2.0, 2.5, "host")


def fill(folder, wanted=lambda condition: True, spoilt=()):
    conditions, found = standard()
    rows = dict(found)
    for condition, fields in spoilt:
        rows[condition.config_hash] = made(condition, replace(usual(condition), **fields))
    store = StudyStore(folder, create=True)
    chosen = [condition for condition in conditions if wanted(condition)]
    store.adopt(chosen, {})
    store.add([(condition, report(row)) for condition in chosen for row in rows[condition.config_hash]])
    return store


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    with fill(folder) as store:
        document = write_results(
            store, "pilegrasp paper all --out <here> & there", 0, attempts=20, recordings=False, draws=30
        )
    return folder, document


def test_the_document_is_what_was_returned_and_holds_every_claim(written):
    folder, document = written
    assert json.loads((folder / "claims.json").read_text()) == document
    assert [claim["id"] for claim in document["claims"]] == [f"C{k}" for k in range(1, 17)]
    assert {claim["verdict"] for claim in document["claims"]} == {"holds", "calibrated"}
    assert [row["verdict"] for row in document["nulls"]] == ["reported", "holds", "reported", "reported"]
    assert all(0.0 <= claim["repeats"] <= 1.0 for claim in document["claims"])
    assert document["missing"] == 0
    assert document["expected"]["least"] <= document["expected"]["hold"] <= document["expected"]["most"]
    first = document["claims"][0]["conditions"]["light spheres"]
    assert (first["n"], first["successes"], first["rate"]) == (20, 20, 1.0)
    assert 0.8 < first["ci_low"] < 0.9
    assert document["seeds_from"] == 0
    assert document["attempts"] == 20 * document["conditions"]


def test_every_printed_number_stands_beside_the_models(written):
    beside = {row["id"]: row for row in written[1]["paper_beside_model"]}
    assert list(beside) == list(printed_numbers())
    assert beside["hand-cylinder"]["value"] == 1.0
    assert beside["hand-cylinder"]["p"] == 1.0
    assert beside["push-usual"]["value"] == 0.5
    assert beside["push-usual"]["p"] == pytest.approx(fisher_exact([[10, 12], [10, 8]]).pvalue)
    assert beside["grid-cube"]["p"] > 0.99
    assert beside["order-cylinder"]["value"] == 9.0
    assert all(0.0 <= row["p"] <= 1.0 and row["ci_low"] <= row["value"] <= row["ci_high"] for row in beside.values())


def test_every_experiment_has_its_figure_as_svg_and_png(written):
    folder, document = written
    assert list(document["figures"]) == list(EXPERIMENTS)
    for files in document["figures"].values():
        svg, png = (folder / file for file in files)
        assert "<svg" in svg.read_text()
        assert "#01020" not in svg.read_text()
        assert png.read_bytes().startswith(PNG)


class _Page(HTMLParser):
    """Collects names, links and text."""

    def __init__(self):
        super().__init__()
        self.names, self.links = [], []

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.names += [values["id"]] if "id" in values else []
        self.links += [value for key, value in attributes if key in ("href", "src")]


def test_the_page_loads_nothing_and_its_ids_are_unique(written):
    text = (written[0] / "index.html").read_text()
    page = _Page()
    page.feed(text)
    assert len(page.names) == len(set(page.names))
    inside = {link[1:] for link in page.links if link.startswith("#")}
    assert inside <= set(page.names)
    outside = {link for link in page.links if not link.startswith(("#", "data:"))}
    assert outside
    assert all((written[0] / link).is_file() for link in outside)
    assert not re.findall(r"https?://", text)
    assert "&lt;here&gt; &amp; there" in text
    assert "#01020" not in text


def test_the_page_begins_with_verdicts_then_paper_beside_model_then_nulls_then_claims(written):
    text = (written[0] / "index.html").read_text()
    lead = text[text.index('class="lead"') : text.index('class="note"')]
    assert "13 of 13 claims that test the model hold" in lead
    assert "what the model was fitted to" in lead
    places = [text.index(mark) for mark in ('class="tiles"', 'id="beside"', 'id="N1"', 'id="C1"', 'id="fig06"')]
    assert places == sorted(places)
    assert "calibrated: holds" in text
    assert "repeats 100 %" in text


def test_a_partial_study_shows_counts_and_no_verdict(tmp_path):
    spoilt = [(strategy_pair("cylinder", "wall")[0], {"rate": 0.5})]
    with fill(tmp_path, lambda condition: condition == strategy_pair("cylinder", "wall")[0], spoilt) as store:
        document = write_results(store, "command", 0, attempts=20, recordings=False)
    assert list(document["figures"]) == ["fig06"]
    rows = (*document["claims"], *document["nulls"])
    assert {row["verdict"] for row in rows} == {row["repeats"] for row in rows} == {None}
    assert {part["verdict"] for row in rows for part in row["parts"]} == {None}
    assert document["claims"][3]["conditions"]["cylinders, wall, pile-based"]["successes"] == 10
    text = (tmp_path / "index.html").read_text()
    assert "attempts are missing, so there is no verdict yet" in text


def test_a_claim_that_does_not_hold_shows_its_explanation(tmp_path, monkeypatch):
    file = tmp_path / "explanations.toml"
    file.write_text('[C1]\ntext = "It holds."\n[C7]\ntext = "Because <of> it."\ncommand = "pilegrasp run this"\n')
    monkeypatch.setattr(ledger, "EXPLANATIONS", file)
    spoilt = [(spheres(0.06, "corner", HAND, 5), {"rate": 0.5})]
    with fill(tmp_path / "study", spoilt=spoilt) as store:
        evidence = gather_evidence(store)
    rows = ledger.ledger_documents(ledger.judge_claims(evidence, draws=2).entries)
    assert (rows[0]["verdict"], rows[0]["shown_by"]) == ("holds", "")
    assert (rows[6]["verdict"], rows[6]["shown_by"]) == ("fails", "pilegrasp run this")
    assert rows[6]["explanation"].endswith("Because <of> it.")


@pytest.mark.browser
@pytest.mark.skipif(find_chromium() is None, reason="no Chromium")
@pytest.mark.parametrize("width", [390, 1280])
def test_the_page_fits_the_screen_without_browser_errors(written, width):
    with Browser(find_chromium()) as browser:
        browser.open(written[0] / "index.html", width, 900)
        assert browser.evaluate("document.documentElement.scrollWidth") <= width
        assert browser.console_errors() == []
        assert browser.evaluate("document.querySelectorAll('article').length") == 20
