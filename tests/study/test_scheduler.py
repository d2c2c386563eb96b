"""A cluster: whatever answers at the address, and whenever it falls silent, the study says so in one sentence."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from misbehaving_servers import ADDRESSES, SERVERS, serve
from pilegrasp_ctrl.exceptions import ConfigurationError, SimulationError
from pilegrasp_ctrl.study import cluster_pool
from pilegrasp_ctrl.study.cluster_pool import ClusterPool
from pilegrasp_ctrl.study.dispatch import dispatch
from pilegrasp_ctrl.study.scheduler import Scheduler

pytest.importorskip("distributed")


def refusal(address):
    """Return the sentence with which an address is refused."""
    with pytest.raises(ConfigurationError) as error:
        ClusterPool(address)
    return str(error.value)


@pytest.mark.parametrize("address", ADDRESSES)
def test_what_is_no_address_is_refused_with_the_form_of_one(address):
    assert "tcp://127.0.0.1:8786" in refusal(address) or "needs certificates" in refusal(address)
    assert len(refusal(address)) < 400


def test_whatever_answers_that_is_no_scheduler_is_named_in_time(monkeypatch):
    monkeypatch.setattr(cluster_pool, "CONNECT_TIMEOUT", 2.0)

    def refused(name):
        with serve(name) as port:
            return refusal(f"tcp://127.0.0.1:{port}")

    begin = time.monotonic()
    with ThreadPoolExecutor(len(SERVERS)) as threads:
        sentences = list(threads.map(refused, SERVERS))
    assert time.monotonic() - begin < 12.0
    assert all(text.startswith("no scheduler answers at 'tcp://127.0.0.1:") for text in sentences)
    assert all("start one with `dask scheduler`" in text for text in sentences)


def test_a_missing_scheduler_is_an_error_with_the_remedy(monkeypatch):
    monkeypatch.setattr(cluster_pool, "CONNECT_TIMEOUT", 1.0)
    assert refusal("127.0.0.1:1").startswith("no scheduler answers at 'tcp://127.0.0.1:1'")
    assert "Connection refused" in refusal("tcp://[::1]:1") or "address" in refusal("tcp://[::1]:1")
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "pip install 'pilegrasp[cluster]'" in refusal("tcp://127.0.0.1:1")


def test_certificates_belong_to_an_encrypted_address():
    with pytest.raises(ConfigurationError, match="are for an address that begins with tls://, not 'tcp://"):
        Scheduler("tcp://127.0.0.1:1", tls_ca="a.pem", tls_cert="b.pem")
    with pytest.raises(ConfigurationError, match="give --tls-ca and --tls-cert together"):
        Scheduler("tls://127.0.0.1:1", tls_ca="a.pem")
    with pytest.raises(
        ConfigurationError, match=r"the certificates in 'a\.pem', 'b\.pem' cannot be used: .*No such file"
    ):
        ClusterPool(Scheduler("tls://127.0.0.1:1", tls_ca="a.pem", tls_cert="b.pem"))


@pytest.fixture(scope="module")
def cluster():
    """Start a scheduler with one worker, as `docs/cluster.md` does, on the loopback alone."""
    with running_cluster() as found:
        yield found


class running_cluster:  # noqa: N801
    """A scheduler and a worker as processes of their own; `address` is the scheduler's."""

    def __init__(self, protocol="tcp", *arguments):
        self.protocol, self.arguments, self.processes = protocol, arguments, []

    def __enter__(self):
        local = ["--host", f"{self.protocol}://127.0.0.1", "--dashboard-address", "127.0.0.1:0", *self.arguments]
        line = self._begin("scheduler", *local, "--port", "0", until="Scheduler at:")
        self.address = line.split()[-1]
        worker = [*local, "--nthreads", "1", "--no-nanny"]
        self._begin("worker", self.address, *worker, until="Registered to:")
        return self

    def _begin(self, *command, until):
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
        process = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_" + command[0], *command[1:]],
            env=environment,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.processes.append(process)
        for line in process.stderr:
            if until in line:
                return line
        raise AssertionError(f"{command} ended")

    def __exit__(self, *error):
        for process in self.processes:
            process.send_signal(signal.SIGCONT)
            process.kill()
            process.communicate()


