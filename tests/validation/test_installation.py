"""`pilegrasp doctor` finds what the rest of the library finds, and names what is missing."""

import pytest

from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.validation import installation


def test_the_browser_is_the_one_that_the_viewer_finds(monkeypatch):
    monkeypatch.setenv("PILEGRASP_CHROMIUM", "/opt/browser")
    check = installation._browser()
    assert (check.ok, check.detail, check.required) == (True, "/opt/browser", False)


def test_a_check_that_raises_has_failed_and_says_why():
    def missing():
        raise PilegraspError("is not installed; pip install x")

    check = installation._check("x", missing)
    assert (check.ok, check.detail) == (False, "is not installed; pip install x")


@pytest.mark.parametrize("name", installation.SOLVERS)
def test_every_solver_solves_the_test_problem(name):
    assert installation._solver(name) == "solves a test problem"
