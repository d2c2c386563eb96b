"""What the driver of Chromium does while pages change under it."""

import pytest

from browser import Browser


@pytest.mark.browser
def test_waiting_goes_on_when_another_page_takes_the_place_of_this_one(chromium, tmp_path):
    second = tmp_path / "second.html"
    second.write_text("<title>second</title>", encoding="utf-8")
    (tmp_path / "first.html").write_text("<title>first</title>", encoding="utf-8")
    leave = f"new Promise(() => {{ location.href = {second.as_uri()!r}; }})"
    with Browser(chromium) as browser:
        browser.open(tmp_path / "first.html")
        browser.wait_for(f"document.title === 'second' || {leave}")
        assert browser.evaluate("document.title") == "second"
