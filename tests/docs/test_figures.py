"""The numbers in the pages agree with their sources."""

import pytest

from figures import QUICK, figures, select

QUICK_ONES = [figure for figure in figures() if figure.seconds <= QUICK]


@pytest.mark.parametrize("figure", figures(), ids=lambda figure: figure.name)
def test_a_page_shows_each_figure_once_and_names_its_source(figure):
    assert figure.shown()
    assert (figure.command is None) != (figure.file is None)


@pytest.mark.slow
@pytest.mark.parametrize("figure", QUICK_ONES, ids=lambda figure: figure.name)
def test_a_quick_figure_equals_a_new_measurement(figure):
    number = figure.measure()
    assert figure.agrees(number), f"{figure.page} shows {figure.shown()}, now it is {number}; `make figures` writes it"


def test_an_entry_of_a_list_is_chosen_by_its_values():
    document = {"claims": [{"id": "C1", "n": 3}, {"id": "C2", "n": 4}]}
    assert select(document, ["claims", {"id": "C2"}, "n"]) == 4
    assert select(document, ["claims", 0, "id"]) == "C1"
