"""The pages are short, their sentences too, and no line of them needs scrolling."""

import pytest

from places import ROOT
from prose import measure, pages, sentences


@pytest.mark.parametrize("page", [pytest.param(page, id=page.relative_to(ROOT).as_posix()) for page in pages()])
def test_a_page_keeps_the_rules_of_prose(page):
    faults = measure(page).faults()
    assert not faults, f"`python tests/helpers/prose.py {page.relative_to(ROOT)}` shows the longest sentence"


def test_a_sentence_is_counted_without_links_code_and_tables():
    page = '# A heading\n\nTwo words. Three [more words](of/a/link.md "with a title").\n\n- an item\n- `code f()`\n'
    assert sentences(page) == ["Two words.", "Three more words.", "an item", "`code f()`"]


def test_a_page_that_breaks_each_rule_is_found(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(f"{'word ' * 2600}\n\n{'a' * 130}\n\nMeasured at 9ab13bf.\n\n| {'c' * 130} |\n")
    words, mean, lines, revisions = measure(page).faults()
    assert "2600 words" in words or "words, at most" in words
    assert "a sentence" in mean
    assert lines.endswith("1, 3")
    assert revisions.endswith("9ab13bf")
