"""Worker processes: their replacement, the repetition of work items, and their end."""

import asyncio
import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future

import pytest

from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.study import cluster_pool
from pilegrasp_ctrl.study.dispatch import dispatch
from pilegrasp_ctrl.study.worker_pool import WorkerPool
from processes import is_there, wait_until_gone
from study_tasks import work

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc")


def run_items(folder, kinds, jobs=2):
    """Return the answer to each work item, by its number, and how often each began."""
    items = [(str(folder), number, kind) for number, kind in enumerate(kinds)]
    answers = {}
    with WorkerPool(jobs) as pool:
        for batch in dispatch(pool, work, items, lambda item, deaths: (item[1], f"{deaths} deaths")):
            answers |= {item[1]: result for item, result in batch}
    return answers, {number: (folder / str(number)).stat().st_size for number in answers}


def test_every_work_item_runs_once_in_another_process(tmp_path):
    answers, begun = run_items(tmp_path, ["works"] * 8)
    assert [answers[number][0] for number in range(8)] == list(range(8))
    processes = {process for _, process in answers.values()}
    assert len(processes) <= 2
    assert os.getpid() not in processes
    assert set(begun.values()) == {1}


def test_a_dying_worker_is_replaced_and_the_others_go_on(tmp_path):
    kinds = ["works"] * 10
    kinds[2], kinds[5], kinds[7] = "dies once", "dies", "lacks memory once"
    answers, begun = run_items(tmp_path, kinds)
    assert answers.pop(5) == (5, "3 deaths")
    assert [answers[number][0] for number in sorted(answers)] == sorted(answers)
    assert begun == {number: {2: 2, 5: 3, 7: 2}.get(number, 1) for number in range(10)}


def test_an_error_of_the_function_ends_all_workers(tmp_path):
    with WorkerPool(2) as pool:
        first = list(dispatch(pool, work, [(str(tmp_path), number, "works") for number in range(4)], lambda *_: None))
        processes = {process for batch in first for _, (_, process) in batch}
        assert all(map(is_there, processes))
        with pytest.raises(SimulationError, match="no work item would fare better"):
            list(dispatch(pool, work, [(str(tmp_path), 9, "raises")], lambda *_: None))
    wait_until_gone(processes)


@pytest.mark.slow
def test_workers_that_cannot_start_are_an_error_with_the_remedy(tmp_path):
    script = tmp_path / "unguarded.py"
    script.write_text(
        "from study_tasks import work\n"
        "from pilegrasp_ctrl.study.dispatch import dispatch\n"
        "from pilegrasp_ctrl.study.worker_pool import WorkerPool\n"
        "with WorkerPool(1) as pool:\n"
        f"    print(list(dispatch(pool, work, [({str(tmp_path)!r}, n, 'works') for n in range(9)], print)))\n"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "SimulationError: the worker processes end before they start; in a script, put the call below" in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize("fault", [None, KeyError])
def test_a_pool_that_has_ended_leaves_no_thread(tmp_path, fault):
    before = set(threading.enumerate())
    with pytest.raises(fault) if fault else contextlib.nullcontext(), WorkerPool(2) as pool:
        list(dispatch(pool, work, [(str(tmp_path), number, "works") for number in range(4)], lambda *_: None))
        if fault:
            raise fault
    assert set(threading.enumerate()) <= before


# --- waits have a bound -----------------------------------------------------------------------------------------------


def test_a_worker_that_died_while_it_was_idle_is_replaced(tmp_path):
    with WorkerPool(1) as pool:
        ((((_, (_, process)),)),) = dispatch(pool, work, [(str(tmp_path), 0, "works")], lambda *_: None)
        os.kill(process, signal.SIGKILL)
        wait_until_gone({process})
        (worker,) = pool._workers
        while not worker.executor._broken:
            time.sleep(0.01)
        ((((_, (number, other)),)),) = dispatch(pool, work, [(str(tmp_path), 1, "works")], lambda *_: None)
    assert number == 1
    assert other != process


def test_a_worker_that_is_given_back_late_is_waited_for(tmp_path):
    with WorkerPool(1) as pool:
        list(dispatch(pool, work, [(str(tmp_path), 0, "works")], lambda *_: None))
        # As if the thread of the future stopped between its state and its callbacks.
        worker = pool._idle.get()
        threading.Timer(0.3, pool._idle.put, [worker]).start()
        ((((_, (number, _)),)),) = dispatch(pool, work, [(str(tmp_path), 1, "works")], lambda *_: None)
    assert number == 1


def test_a_worker_that_is_never_given_back_is_an_error(monkeypatch):
    monkeypatch.setattr("pilegrasp_ctrl.study.worker_pool.RELEASE_TIMEOUT", 0.1)
    with WorkerPool(1) as pool:
        pool._idle.get()
        with pytest.raises(SimulationError, match=r"no worker process is free after 0\.1 s"):
            pool.submit(work, None)


def test_a_process_that_cannot_be_started_is_a_sentence(monkeypatch):
    def refused(self):
        raise OSError(11, "Resource temporarily unavailable")

    monkeypatch.setattr("pilegrasp_ctrl.study.worker_pool._Worker.__init__", refused)
    with WorkerPool(1) as pool, pytest.raises(SimulationError, match=r"temporarily unavailable; .* with fewer --jobs"):
        pool.submit(work, None)


def test_a_worker_that_does_not_end_is_killed(tmp_path, monkeypatch):
    monkeypatch.setattr("pilegrasp_ctrl.study.worker_pool.END_TIMEOUT", 0.5)
    with WorkerPool(1) as pool:
        ((((_, (_, process)),)),) = dispatch(pool, work, [(str(tmp_path), 0, "stays")], lambda *_: None)
    wait_until_gone({process})


def test_the_watch_over_a_cluster_outlives_what_dask_cancels(monkeypatch):
    monkeypatch.setattr(cluster_pool, "WATCH_PERIOD", 0.01)
    answers = iter([asyncio.CancelledError(), TimeoutError()])

    class Client:
        async def nthreads(self):
            raise next(answers, OSError())

    pool = object.__new__(cluster_pool.ClusterPool)
    pool._client, pool._closing, pool._threads, pool._running = Client(), False, {}, set()

    async def watch():
        task = asyncio.ensure_future(pool._count_workers())
        for _ in range(3):
            pool._running = {Future()}
            await asyncio.sleep(0.1)
            assert all(future.cancelled() for future in pool._running)
        assert not task.done()
        pool._closing = True
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await asyncio.wait_for(task, 5.0)
        assert task.done()

    asyncio.run(watch())
