"""The live view: served to this machine only, in real time, without a trace in the result or after the end."""

from __future__ import annotations

import asyncio
import json
import os
import re
import signal
import socket
import subprocess
import sys
import types
import urllib.error
import urllib.request

import numpy as np
import pytest
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

from browser import Browser, find_chromium
from pilegrasp_ctrl import episode
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.viewer.live import LiveView, pace
from pilegrasp_ctrl.viewer.live import live_view as live
from pilegrasp_ctrl.viewer.live.forces import WINDOW, Forces
from pilegrasp_ctrl.viewer.page.summary import summarize
from pilegrasp_ctrl.viewer.scene.commands import node_path, unpack
from synthetic_order import synthetic_order
from synthetic_recording import synthetic

SHORT = {"line.displacement": [0.0, 0.02, 0.0]}
HOSTILE = "</h1><script>window.pwned=1</script>"


@pytest.fixture(scope="module")
def attempt():
    return synthetic(frames=30, objects=4)


@pytest.fixture
def view():
    with LiveView("a title", timeout=0.0) as served:
        yield served


def port(view):
    return int(re.search(r":(\d+)/", view.url)[1])


def show(view, recording, frame, moment=None):
    moment = float(recording.frame_time[frame]) if moment is None else moment
    position, quaternion = (a[frame].astype(float) for a in (recording.body_position, recording.body_quaternion))
    view.show(moment, "push", recording.bodies, position, quaternion)


def get(view, path="", **headers):
    with urllib.request.urlopen(urllib.request.Request(view.url + path, headers=headers), timeout=10) as reply:
        return reply.headers, reply.read().decode()


def heard(view, count, **headers):
    """The first `count` messages that a page gets which opens now."""

    async def listen():
        address = view.url.replace("http", "ws") + "frames"
        connection = await websocket_connect(HTTPRequest(address, headers=headers))
        messages = [await asyncio.wait_for(connection.read_message(), 10) for _ in range(count)]
        connection.close()
        return messages

    return asyncio.run(listen())


def answers(address, number):
    with socket.socket() as probe:
        probe.settimeout(2)
        return probe.connect_ex((address, number)) == 0


# ---- who is served ----


def test_only_the_loopback_address_answers(view):
    assert answers("127.0.0.1", port(view))
    # All of 127.0.0.0/8 leads to this machine, but a server on every address would answer at each.
    assert not answers("127.0.0.2", port(view))


def test_the_page_names_no_other_server(view):
    headers, page = get(view)
    assert "<title>a title</title>" in page
    assert "://" not in page
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert re.findall(r"ws://\S+?;", policy) == [f"ws://127.0.0.1:{port(view)};"]
    assert "MeshCat" in get(view, "meshcat.js")[1]


@pytest.mark.parametrize("path", ["", "live.js", "frames"])
def test_a_foreign_name_that_resolves_to_this_machine_gets_nothing(view, path):
    with pytest.raises(urllib.error.HTTPError) as refusal:
        get(view, path, Host=f"evil.example:{port(view)}")
    assert refusal.value.code == 404


def test_a_page_of_another_origin_may_not_listen(view):
    with pytest.raises(HTTPClientError) as refusal:
        heard(view, 1, Origin="http://evil.example")
    assert refusal.value.code == 403


def test_a_port_that_is_taken_is_passed_over(monkeypatch):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        number = taken.getsockname()[1]
        monkeypatch.setattr(live, "PORTS", (number, 0))
        with LiveView("x", timeout=0.0) as view:
            assert port(view) != number
        monkeypatch.setattr(live, "PORTS", (number,))
        with pytest.raises(ExportError, match="no port on"):
            LiveView("x")


# ---- what is shown ----


def test_a_page_that_opens_late_gets_scene_frame_and_verdict(view, attempt):
    show(view, attempt, 0, 0.0)
    view.sample({"time": 0.01, "push_force": 3.14159, "normal_force": -1.0})
    show(view, attempt, 20, 0.01)
    view.finish({"success": False, "reason": "push: <b>", "realtime_factor": 4.9})
    scene, camera, frame, now, verdict = heard(view, 5)
    objects = [command["path"] for command in unpack(scene) if command["type"] == "set_object"]
    assert objects == [node_path(k, body) for k, body in enumerate(attempt.bodies)]
    assert json.loads(camera)["view"].keys() == {"low", "high", "direction"}
    matrices = np.array([command["matrix"] for command in unpack(frame)]).reshape(-1, 4, 4)
    np.testing.assert_allclose(matrices[:, 3, :3], attempt.body_position[20], atol=1e-6)
    state = json.loads(now)
    assert state["now"] == "0.01 s · push"
    assert state["forces"] == {"values": [3.14, -1.0], "curves": [[0.01], [3.142], [-1.0]]}
    assert state["factor"] > 0.0
    assert json.loads(verdict) == {
        "verdict": "Failed",
        "reason": "push: <b>",
        "state": "failure",
        "tally": "",
        "factor": 4.9,
    }


