"""The page's controls in a real browser: keyboard, names, clock, layout on every screen, curves, paper."""

from __future__ import annotations

import base64
from dataclasses import replace

import numpy as np
import pytest

from pilegrasp_ctrl.viewer import write_html
from synthetic_order import synthetic_order
from synthetic_recording import synthetic

pytestmark = [pytest.mark.browser, pytest.mark.slow]

PRESS = (
    "document.activeElement.dispatchEvent(new KeyboardEvent('keydown', {key: KEY, bubbles: true, cancelable: true}))"
)

TAB_STOPS = """(() => {
  const usual = "a[href], button, input, select, summary, [tabindex]";
  return [...document.querySelectorAll(usual)]
    .filter((one) => one.tabIndex >= 0 && !one.disabled && one.checkVisibility() && one.getBoundingClientRect().width)
    .map((one) => ({
      id: one.id,
      name: (one.getAttribute("aria-label") ?? one.closest("label")?.textContent ?? one.textContent ?? "").trim(),
    }));
})()"""

OVERLAPS = """(() => {
  const elsewhere = "script, style, option, .unseen, #bar, .bar, svg";
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const boxes = [];
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement;
    if (!node.textContent.trim() || !element.checkVisibility() || element.closest(elsewhere)) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    const text = node.textContent.trim().slice(0, 30);
    for (let { left, top, right, bottom } of range.getClientRects()) {
      // What a box cuts off is not seen.
      for (let up = element; up; up = up.parentElement) {
        if (getComputedStyle(up).overflowX === "visible") continue;
        const box = up.getBoundingClientRect();
        [left, right] = [Math.max(left, box.left), Math.min(right, box.right)];
        [top, bottom] = [Math.max(top, box.top), Math.min(bottom, box.bottom)];
      }
      if (right - left > 1 && bottom - top > 1) boxes.push({ text, left, top, right, bottom, element });
    }
  }
  const found = [];
  for (let a = 0; a < boxes.length; a++) {
    for (let b = a + 1; b < boxes.length; b++) {
      const [one, two] = [boxes[a], boxes[b]];
      if (one.element === two.element) continue;
      const across = Math.min(one.right, two.right) - Math.max(one.left, two.left);
      const along = Math.min(one.bottom, two.bottom) - Math.max(one.top, two.top);
      if (across > 1.5 && along > 3.5) found.push(`${one.text} | ${two.text}`);
    }
  }
  return found;
})()"""


@pytest.fixture(scope="module")
def order_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("orders") / "order.html"
    write_html(synthetic_order(), path)
    return path


@pytest.fixture(scope="module")
def long_name_file(tmp_path_factory):
    plain = synthetic()
    rows = [dict(row) | {"name": "a_primitive_with_a_name_of_forty_letters"} for row in plain.meta["outcomes"]]
    path = tmp_path_factory.mktemp("names") / "names.html"
    write_html(replace(plain, meta={**plain.meta, "outcomes": rows}), path)
    return path


def press(browser, key):
    browser.evaluate(PRESS.replace("KEY", repr(key)))


def test_play_is_reached_within_eight_stops_and_everything_has_a_name(paused):
    stops = paused.evaluate(TAB_STOPS)
    assert "play" in [stop["id"] for stop in stops[:8]]
    assert all(stop["name"] for stop in stops)
    nameless = paused.evaluate("""[...document.querySelectorAll("input, select, button")].filter((one) =>
      !one.getAttribute("aria-label") && !one.closest("label") && !one.textContent.trim()).length""")
    assert nameless == 0


def test_nothing_is_announced_while_the_page_plays(paused):
    live = paused.evaluate(
        """[...document.querySelectorAll("output, [aria-live], [role=status]")].map((one) => one.id)"""
    )
    assert live == ["said"]
    paused.evaluate("pilegrasp.seek(1); document.getElementById('said').textContent = ''; pilegrasp.play()")
    paused.wait_for("pilegrasp.time() > 1.2")
    assert paused.evaluate("document.getElementById('said').textContent") == ""
    paused.evaluate("pilegrasp.seek(5)")
    assert paused.evaluate("document.getElementById('scrub').getAttribute('aria-valuetext')").startswith(
        "5.00 s · push"
    )


