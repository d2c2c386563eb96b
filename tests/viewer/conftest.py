"""A browser for all tests of the viewer, and the page of an attempt that is open in it."""

from __future__ import annotations

import os

import pytest

from browser import Browser, find_chromium
from pilegrasp_ctrl.viewer import write_html
from synthetic_recording import synthetic


@pytest.fixture(scope="session")
def chromium():
    executable = find_chromium()
    if executable is None:
        reason = "Chromium is not installed; install it or name one in PILEGRASP_CHROMIUM"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    return executable


@pytest.fixture(scope="session")
def only_browser(chromium):
    with Browser(chromium) as process:
        yield process


@pytest.fixture(scope="module")
def browser(only_browser):
    """The browser, which shows nothing after a module: a page that plays on would slow down all other tests."""
    yield only_browser
    only_browser.call("Page.navigate", url="about:blank")


@pytest.fixture(scope="module")
def attempt():
    return synthetic(motion={"separated": {"object": "light_sphere_01", "time": 5.5}})


@pytest.fixture(scope="module")
def file(attempt, tmp_path_factory):
    path = tmp_path_factory.mktemp("pages") / "attempt.html"
    write_html(attempt, path)
    return path


@pytest.fixture(scope="module")
def opened(browser, file):
    """The page, loaded once; it has begun to play by itself."""
    browser.open(file)
    browser.wait_for("pilegrasp.playing() && pilegrasp.time() > 0.2")
    return browser


@pytest.fixture
def paused(opened):
    opened.resize(1280, 800)
    opened.evaluate("pilegrasp.pause(); pilegrasp.seek(0); document.getElementById('reframe').click()")
    return opened