def test_the_end_is_told_in_the_words_of_the_page():
    meta = synthetic_order().meta
    with LiveView("x", timeout=0.0, config=meta["config"]) as view:
        view.finish(meta | {"carried": {"taken": 3, "kept": 0, "released": 2, "lost": 1, "losses": []}})
        (verdict,) = heard(view, 1)
    told = json.loads(verdict)
    summary = summarize(meta)
    assert (told["verdict"], told["reason"]) == (summary.verdict, summary.reason)
    assert "delivered in" in told["verdict"]
    assert told["tally"] == "3 taken: 2 released, 1 lost"


def test_the_curves_hold_the_last_seconds_and_every_peak():
    forces = Forces()
    for tick in range(3000):
        forces.add({"time": 0.01 * tick, "push_force": -20.0 if tick == 2701 else 1.0, "normal_force": 0.0})
    times, push, normal = forces.message()["curves"]
    assert times[0] >= 29.99 - WINDOW
    assert 29.95 <= times[-1] <= 29.99
    assert len(times) == len(normal) <= 30 * WINDOW + 1
    assert min(push) == -20.0
    assert forces.message()["values"] == [1.0, 0.0]


def test_the_real_time_factor_leaves_out_the_time_of_the_view(monkeypatch):
    clock = types.SimpleNamespace(now=1e6)

    def sleep(seconds):
        clock.now += seconds

    monkeypatch.setattr(pace, "time", types.SimpleNamespace(monotonic=lambda: clock.now, sleep=sleep))
    shown = pace.Pace()
    assert shown.factor() is None
    for frame in range(200):
        # Four times as fast as real time at first, and half as fast in the end.
        clock.now += 0.1 * (0.25 if frame < 100 else 2.0)
        shown.hold(0.1 * frame)
        if frame in (99, 199):
            assert shown.factor() == pytest.approx(4.0 if frame == 99 else 0.5)
        clock.now += 0.03
        shown.resume(0.1 * frame)


def test_it_runs_in_real_time_and_does_not_catch_up(view, attempt, monkeypatch):
    clock = types.SimpleNamespace(now=1e9, slept=[])

    def sleep(seconds):
        clock.slept.append(seconds)
        clock.now += seconds

    monkeypatch.setattr(pace, "time", types.SimpleNamespace(monotonic=lambda: clock.now, sleep=sleep))
    for moment, work in ((0.5, 0.0), (0.6, 0.02), (0.7, 0.3), (0.8, 0.04)):
        clock.now += work
        show(view, attempt, 0, moment)
    # 0.1 s of simulation that took 0.02 s waits the rest; after a slow patch of 0.3 s the pace is real time again.
    assert clock.slept == pytest.approx([0.0, 0.08, 0.0, 0.06], abs=1e-5)


def test_the_attempt_waits_for_its_first_page(attempt):
    with LiveView("x", timeout=60.0) as view:
        messages = asyncio.run(_open_then_show(view, attempt))
    # A page that is busy with the scene may be spared a frame, but never the last.
    assert messages[-2]["now"] == "0.00 s · push"


async def _open_then_show(view, attempt):
    connection = await websocket_connect(view.url.replace("http", "ws") + "frames")
    # Returns long before the timeout, because a page is open.
    await asyncio.wait_for(asyncio.to_thread(show, view, attempt, 0), 30)
    view.finish({"success": True})
    messages = []
    while not messages or "verdict" not in messages[-1]:
        message = await asyncio.wait_for(connection.read_message(), 10)
        messages += [json.loads(message)] if isinstance(message, str) else []
    connection.close()
    return messages


