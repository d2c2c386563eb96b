"""The site is built without a warning, its links lead somewhere, and its search answers questions from the disk."""

import os
import subprocess
import sys
import time

import pytest

import pilegrasp_ctrl as pg
from browser import Browser, find_chromium
from check import problems
from links import for_site, shown_file
from pilegrasp_ctrl.config import dotted_keys
from places import DOCS, ROOT
from reference import API, generated_pages, public_names

QUESTIONS = {
    "what does theta mean": "questions.html",
    "which key makes the arm push harder": "questions.html",
    "why did it end": "questions.html",
    "own arm urdf": "how-to/own-arm.html",
    "tune gains": "how-to/tune.html",
    "strategy.alpha_deg": "reference/keys.html",
    "to_dataframe": "reference/api/attempts-and-recordings.html",
    "sweep jobs": "reference/command-line.html",
    "recording format npz": "file-formats.html",
    "same seed same result": "numerics.html",
    "friction of joints": "disturbances.html",
    "certificates cluster": "cluster.html",
}
"""Questions of readers, and the page that must be among the first results."""

RESULTS = """[...document.querySelectorAll(".md-search-result__item a")].map((link) => link.href)"""
"""Script that returns the addresses of what was found, the best first."""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    configuration = str(DOCS / "site" / "mkdocs.yml")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", configuration, "-d", str(folder)]
    environment = os.environ | {"PYTHONPATH": str(ROOT), "NO_MKDOCS_2_WARNING": "true"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.slow
def test_every_link_leads_somewhere_and_nothing_is_loaded_from_elsewhere(site):
    assert problems(site) == []


@pytest.mark.slow
def test_the_checker_finds_what_is_wrong(site):
    page = site / "conventions.html"
    text = page.read_text(encoding="utf-8")
    wrong = (
        '<p>first:\n- one</p><a href="nowhere.html">x</a><a href="control.html#none">x</a>'
        '<script src="https://a.b/c.js"></script>'
    )
    page.write_text(text.replace("</article>", f"{wrong}</article>"), encoding="utf-8")
    found = [sentence for sentence in problems(site) if sentence.startswith("conventions")]
    page.write_text(text, encoding="utf-8")
    assert len(found) == 4
    assert any("nowhere.html" in sentence for sentence in found)


@pytest.mark.slow
@pytest.mark.browser
def test_the_search_answers_questions_from_the_disk(site):
    with Browser(find_chromium(), timeout=240.0) as browser:
        browser.open(site / "index.html")
        for question, page in QUESTIONS.items():
            assert page in _first_pages(browser, site, question), question
        assert browser.console_errors() == []
        assert [address for address in browser.requests() if not address.startswith(("file:", "data:"))] == []


def _first_pages(browser, site, question):
    """Return the pages among the results of a search, the best first."""
    browser.evaluate(
        f"""(() => {{
          const field = document.querySelector("input[name=query]");
          document.querySelectorAll(".md-search-result__item").forEach((item) => item.remove());
          field.focus();
          field.value = {question!r};
          field.dispatchEvent(new Event("input", {{bubbles: true}}));
          field.dispatchEvent(new KeyboardEvent("keyup", {{bubbles: true}}));
        }})()"""
    )
    last, patience = None, time.monotonic() + 120.0
    while time.monotonic() < patience:
        time.sleep(0.7)
        found = browser.evaluate(RESULTS)
        if found and found == last:
            break
        last = found
    pages = [address.partition(site.name + "/")[2].partition("?")[0].partition("#")[0] for address in found]
    return list(dict.fromkeys(pages))[:5]


def test_every_public_name_is_on_one_page_of_the_api():
    listed = [name for title in API for name in public_names(title)]
    assert sorted(listed) == sorted(set(dir(pg)) - {"__version__"})


def test_every_key_and_every_verb_has_a_section():
    pages = generated_pages()
    assert [key for key in dotted_keys() if f"\n### `{key}`\n" not in pages["reference/keys.md"]] == []
    for verb in ("run", "sweep", "paper", "tune", "doctor"):
        assert f"\n## pilegrasp {verb}\n" in pages["reference/command-line.md"]
    assert "--seed" in pages["reference/command-line.md"]


def test_a_link_to_code_leads_to_its_line():
    text = for_site('[law](../pilegrasp_ctrl/kernels/frame.py#L46 "scale")', DOCS / "control.md")
    assert text == '[law](source/pilegrasp_ctrl/kernels/frame.py.md#__codelineno-0-46 "scale")'
    with pytest.raises(FileNotFoundError, match="leads to no file"):
        for_site("[gone](gone.md)", DOCS / "control.md")
    assert shown_file(ROOT / "Makefile").startswith("---\nsearch:\n  exclude: true\n---\n# `Makefile`\n")