def test_the_keys_go_from_event_to_event(paused):
    times = paused.evaluate("pilegrasp.panels[0].data.events.map(({ time }) => time)")
    said = []
    for expected in sorted(times)[:3]:
        press(paused, ".")
        assert paused.evaluate("pilegrasp.time()") == pytest.approx(expected, abs=1e-3)
        said.append(paused.evaluate("document.getElementById('said').textContent"))
    assert said[1] == "5.50 s: light sphere 01 separates from the pile"
    press(paused, ",")
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(times[1], abs=1e-3)


def test_a_slow_page_keeps_time_or_says_that_it_does_not(paused):
    paused.evaluate("""(() => {
      // Every picture costs a fifth of a second.
      window.slowed = pilegrasp.viewer.render;
      pilegrasp.viewer.render = () => {
        const since = performance.now();
        while (performance.now() - since < 200);
        slowed();
      };
      pilegrasp.seek(1);
      pilegrasp.play();
    })()""")
    # The clock starts with the first picture, so the measurement does, too.
    paused.wait_for("pilegrasp.time() > 1")
    paused.evaluate("(() => { window.begun = [performance.now(), pilegrasp.time()]; })()")
    paused.wait_for("performance.now() - begun[0] > 2500")
    moved, elapsed = paused.evaluate("[pilegrasp.time() - begun[1], (performance.now() - begun[0]) / 1000]")
    hidden = paused.evaluate("document.getElementById('rate').hidden")
    paused.evaluate("pilegrasp.pause(); pilegrasp.viewer.render = slowed")
    assert abs(moved / elapsed - 1.0) < 0.35 or not hidden


def test_a_reader_who_wants_less_motion_starts_the_page_himself(browser, file):
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-reduced-motion", "value": "reduce"}])
    browser.call("Page.navigate", url=file.resolve().as_uri())
    browser.wait_for("document.readyState === 'complete' && Boolean(window.pilegrasp)")
    browser.evaluate("pilegrasp.drawn")
    assert browser.evaluate("[pilegrasp.playing(), pilegrasp.time()]") == [False, 0.0]
    browser.call("Emulation.setEmulatedMedia", features=[])


@pytest.mark.parametrize("which", ["file", "order_file", "long_name_file"])
def test_no_text_lies_on_another_and_the_time_axis_is_above_the_controls(browser, request, which):
    browser.open(request.getfixturevalue(which), 1400, 900)
    browser.evaluate("pilegrasp.ready.then(() => pilegrasp.seek(9))")
    for width, height in ((1400, 900), (1366, 768), (390, 844)):
        browser.resize(width, height)
        browser.wait_for_picture()
        assert browser.evaluate(OVERLAPS) == []
        assert browser.evaluate("document.documentElement.scrollWidth") <= width
        if width > 390 and which != "long_name_file":
            axis, bar, page = browser.evaluate("""[document.querySelector(".ticks").getBoundingClientRect().bottom,
              document.getElementById("bar").getBoundingClientRect().top, document.documentElement.scrollHeight]""")
            assert axis <= bar + 1
            assert page <= height + 1


def test_a_phone_has_every_control(browser, file):
    browser.open(file, 390, 844)
    browser.evaluate("pilegrasp.ready.then(() => pilegrasp.pause())")
    browser.evaluate("document.getElementById('more').click()")
    outside = browser.evaluate("""[...document.querySelectorAll("#bar button, #bar input, #bar select")]
      .filter((one) => !one.closest(".menu") && !one.closest("label[hidden]"))
      .map((one) => [one.id || one.dataset.overlay, one.getBoundingClientRect()])
      .filter(([, box]) => !box.width || box.left < 0 || box.right > 390 || box.top < 0 || box.bottom > 844)
      .map(([name]) => name)""")
    assert outside == []
    # The close-up lies neither on the hand of the whole picture nor on the card of a chosen body.
    browser.evaluate("pilegrasp.seek(7); pilegrasp.panels[0].choose(pilegrasp.panels[0].data.objects[0])")
    left, width, seen, card = browser.evaluate("""(() => {
      const { data, viewer, cameras } = pilegrasp.panels[0];
      viewer.render();
      viewer.camera.updateMatrixWorld();
      const [x, y, z] = data.tool[Math.floor(0.7 * data.tool.length)];
      const pane = document.querySelector(".pane").getBoundingClientRect();
      const across = (0.5 + 0.5 * new meshcat.THREE.Vector3(x, z, -y).project(viewer.camera).x) * pane.width;
      const [left, , width] = cameras.places()[1];
      const card = document.querySelector(".card").getBoundingClientRect();
      return [left, width, across, [card.left - pane.left, card.right - pane.left]];
    })()""")
    assert not left <= seen <= left + width
    assert min(card[1], left + width) - max(card[0], left) <= 1


