"""The page in a real browser: opened from a file with the network off, it draws, plays, seeks and stays quiet."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from browser import Browser
from pilegrasp_ctrl.viewer import write_html
from pilegrasp_ctrl.viewer.scene.commands import node_path
from pilegrasp_ctrl.viewer.scene.shapes import PALETTE
from synthetic_recording import WALL_X, synthetic

pytestmark = [pytest.mark.browser, pytest.mark.slow]


PIXELS = """(() => {
  pilegrasp.viewer.render();
  const source = document.querySelector(".pane canvas");
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [160, 100];
  const pen = copy.getContext("2d");
  pen.drawImage(source, 0, 0, copy.width, copy.height);
  const bytes = pen.getImageData(0, 0, copy.width, copy.height).data;
  const seen = new Set();
  let opaque = 0;
  for (let k = 0; k < bytes.length; k += 4) {
    seen.add((bytes[k] << 16) | (bytes[k + 1] << 8) | bytes[k + 2]);
    opaque += bytes[k + 3] > 250;
  }
  const box = source.getBoundingClientRect();
  return { colors: seen.size, opaque: opaque / (160 * 100), width: box.width, height: box.height };
})()"""


POSES = """(() => {
  const scene = pilegrasp.viewer.scene;
  scene.updateMatrixWorld(true);
  const toScene = scene.matrixWorld.clone().invert();
  return PATHS.map((path) => {
    const node = pilegrasp.viewer.scene_tree.find(path.split("/").filter(Boolean)).object;
    return toScene.clone().multiply(node.matrixWorld).elements;
  });
})()"""


NOW = "document.querySelector('.moment').textContent"


CHILDREN = 'Object.keys(pilegrasp.viewer.scene_tree.find(["FOLDER"]).children).length'


def assert_quiet(browser, file):
    assert browser.console_errors() == []
    elsewhere = [address for address in browser.requests() if not address.startswith("data:")]
    assert set(elsewhere) <= {file.resolve().as_uri()}


def test_the_animation_stops_at_its_end_and_starts_over(paused):
    paused.evaluate("pilegrasp.seek(9.9); pilegrasp.play()")
    paused.wait_for("!pilegrasp.playing()")
    paused.wait_for("document.getElementById('play').textContent === 'Replay'")
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(10.0, abs=1e-3)
    assert paused.evaluate("parseFloat(document.querySelector('.cursor').style.left)") == pytest.approx(100.0, abs=0.1)
    paused.evaluate("document.getElementById('play').click()")
    paused.wait_for("pilegrasp.playing() && pilegrasp.time() < 5")


@pytest.mark.parametrize(("width", "height", "dark"), [(1280, 800, False), (400, 850, True)])
def test_the_page_draws_hand_and_pile_on_a_screen_and_on_a_phone(paused, file, width, height, dark):
    paused.resize(width, height, dark)
    paused.wait_for_picture()
    picture = paused.evaluate(PIXELS)
    # The sky is the page's; the canvas leaves it open.
    assert picture["colors"] > 300
    assert 0.3 < picture["opaque"] < 1.0
    assert 0.5 * width < picture["width"] <= width
    assert 0.25 * height < picture["height"] < height
    assert paused.evaluate("document.documentElement.scrollWidth") <= width
    points = [[0.45, 0.0, 0.1], [0.7, 0.0, 0.03], [WALL_X, 0.0, 0.1], [0.78, 0.0, 0.25]]
    places = paused.evaluate(f"""{points}.map((p) => {{
      const point = new MeshCat.THREE.Vector3(p[0], p[2], -p[1]).project(pilegrasp.viewer.camera);
      return [point.x, point.y];
    }})""")
    assert np.abs(places).max() < 1.0
    assert np.ptp(np.array(places)[:, 0]) > 0.4
    assert_quiet(paused, file)


def test_the_scene_tree_holds_every_body(paused, attempt):
    roles = [body.role for body in attempt.bodies]
    counts = {"Objects": "object", "Arm": "arm", "Hand": "hand", "Support": "support", "Sensor": "sensor"}
    for folder, role in counts.items():
        assert paused.evaluate(CHILDREN.replace("FOLDER", folder)) == roles.count(role)
    assert paused.evaluate('pilegrasp.viewer.scene_tree.find(["Grid"]).object.visible') is False


def test_the_browser_shows_the_recorded_poses(paused, attempt):
    script = POSES.replace("PATHS", str([node_path(k, body) for k, body in enumerate(attempt.bodies)]))
    for frame in (0, 101, 197, 299):
        paused.evaluate(f"pilegrasp.seek({attempt.frame_time[frame]})")
        matrices = np.reshape(paused.evaluate(script), (-1, 4, 4)).transpose(0, 2, 1)
        drift = np.linalg.norm(matrices[:, :3, 3] - attempt.body_position[frame], axis=1)
        recorded = Rotation.from_quat(attempt.body_quaternion[frame], scalar_first=True)
        turn = (Rotation.from_matrix(matrices[:, :3, :3]) * recorded.inv()).magnitude()
        assert drift.max() < 0.2e-3 + 1e-5
        assert turn.max() < np.deg2rad(0.5) + 1e-4


def test_a_click_on_the_strip_moves_scene_cursor_and_text(paused):
    paused.evaluate("pilegrasp.play()")
    box = paused.evaluate("document.querySelector('.over').getBoundingClientRect().toJSON()")
    x, y = box["left"] + 0.5 * box["width"], box["top"] + 0.5 * box["height"]
    for kind in ("mousePressed", "mouseReleased"):
        paused.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
    paused.wait_for("!pilegrasp.playing()")
    assert paused.evaluate("pilegrasp.viewer.animator.time") == pytest.approx(5.0, abs=0.05)
    cursors = paused.evaluate("[...document.querySelectorAll('.cursor')].map((c) => parseFloat(c.style.left))")
    assert cursors == pytest.approx([50.0], abs=0.5)
    assert paused.evaluate("Number(document.getElementById('scrub').value)") == pytest.approx(0.5, abs=0.005)
    assert re.fullmatch(r"\d\.\d\d s · push · push force −?\d+\.\d N · hand touches 00", paused.evaluate(NOW))
    paused.evaluate("document.querySelectorAll('aside [data-seek]')[3].click()")
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(7.6, abs=1e-3)
    assert paused.evaluate("document.querySelector('tr.now').textContent").startswith("lift")


def test_dragging_the_cursor_moves_the_scene(paused):
    box = paused.evaluate("document.querySelector('.over').getBoundingClientRect().toJSON()")
    y = box["top"] + 0.5 * box["height"]
    seen = []
    for kind, share in (("mousePressed", 0.2), ("mouseMoved", 0.6), ("mouseMoved", 0.7), ("mouseReleased", 0.7)):
        x = box["left"] + share * box["width"]
        paused.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)
        seen.append(paused.evaluate("pilegrasp.viewer.animator.time"))
    assert seen == pytest.approx([2.0, 6.0, 7.0, 7.0], abs=0.05)
    paused.call("Input.dispatchMouseEvent", type="mouseMoved", x=box["left"] + 10, y=y)
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(7.0, abs=0.05)


def test_the_slider_and_the_speed_move_the_clock(paused):
    paused.evaluate("""(() => {
      const scrub = document.getElementById("scrub");
      scrub.value = 0.25;
      scrub.dispatchEvent(new Event("input"));
    })()""")
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(2.5, abs=1e-6)
    # The clock follows the time stamps that the browser gives; how fast it draws does not matter.
    gone = """new Promise((done) => {
      document.getElementById("speed").value = SPEED;
      pilegrasp.play();
      requestAnimationFrame((first) => requestAnimationFrame((second) => {
        const start = pilegrasp.time();
        requestAnimationFrame((third) => done([pilegrasp.time() - start, third - second]));
      }));
    })"""
    for speed in ("0.1", "4"):
        paused.evaluate("pilegrasp.seek(1)")
        moved, elapsed = paused.evaluate(gone.replace("SPEED", f"'{speed}'"))
        # A slow page skips frames rather than time.
        assert moved == pytest.approx(float(speed) * elapsed / 1e3, abs=1e-6)
        paused.evaluate("pilegrasp.pause()")
    paused.evaluate("document.getElementById('speed').value = '1'")


def test_the_keyboard_steps_and_plays(paused, attempt):
    def press(key):
        paused.evaluate(f"document.body.dispatchEvent(new KeyboardEvent('keydown', {{key: {key!r}, bubbles: true}}))")

    frames = attempt.frame_time
    paused.evaluate(f"pilegrasp.seek({frames[150]})")
    press("ArrowRight")
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(frames[151], abs=1e-4)
    press("ArrowLeft")
    press("ArrowLeft")
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(frames[149], abs=1e-4)
    paused.evaluate("document.getElementById('forth').click()")
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(frames[150], abs=1e-4)
    press("End")
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(10.0)
    press("Home")
    assert paused.evaluate("pilegrasp.time()") == pytest.approx(0.0)
    press("+")
    assert paused.evaluate("document.getElementById('speed').value") == "2"
    press("-")
    assert paused.evaluate("document.getElementById('speed').value") == "1"
    press(" ")
    assert paused.evaluate("pilegrasp.playing()") is True
    press(" ")
    assert paused.evaluate("pilegrasp.playing()") is False


def test_two_recordings_share_one_clock(browser, attempt, tmp_path):
    other = synthetic(success=False, frames=100, objects=7)
    file = tmp_path / "pair.html"
    write_html(attempt, file, other)
    browser.open(file)
    browser.evaluate("pilegrasp.ready.then(() => pilegrasp.pause())")
    times = "pilegrasp.panels.map(({ viewer }) => viewer.animator.time)"
    cursors = "[...document.querySelectorAll('.cursor')].map((cursor) => parseFloat(cursor.style.left))"
    # The shorter one waits at its end.
    for moment, expected in ((3.0, [3.0, 3.0]), (9.0, [9.0, 6.4])):
        browser.evaluate(f"pilegrasp.seek({moment})")
        assert browser.evaluate(times) == pytest.approx(expected, abs=1e-3)
        assert browser.evaluate(cursors) == pytest.approx([10.0 * moment] * 2, abs=0.1)
    box = browser.evaluate("document.querySelectorAll('.over')[1].getBoundingClientRect().toJSON()")
    x, y = box["left"] + 0.4 * box["width"], box["top"] + 0.5 * box["height"]
    browser.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", buttons=1, clickCount=1)
    assert browser.evaluate(times) == pytest.approx([4.0, 4.0], abs=0.05)
    counts = "pilegrasp.panels.map((p) => Object.keys(p.viewer.scene_tree.find(['Objects']).children).length)"
    assert browser.evaluate(counts) == [18, 7]
    for width in (1280, 400):
        browser.resize(width, 800)
        assert browser.evaluate("document.documentElement.scrollWidth") <= width
    assert_quiet(browser, file)


def test_objects_have_colours_of_their_own(paused, attempt):
    paths = [node_path(k, body) for k, body in enumerate(attempt.bodies) if body.role == "object"]
    colors = paused.evaluate(f"""{paths}.map((path) => {{
      const found = [];
      pilegrasp.viewer.scene_tree.find(path.split("/").filter(Boolean)).object.traverse((c) => {{
        if (c.isMesh && c.material.side !== 1) found.push(c.material.color.getHex());
      }});
      return found;
    }})""")
    assert [pair[0] for pair in colors] == [PALETTE[k % len(PALETTE)] for k in range(18)]
    assert all(len(set(pair)) == 2 for pair in colors)


def test_the_page_cannot_reach_the_network(paused):
    blocked = paused.evaluate("""new Promise((done) => {
      document.addEventListener("securitypolicyviolation", (event) => done(event.effectiveDirective));
      fetch("http://127.0.0.1:9/").catch(() => {});
    })""")
    assert blocked == "connect-src"


def test_hostile_names_run_nothing(browser, tmp_path):
    hostile = '</script><script>window.pwned=1</script><img src="http://127.0.0.1:9/x" onerror="window.pwned=1">'
    plain = synthetic(frames=10, objects=6)
    names = [hostile, "__proto__", "constructor", *(f"b{k}" for k in range(len(plain.bodies) - 3))]
    bodies = tuple(replace(body, name=name) for body, name in zip(plain.bodies, names, strict=True))
    outcomes = [{"name": hostile, "status": "failed", "trigger": hostile, "start": 0.0, "end": 6.0}]
    meta = {"scenario": hostile, "reason": hostile, "config": {hostile: hostile}, "outcomes": outcomes}
    file = tmp_path / "hostile.html"
    write_html(replace(plain, meta=meta, bodies=bodies), file)
    browser.open(file)
    assert browser.evaluate("typeof window.pwned") == "undefined"
    assert browser.evaluate("document.images.length") == 0
    assert browser.evaluate(PIXELS)["colors"] > 300
    assert browser.evaluate(CHILDREN.replace("FOLDER", "Objects")) == 6
    assert_quiet(browser, file)


def test_without_webgl_the_strip_and_the_table_remain(chromium, file):
    with Browser(chromium, "--disable-3d-apis") as blind:
        blind.open(file, 800, 600)
        assert blind.evaluate("document.querySelector('.blank').checkVisibility()") is True
        assert blind.evaluate("document.querySelector('.plot polyline').getBoundingClientRect().width") > 300
        assert "Success" in blind.evaluate("document.querySelector('header').textContent")
        blind.evaluate("document.querySelectorAll('aside [data-seek]')[1].click()")
        assert blind.evaluate("parseFloat(document.querySelector('.cursor').style.left)") == pytest.approx(
            22.0, abs=0.1
        )
