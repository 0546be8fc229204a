"""A local Ray cluster of two worker processes: one is killed half-way, and nothing is lost."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

import psutil
import pytest

from tests.command import tethernet
from tests.systems import zenit
from tethernet_learning import workers
from tethernet_learning.campaigns import tables
from tethernet_learning.campaigns.cases import outcome_columns
from tethernet_learning.campaigns.chunks import fly_chunks
from tethernet_learning.campaigns.variations import random_positions
from tethernet_learning.data import make_data
from tethernet_sim.fly import Settings

SHORT = {"trigger_distance_m": 50.0, "capture_duration_s": 1.0}


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Cluster:
    """A cluster's processes and its address."""

    def __init__(self):
        self.folder = tempfile.mkdtemp(prefix="ray", dir="/tmp")  # Ray's sockets need a short path
        port = free_port()
        self.address = f"127.0.0.1:{port}"
        words = [
            "start", "--head", "--block", "--node-ip-address=127.0.0.1", f"--port={port}", "--num-cpus=2",
            "--include-dashboard=false", "--disable-usage-stats", "--object-store-memory=80000000",
            f"--temp-dir={self.folder}",
        ]  # fmt: skip
        with open(f"{self.folder}/head.log", "wb") as log:
            self.head = subprocess.Popen(
                [sys.executable, "-m", "ray.scripts.scripts", *words], stdout=log, stderr=subprocess.STDOUT
            )

    def two_busy(self):
        """The worker processes, as soon as both have a task in hand."""
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            children = psutil.Process(self.head.pid).children(recursive=True)
            busy = [process for process in children if "ray::_call" in command(process)]
            if len(busy) == 2:
                return busy
            time.sleep(0.01)
        raise AssertionError(f"not two busy workers: {[command(process) for process in children]}")

    def stop(self):
        family = [*psutil.Process(self.head.pid).children(recursive=True), psutil.Process(self.head.pid)]
        self.head.terminate()
        _, left = psutil.wait_procs(family, timeout=10)
        for process in left:
            process.kill()
        shutil.rmtree(self.folder, ignore_errors=True)


def command(process):
    try:
        return " ".join(process.cmdline())
    except psutil.Error:
        return ""


@pytest.fixture(scope="module")
def cluster():
    pytest.importorskip("ray")
    made = Cluster()
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline:
        try:
            assert list(workers.run(abs, [-1, -2], made.address)) == [1, 2]
            break
        except workers.ClusterError:
            assert made.head.poll() is None
            time.sleep(0.5)
    else:
        pytest.fail("the cluster did not start")
    yield made
    made.stop()


@pytest.fixture
def short(monkeypatch):
    settings = Settings.load(mission=SHORT)
    monkeypatch.setattr(Settings, "load", classmethod(lambda cls, *_, **__: settings))
    return settings


@pytest.mark.slow
def test_one_of_two_worker_processes_is_killed_half_way_and_nothing_is_lost(cluster):
    settings = Settings.load(mission={"capture_duration_s": 1.0})
    cases = random_positions(zenit(8), 8, 4, settings.mission)
    killed = None
    outcomes = []
    for flown in fly_chunks(cases, {zenit(8): settings}, 1, cluster.address):
        outcomes += flown
        if killed is None:
            killed = cluster.two_busy()[-1]
            os.kill(killed.pid, signal.SIGKILL)
    assert killed is not None
    assert not psutil.pid_exists(killed.pid) or psutil.Process(killed.pid).status() == psutil.STATUS_ZOMBIE
    assert outcomes == [outcome for chunk in fly_chunks(cases, {zenit(8): settings}, 8) for outcome in chunk]


@pytest.mark.slow
def test_commands_give_the_same_files_on_the_cluster(cluster, short, tmp_path, monkeypatch):
    monkeypatch.setattr(make_data, "PART", 2)
    for name, where in (("here", []), ("there", ["--cluster", cluster.address])):
        words = ["--mus", "8", "--train", "3", "--test", "2", "--output", str(tmp_path / name)]
        assert tethernet("data", "make", *words, *where) == 0
        words = ["--scenarios", "3", "--policy", "nominal", "--chunk", "2", "--output", str(tmp_path / f"e_{name}")]
        assert tethernet("evaluate", "policies", *words, *where) == 0
        words = ["random", "--scenarios", "3", "--mus", "4", "--chunk", "1", "--output", str(tmp_path / f"{name}.csv")]
        assert tethernet("campaign", *words, *where) == 0
    for one, other in (("here/train.parquet", "there/train.parquet"), ("here.csv", "there.csv")):
        assert (tmp_path / one).read_bytes() == (tmp_path / other).read_bytes()
    assert (tmp_path / "e_here/outcomes.csv").read_bytes() == (tmp_path / "e_there/outcomes.csv").read_bytes()
    assert len(tables.read(tmp_path / "there.csv", outcome_columns(4))) == 3


@pytest.mark.slow
def test_what_a_task_raises_is_raised_here(cluster):
    with pytest.raises(ValueError, match="invalid literal"):
        list(workers.run(int, ["1", "x"], cluster.address))


def test_without_ray_or_without_a_cluster_it_says_what_to_do(monkeypatch, capsys, tmp_path):
    words = ["--scenarios", "1", "--policy", "nominal", "--output", str(tmp_path), "--cluster"]
    monkeypatch.setitem(sys.modules, "ray", None)
    assert tethernet("evaluate", "policies", *words, "127.0.0.1:6379") == 1
    assert "needs Ray" in (said := capsys.readouterr().err)
    assert "bootstrap cluster" in said


def test_nobody_at_the_address(capsys, tmp_path):
    pytest.importorskip("ray")
    words = ["--scenarios", "1", "--policy", "nominal", "--output", str(tmp_path), "--cluster"]
    assert tethernet("evaluate", "policies", *words, f"127.0.0.1:{free_port()}") == 1
    assert "nobody answers" in capsys.readouterr().err
    assert tethernet("evaluate", "policies", *words, "here") == 1
    assert "allowed: HOST:PORT, ray://HOST:PORT or auto" in capsys.readouterr().err