def test_values_follow_the_cursor_and_the_mouse(paused, attempt):
    value = "document.querySelector('[data-lane=force] .key.c0 .value').textContent"
    force, time = attempt.signals["push_force"], attempt.signal_time
    for moment in (4.0, 6.2):
        paused.evaluate(f"pilegrasp.seek({moment})")
        shown = float(paused.evaluate(value).replace("−", "-"))
        assert shown == pytest.approx(force[np.searchsorted(time, moment + 1e-9) - 1], abs=0.06)
    box = paused.evaluate("document.querySelector('.over').getBoundingClientRect().toJSON()")
    x, y = box["left"] + 0.3 * box["width"], box["top"] + 60
    paused.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
    shown = float(paused.evaluate(value).replace("−", "-"))
    assert shown == pytest.approx(np.interp(3.0, time, force), abs=1.5)
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(6.2)
    paused.call("Input.dispatchMouseEvent", type="mouseMoved", x=5, y=5)


def test_curves_can_be_zoomed_and_chosen(paused):
    paused.evaluate("pilegrasp.seek(5); pilegrasp.zoom(0.2)")
    assert paused.evaluate("pilegrasp.panels[0].timeline.window()") == pytest.approx([4.0, 6.0])
    ticks = paused.evaluate("[...document.querySelectorAll('.tx')].map((one) => Number(one.textContent)).sort()")
    assert (ticks[0], ticks[-1]) == (4.0, 6.0)
    points = paused.evaluate("document.querySelector('[data-lane=force] polyline.c0').getAttribute('points')")
    # Two seconds of 100 Hz between the picture's edges.
    inside = [float(point.split(",")[0]) for point in points.split()]
    assert sum(0 <= x <= 1000 for x in inside) == pytest.approx(200, abs=3)
    paused.evaluate("pilegrasp.seek(9)")
    first, last = paused.evaluate("pilegrasp.panels[0].timeline.window()")
    assert first <= 9.0 <= last
    paused.evaluate("pilegrasp.zoom(1e6); document.querySelector('[data-signal=q]').click()")
    lane = "document.querySelector('[data-lane=q]')"
    assert paused.evaluate(f"{lane}.checkVisibility()") is True
    assert paused.evaluate(f"{lane}.querySelectorAll('polyline[points]:not([points=\"\"])').length") == 7
    paused.evaluate("document.querySelector('[data-signal=q]').click()")
    assert paused.evaluate(f"{lane}.checkVisibility()") is False


def test_only_the_present_attempt_is_open_and_has_its_path(browser, order_file):
    browser.open(order_file)
    browser.evaluate("pilegrasp.ready.then(() => pilegrasp.pause())")
    paths = """Object.values(pilegrasp.viewer.scene_tree.find(["Overlays", "paths"]).children)
      .map((one) => one.object.visible)"""
    for moment, number in ((5.0, 0), (17.0, 1), (30.0, 2)):
        browser.evaluate(f"pilegrasp.seek({moment})")
        closed = browser.evaluate(
            "[...document.querySelectorAll('tbody.attempt')].map((one) => one.classList.contains('closed'))"
        )
        assert closed == [k != number for k in range(3)]
        assert browser.evaluate(paths) == [k == number for k in range(3)]
        assert f"attempt {number + 1} · " in browser.evaluate("document.querySelector('.moment').textContent")


def test_paper_shows_scene_curves_and_tables_without_controls(browser, order_file):
    browser.open(order_file)
    browser.evaluate("pilegrasp.ready.then(() => pilegrasp.seek(9)); window.dispatchEvent(new Event('beforeprint'))")
    assert browser.evaluate("document.querySelector('.printed').src.length") > 10_000
    browser.call("Emulation.setEmulatedMedia", media="print")
    seen = browser.evaluate("""["#bar", ".printed", ".plot", "tr.primitive", ".help"].map((name) =>
      [...document.querySelectorAll(name)].some((one) => one.checkVisibility()))""")
    assert seen == [False, True, True, True, False]
    assert browser.evaluate("[...document.querySelectorAll('tr.primitive')].every((one) => one.checkVisibility())")
    assert len(base64.b64decode(browser.call("Page.printToPDF", printBackground=True)["data"])) > 20_000
    browser.call("Emulation.setEmulatedMedia", media="")
