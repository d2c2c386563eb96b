"""The ledger as files: JSON, page and figures, from a synthetic store."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from browser import Browser, find_chromium
from paper_world import rows as made
from paper_world import standard, usual
from pilegrasp_ctrl.scenarios.paper import ledger
from pilegrasp_ctrl.scenarios.paper.conditions import SHOVEL, grasp
from pilegrasp_ctrl.scenarios.paper.figures_objects import strategy_pair
from pilegrasp_ctrl.scenarios.paper.plan import EXPERIMENTS
from pilegrasp_ctrl.scenarios.paper.run import write_results
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
        document = write_results(store, "pilegrasp paper all --out <here> & there", 10_000, recordings=False)
    return folder, document


def test_the_document_is_what_was_returned_and_holds_every_claim(written):
    folder, document = written
    assert json.loads((folder / "claims.json").read_text()) == document
    assert [claim["id"] for claim in document["claims"]] == [f"C{k}" for k in range(1, 17)]
    assert {claim["verdict"] for claim in document["claims"]} == {"holds"}
    first = document["claims"][0]["conditions"]["light spheres"]
    assert (first["n"], first["successes"], first["rate"]) == (20, 20, 1.0)
    assert 0.8 < first["ci_low"] < 0.9
    assert document["seeds_from"] == 10_000
    assert document["attempts"] == 20 * document["conditions"]


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


def test_an_experiment_that_was_not_run_has_no_figure(tmp_path):
    with fill(tmp_path, lambda condition: condition == strategy_pair("cylinder", "wall")[0]) as store:
        document = write_results(store, "command", 0, recordings=False)
    assert list(document["figures"]) == ["fig06"]
    assert [claim["id"] for claim in document["claims"] if claim["verdict"] != "not decided"] == ["C12", "C16"]


def test_a_claim_that_does_not_hold_shows_its_explanation(tmp_path, monkeypatch):
    file = tmp_path / "explanations.toml"
    file.write_text('[C1]\ntext = "Not run."\n[C3]\ntext = "Because <of> it."\ncommand = "pilegrasp run this"\n')
    monkeypatch.setattr(ledger, "EXPLANATIONS", file)
    spoilt = [(grasp("light_sphere", "wall", SHOVEL), {"rate": 0.5})]
    with fill(tmp_path / "study", lambda condition: condition.scenario.hand == "shovel", spoilt) as store:
        document = write_results(store, "command", 0, recordings=False)
    first, _, third, *_ = document["claims"]
    assert (first["verdict"], first["explanation"]) == ("not decided", "Not run.")
    assert (third["verdict"], third["shown_by"]) == ("fails", "pilegrasp run this")
    assert third["explanation"].endswith("Because <of> it.")
    page = (tmp_path / "study" / "index.html").read_text()
    assert "Because &lt;of&gt; it." in page
    assert "pilegrasp run this" in page


@pytest.mark.browser
@pytest.mark.skipif(find_chromium() is None, reason="no Chromium")
@pytest.mark.parametrize("width", [390, 1280])
def test_the_page_fits_the_screen_without_browser_errors(written, width):
    with Browser(find_chromium()) as browser:
        browser.open(written[0] / "index.html", width, 900)
        assert browser.evaluate("document.documentElement.scrollWidth") <= width
        assert browser.console_errors() == []
        assert browser.evaluate("document.querySelectorAll('article').length") == 16
