"""The notebook runs from top to bottom, in an empty folder, and shows what it says."""

import os

import nbformat
import pytest
from nbclient import NotebookClient

from places import DOCS, ROOT


@pytest.mark.slow
def test_the_notebook_runs_and_shows_page_and_plots(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]))
    notebook = nbformat.read(DOCS / "notebooks" / "first_attempt.ipynb", as_version=4)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 2
    assert any("first_attempt.html" in output.get("data", {}).get("text/html", "") for output in outputs)
    assert (tmp_path / "first_attempt.html").stat().st_size > 100_000
