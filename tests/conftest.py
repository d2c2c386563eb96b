"""Settings of all tests: one core for each process, and a skip if there is no browser."""

import os

import pytest

from pilegrasp_ctrl.plugins import plugin_folders, use_plugins
from pilegrasp_ctrl.viewer.pictures.chromium import find_chromium

# Each test process keeps to one core: the linear algebra here is far too small to gain from threads.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


def pytest_collection_modifyitems(items):
    """Skip the tests that need a browser if there is none; CI must have one."""
    if find_chromium() is not None:
        return
    shown = [item for item in items if item.get_closest_marker("browser")]
    if shown and os.environ.get("CI"):
        raise pytest.UsageError("the tests of pages need a Chromium; install the package chromium")
    for item in shown:
        item.add_marker(pytest.mark.skip(reason="there is no Chromium, in which pages are tested"))


@pytest.fixture(autouse=True)
def no_plugins():
    """Forget the folders of plugins that a test has named."""
    before = plugin_folders()
    yield
    if plugin_folders() != before:
        use_plugins(before)