def test_workers_with_several_threads_are_refused(cluster):
    with ClusterPool(cluster.address) as pool:
        while not pool._threads:
            time.sleep(0.01)
        assert pool.width() == 2
        pool._threads = {"tcp://10.0.0.2:40331": 8}
        with pytest.raises(ConfigurationError, match=r"10\.0\.0\.2:40331 has 8 threads.*--nthreads 1"):
            pool.width()


def test_a_worker_is_no_scheduler(cluster, monkeypatch):
    monkeypatch.setattr(cluster_pool, "CONNECT_TIMEOUT", 4.0)
    with ClusterPool(cluster.address) as pool:
        while not pool._threads:
            time.sleep(0.01)
        (worker,) = pool._threads
    assert refusal(worker).startswith("no scheduler answers at ")


def test_nothing_of_a_cluster_as_documented_listens_beyond_the_loopback(cluster):
    from processes import listening

    with ClusterPool(cluster.address):
        addresses = [listening(process.pid) for process in cluster.processes]
        assert all(addresses)
        assert {host for found in addresses for host, _ in found} <= {"127.0.0.1", "::1"}
        assert listening(os.getpid()) == []


@pytest.mark.slow
@pytest.mark.parametrize("fault", [signal.SIGKILL, signal.SIGSTOP])
def test_a_scheduler_that_is_killed_or_falls_silent_ends_the_study_in_time(fault, monkeypatch):
    monkeypatch.setattr(cluster_pool, "ANSWER_TIMEOUT", 3.0)
    with running_cluster() as cluster, ClusterPool(cluster.address) as pool:
        answers = dispatch(pool, abs, range(100_000), print)
        next(answers)
        cluster.processes[0].send_signal(fault)
        begin = time.monotonic()
        with pytest.raises(SimulationError, match="the scheduler was lost; finished work is kept"):
            list(answers)
        assert time.monotonic() - begin < 15.0


@pytest.mark.slow
def test_certificates_are_used_and_demanded(tmp_path, monkeypatch):
    if not shutil.which("openssl"):
        pytest.skip("there is no openssl to make certificates with")
    ca, cert, key = (str(tmp_path / name) for name in ("ca.pem", "cert.pem", "key.pem"))
    make = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=test", "-days", "2"]
    subprocess.run([*make, "-keyout", key, "-out", ca], check=True, capture_output=True)
    shutil.copy(ca, cert)
    options = ["--tls-ca-file", ca, "--tls-cert", cert, "--tls-key", key]
    with running_cluster("tls", *options) as cluster:
        assert cluster.address.startswith("tls://")
        with ClusterPool(Scheduler(cluster.address, ca, cert, key)) as pool:
            answers = [answer for batch in dispatch(pool, abs, [-1, -2], print) for _, answer in batch]
        assert sorted(answers) == [1, 2]
        monkeypatch.setattr(cluster_pool, "CONNECT_TIMEOUT", 2.0)
        assert "needs certificates" in refusal(cluster.address)
        assert "no scheduler answers" in refusal(cluster.address.replace("tls", "tcp"))


def test_a_study_asks_for_its_scheduler_before_it_makes_anything(tmp_path, capsys, monkeypatch):
    from command_line import answer, one_sentence

    monkeypatch.setattr(cluster_pool, "CONNECT_TIMEOUT", 1.0)
    monkeypatch.setattr("pilegrasp_ctrl.study.run.check_conditions", lambda conditions: pytest.fail("too early"))
    study = tmp_path / "study"
    sweep = ("sweep", "free_space_line", "--seeds", "0:1", "--out", study, "--scheduler")
    with serve("says nothing") as port:
        status, out, err = answer(capsys, *sweep, f"tcp://127.0.0.1:{port}")
    assert (status, out) == (2, "")
    assert one_sentence(err)
    assert "it did not greet within 1 s" in err
    assert not study.exists()
    status, out, err = answer(capsys, "sweep", "free_space_line", "--seeds", "0:1", "--out", study, "--tls-ca", "x.pem")
    assert (status, json.dumps(out)) == (2, '""')
    assert "are for --scheduler" in err
