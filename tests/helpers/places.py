"""Folders that tests read from."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
STUDIES = DOCS / "studies"
DATA = ROOT / "tests" / "data"
