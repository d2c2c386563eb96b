"""The table of licences is complete, agrees with what is installed, and has no GPL among the library's packages."""

import re
from importlib.metadata import PackageNotFoundError, distribution

import pytest

from licence_table import PAGE, STATED, licence, needs, packages, requirements, uses

ROWS = [
    tuple(cell.strip() for cell in line.strip("|").split("|"))
    for line in PAGE.read_text(encoding="utf-8").splitlines()
    if line.startswith("| ") and not line.startswith("| package")
]


def test_every_pinned_and_every_named_package_has_one_row_with_a_licence():
    assert sorted(name for name, _, _ in ROWS) == sorted(packages().values())
    assert all(re.search(r"\w", found) for _, found, _ in ROWS)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_the_licence_is_that_of_the_installed_package(row):
    name, stated, _ = row
    try:
        distribution(name)
    except PackageNotFoundError:
        if name not in STATED:
            pytest.skip("not installed")
    assert stated == licence(name)


def test_the_gpl_comes_with_an_extra_or_checks_the_spelling():
    copyleft = {name for name, found, _ in ROWS if re.search(r"\bA?GPL", found)}
    assert copyleft == {"codespell", "imageio-ffmpeg", "quadprog"}
    assert not copyleft & needs(requirements()["library"])
    assert {uses()[name] for name in copyleft} == {"extra quadprog", "extra movie", "tests"}
    for name, found, use in ROWS:
        if name in copyleft - {"codespell"}:
            assert use.startswith("extra "), found