@pytest.mark.slow
@pytest.mark.browser
def test_the_page_shows_the_attempt(attempt):
    executable = find_chromium()
    if executable is None:
        reason = "Chromium is not installed; install it or name one in PILEGRASP_CHROMIUM"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    config = {"program": "grasp", "strategy": {"grasp_force": 6.0}}
    with Browser(executable) as browser, LiveView(HOSTILE, timeout=60.0, config=config) as view:
        browser.visit(view.url)
        show(view, attempt, 0, 0.0)
        for time, force in ((0.0, 0.5), (0.04, 7.25), (0.08, -4.0)):
            view.sample({"time": time, "push_force": force, "normal_force": 1.0})
        show(view, attempt, 29, 0.01)
        view.finish({"success": True, "grasped": 2, "reason": HOSTILE, "carried": {"taken": 3, "kept": 2, "lost": 1}})
        browser.wait_for("document.getElementById('verdict').textContent === 'Success: 2 objects held'")
        assert browser.evaluate("document.getElementById('tally').textContent") == "· 3 taken: 2 kept, 1 lost"
        assert re.fullmatch(
            r"real-time factor [\d.]+.*", browser.evaluate("document.getElementById('pace').textContent")
        )
        legend = browser.evaluate("document.querySelector('.legend').innerText").split()
        assert legend == ["force", "[N]", "F_grasp", "6", "N", "push", "force", "−4.0", "normal", "force", "1.0"]
        heights = browser.evaluate("document.querySelector('polyline.c0').getAttribute('points')").split(" ")
        threshold = float(browser.evaluate("document.querySelector('.threshold').getAttribute('y1')"))
        above = [float(point.split(",")[1]) < threshold for point in heights]
        assert above == [False, True, False]
        assert browser.evaluate("document.getElementById('now').textContent") == "0.01 s · push"
        assert browser.evaluate("document.getElementById('reason').textContent") == HOSTILE
        assert browser.evaluate("document.querySelector('h1').textContent") == HOSTILE
        assert browser.evaluate("typeof window.pwned") == "undefined"
        last = node_path(len(attempt.bodies) - 3, attempt.bodies[-3])
        path = json.dumps(last.split("/")[1:])
        place = browser.evaluate(f"live.viewer.scene_tree.find({path}).object.position.toArray()")
        np.testing.assert_allclose(place, attempt.body_position[29, -3], atol=1e-6)
        colors = browser.evaluate("""(() => {
          live.viewer.render();
          const copy = document.createElement("canvas");
          [copy.width, copy.height] = [160, 100];
          const pen = copy.getContext("2d");
          pen.drawImage(live.viewer.renderer.domElement, 0, 0, 160, 100);
          const bytes = new Uint32Array(pen.getImageData(0, 0, 160, 100).data.buffer);
          return new Set(bytes).size;
        })()""")
        assert colors > 300
        view.close()
        browser.wait_for_picture()
        assert browser.evaluate("document.getElementById('verdict').textContent") == "Success: 2 objects held"
        assert browser.console_errors() == []
        assert {r.split("/")[2] for r in browser.requests() if not r.startswith("data:")} == {view.url.split("/")[2]}


# ---- what is left ----


def test_watching_changes_nothing(tmp_path, view):
    plain = episode.run("free_space_line", record=True, overrides=SHORT)
    hooks = {"on_frame": view.show, "on_sample": view.sample}
    watched = episode.run("free_space_line", record=True, overrides=SHORT, **hooks)
    plain.recording.save(tmp_path / "plain.npz")
    watched.recording.save(tmp_path / "watched.npz")
    assert (tmp_path / "plain.npz").read_bytes() == (tmp_path / "watched.npz").read_bytes()
    facts = [result.as_dict() for result in (plain, watched)]
    for timing in ("wall_time", "realtime_factor", "controller"):
        for table in facts:
            table.pop(timing)
    assert facts[0] == facts[1]


def test_an_observer_sees_the_frames_and_samples_of_the_recording():
    seen, samples = [], []
    hooks = {"on_frame": lambda *frame: seen.append((frame[0], *frame[3:])), "on_sample": samples.append}
    result = episode.run("free_space_line", record=True, overrides=SHORT, **hooks)
    recording = result.recording
    assert {"time", *recording.signals} == set(samples[0])
    for name, values in {"time": recording.signal_time, **recording.signals}.items():
        np.testing.assert_array_equal(np.array([row[name] for row in samples]).astype(values.dtype), values)
    times = [time for time, *_ in seen]
    assert set(recording.frame_time) <= set(times)
    assert times == sorted(times)
    # A frame at the end of each primitive besides.
    assert len(seen) <= recording.frame_time.size + len(result.outcomes)
    for time, position, quaternion in seen:
        (index,) = np.nonzero(recording.frame_time == time)
        if index.size:
            np.testing.assert_array_equal(position.astype(np.float32), recording.body_position[index[0]])
            np.testing.assert_array_equal(quaternion.astype(np.float32), recording.body_quaternion[index[0]])


@pytest.mark.parametrize("error", [None, ValueError, KeyboardInterrupt])
def test_the_server_ends_with_the_attempt(error):
    number, thread = 0, None

    def watch():
        nonlocal number, thread
        with LiveView("x", timeout=0.0) as view:
            number, thread = port(view), view._thread
            assert answers("127.0.0.1", number)
            if error:
                raise error

    if error:
        with pytest.raises(error):
            watch()
    else:
        watch()
    assert not answers("127.0.0.1", number)
    assert not thread.is_alive()


def test_an_interrupted_run_ends_at_once_and_serves_no_more():
    # A process that a shell started in the background ignores interrupts, and so do the processes that it starts.
    code = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    code += "from pilegrasp_ctrl.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", code, "run", "free_space_line", "--live"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    line = process.stderr.readline()
    number = int(re.fullmatch(r"watch at http://127\.0\.0\.1:(\d+)/ \(.*\)\n", line)[1])
    assert answers("127.0.0.1", number)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (130, "", "")
    assert not answers("127.0.0.1", number)
