"""What leaves a page: its address, the command of the attempt, the recording, curves, a picture; and notebooks."""

from __future__ import annotations

import base64
import html
import json
import re
import shlex
from dataclasses import replace

import numpy as np
import pytest

from pilegrasp_ctrl import cli
from pilegrasp_ctrl.config import load_scenario, parse_overrides
from pilegrasp_ctrl.exceptions import ArgumentError
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.viewer.page.command import repeat_command
from pilegrasp_ctrl.viewer.page.document import page


def meta(**overrides):
    scenario = load_scenario("spheres_wall", overrides)
    return {"scenario": "spheres_wall", "seed": 7, "config": json.loads(scenario.model_dump_json())}


def test_the_command_repeats_the_attempt():
    changed = {"pile.count": 5, "strategy.speed": 0.25, "hand": "shovel", "pile.object": "light_sphere+cube"}
    words = shlex.split(repeat_command(meta(**changed)))
    assert words[:5] == ["pilegrasp", "run", "spheres_wall", "--seed", "7"]
    again = load_scenario("spheres_wall", parse_overrides(words[6::2]))
    assert again == load_scenario("spheres_wall", changed)
    assert repeat_command(meta()) == "pilegrasp run spheres_wall --seed 7"


@pytest.mark.parametrize(
    "odd",
    [
        {"scenario": "/etc/passwd"},
        {"scenario": "$(reboot)"},
        {"seed": "1; reboot"},
        {"config": {"pile": 3}},
        {"config": {"hand": "$(reboot)"}},
        {"config": None},
    ],
)
def test_a_recording_that_no_command_repeats_has_none(odd):
    assert repeat_command(meta() | odd) == ""


def test_values_are_quoted_for_a_shell():
    words = repeat_command(meta(**{"pile.object": "x;reboot $(reboot).toml"}))
    assert shlex.split(words)[-1] == "pile.object=x;reboot $(reboot).toml"


def test_a_page_can_hold_the_recording(attempt, tmp_path):
    attempt.save(tmp_path / "a.npz")
    assert cli.main(["export", str(tmp_path / "a.npz"), str(tmp_path / "a.html"), "--embed-recording"]) == 0
    document = (tmp_path / "a.html").read_text(encoding="utf-8")
    (block,) = re.findall(r'<script type="application/octet-stream" class="recording">(.*?)</script>', document)
    (tmp_path / "b.npz").write_bytes(base64.b64decode(block))
    assert Recording.load(tmp_path / "b.npz").to_bytes() == attempt.to_bytes()


def test_a_page_links_to_the_recording_beside_it(attempt, tmp_path):
    (tmp_path / "in it").mkdir()
    attempt.save(tmp_path / "in it" / "a #1.npz")
    assert cli.main(["export", str(tmp_path / "in it" / "a #1.npz"), str(tmp_path / "a.html")]) == 0
    document = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert '<a href="in%20it/a%20%231.npz" download>' in document
    assert 'class="recording"' not in document


@pytest.mark.parametrize("name", ["a.png", "a.csv"])
def test_only_a_page_holds_the_recording(attempt, tmp_path, capsys, name):
    attempt.save(tmp_path / "a.npz")
    assert cli.main(["export", str(tmp_path / "a.npz"), str(tmp_path / name), "--embed-recording"]) == 2
    assert "--embed-recording is for pages (.html)" in capsys.readouterr().err


def test_a_recording_shows_itself_in_a_notebook(attempt):
    shown = attempt._repr_html_()
    (document,) = re.findall(r'<iframe srcdoc="(.*?)" style', shown, flags=re.DOTALL)
    assert html.unescape(document) == page(attempt, compact=True)


def test_a_recording_plots_its_curves(attempt):
    axes = attempt.plot("force", "closure").axes
    assert [axis.get_ylabel() for axis in axes] == ["force [N]", "closure [%]"]
    force = attempt.signals["push_force"]
    assert any(np.array_equal(line.get_ydata(), force.astype(float)) for line in axes[0].get_lines())
    with pytest.raises(ArgumentError, match="no curves 'forces'; it has force"):
        attempt.plot("forces")


@pytest.mark.browser
def test_an_address_opens_the_page_at_its_moment_view_and_overlays(browser, attempt, tmp_path):
    (tmp_path / "a.html").write_text(page(replace(attempt, meta=dict(attempt.meta) | meta())), encoding="utf-8")
    browser.open(tmp_path / "a.html")
    browser.wait_for("pilegrasp.ready.then(() => true)")
    browser.evaluate("pilegrasp.pause(), pilegrasp.seek(2.5), pilegrasp.setCamera('above')")
    for name in ("contacts", "wrench"):
        browser.evaluate(f"document.querySelector('[data-overlay={name}]').click()")
    link = browser.evaluate("pilegrasp.link()")
    assert "t=2.500&cam=above" in link
    browser.call("Page.navigate", url="about:blank")
    browser.call("Page.navigate", url=link)
    browser.wait_for("Boolean(window.pilegrasp && window.pilegrasp.viewer) && !pilegrasp.playing()")
    browser.wait_for("pilegrasp.time() > 2.4")
    assert browser.evaluate("pilegrasp.state()") == link.split("#")[1]
    # An address that names nothing known changes nothing.
    browser.evaluate("location.hash = 't=x&cam=nowhere&show=wrench'")
    browser.wait_for("pilegrasp.state().includes('show=wrench&')")
    assert "t=2.500&cam=above" in browser.evaluate("pilegrasp.state()")
    browser.evaluate("document.querySelector('[data-share=command]').click()")
    assert browser.evaluate("document.getElementById('copied').value") == "pilegrasp run spheres_wall --seed 7"
    lines = browser.evaluate("pilegrasp.csv(pilegrasp.panels[0])").splitlines()
    assert lines[0].startswith('"time [s]","force: push force [N]"')
    assert len(lines) == 1 + attempt.signal_time.size
    values = np.array([line.split(",")[:2] for line in lines[1:]], dtype=float)
    force = attempt.signals["push_force"]
    assert np.abs(values[:, 1] - force).max() <= 1.1 * np.ptp(force) / 4095
    assert bytes(browser.evaluate("[...pilegrasp.png(pilegrasp.panels[0]).slice(0, 4)]")) == b"\x89PNG"
    assert browser.console_errors() == []


@pytest.mark.browser
def test_a_primitive_repeats_while_loop_is_on(paused):
    first, second = paused.evaluate("pilegrasp.panels[0].data.primitives.slice(0, 2)")
    paused.evaluate("document.getElementById('loop').checked = true")
    paused.evaluate(f"pilegrasp.seek({first['end'] - 0.05}), pilegrasp.play()")
    paused.wait_for(f"pilegrasp.time() < {first['end'] - 0.06}")
    assert first["start"] <= paused.evaluate("pilegrasp.time()") <= second["start"]
    paused.evaluate("document.getElementById('loop').checked = false")


@pytest.mark.browser
def test_an_embedded_page_has_scene_and_curves_alone(paused, file):
    seen = "[...document.querySelectorAll('aside, .facts, .scene, .timeline')].map((one) => one.offsetHeight > 0)"
    assert paused.evaluate(seen) == [True] * 4
    paused.call("Page.navigate", url=f"{file.as_uri()}?embed")
    paused.wait_for("document.readyState === 'complete' && Boolean(window.pilegrasp)")
    assert sorted(paused.evaluate(seen)) == [False, False, True, True]
