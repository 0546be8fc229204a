"""Every benchmark runs, and ends with one line of JSON that has the promised keys."""

from __future__ import annotations

import itertools
import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks import figures, mission
from benchmarks.processes import CpuSampler
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Scenario

ROOT = Path(__file__).resolve().parents[2]
MISSION_COMMAND = f"{sys.executable} -m tethernet_bringup.mission.command_line"
TIMEOUT_S = 240.0
SYSTEMS = ("zenit_8mu", "zenit_4mu")


def run(name: str, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", f"benchmarks.{name}", *words],
        cwd=ROOT, capture_output=True, text=True, timeout=TIMEOUT_S, check=False,
    )  # fmt: skip


def last_line(done: subprocess.CompletedProcess[str], name: str) -> dict:
    assert done.returncode == 0, done.stdout + done.stderr
    result = json.loads(done.stdout.splitlines()[-1])
    assert next(iter(result.items())) == ("benchmark", name)
    return result


def test_engine():
    pytest.importorskip("mujoco", reason="MuJoCo is the peer; requirements/bench.txt has it")
    result = last_line(run("engine", "--smoke"), "engine")
    assert result["simulated_s"] == 1.0
    ratio = result["mujoco_cpu_s_per_sim_s"] / result["cpu_s_per_sim_s"]
    assert result["cpu_ratio_mujoco"] == pytest.approx(ratio, rel=2e-3), "of the one turn"
    assert 0.0 < result["mu_max_error_mm"] < 5.0
    assert 0.0 < result["com_max_error_m"] < 0.3


def test_mission():
    result = last_line(run("mission", "--smoke"), "mission")
    assert result["cpu_s"] == pytest.approx(result["deployment_cpu_s"] + result["capture_cpu_s"], rel=1e-3)
    assert min(result["deployment_cpu_s"], result["capture_cpu_s"]) > 0.0
    speed_up = result["batch_scenarios_per_s"] / result["batch_scenarios_per_s_one_core"]
    assert speed_up == pytest.approx(result["batch_efficiency"] * result["batch_cores"], rel=2e-3)


def test_contact():
    result = last_line(run("contact", "--smoke"), "contact")
    for name in SYSTEMS:
        threads, knots = (result[f"whole_cpu_s_{contact}_{name}"] for contact in ("threads", "knots"))
        assert result[f"whole_ratio_{name}"] == pytest.approx(threads / knots, rel=2e-3), "of the one turn"


def test_net_contact():
    result = last_line(run("net_contact", "--smoke"), "net_contact")
    for name, part in itertools.product(SYSTEMS, ("whole", "deployment", "capture")):
        threads, none = (result[f"{part}_cpu_s_{contact}_{name}"] for contact in ("threads", "none"))
        assert result[f"{part}_ratio_{name}"] == pytest.approx(threads / none, rel=2e-3), "of the one turn"
    assert result["passes_deployment_none_zenit_8mu"] >= 0
    assert result["passes_capture_threads_zenit_8mu"] == 0, "a net that has just begun to unfold"


def test_friction():
    result = last_line(run("friction", "--smoke", "--system", "zenit_4mu", "--friction", "0", "0.6"), "friction")
    assert (result["missions"], result["system"]) == (1, "zenit_4mu")
    assert {"held_0", "held_0.6", "slip_m_0", "slip_m_0.6"} <= set(result)


def test_the_mission_benchmark_counts_what_is_flown():
    """A capture ten times as long costs more after the trigger, and it costs CPU time, not waiting."""
    scenario = Scenario("zenit_4mu")
    short, long = (
        Settings.load(mission={**mission.CAPTURE_AT_ONCE, "capture_duration_s": seconds}) for seconds in (1.0, 10.0)
    )
    mission.fly_once(scenario, short)  # compiles or loads
    assert mission.fly_once(scenario, long).capture > 3.0 * mission.fly_once(scenario, short).capture


def test_scale():
    result = last_line(run("scale", "--smoke"), "scale")
    for share in ("opening", "flat"):
        small, large = (result[f"grid_ns_per_knot_step_{share}_{knots}x1"] for knots in (529, 2025))
        assert result[f"growth_of_cost_per_knot_{share}"] == pytest.approx(large / small, rel=2e-3)
        assert result[f"growth_beyond_first_cache_{share}"] == 1.0  # the middle net of two is the largest
    assert result["edge_list_by_grid_most"] > 0.0
    assert result["memory_peak_mb"] > 50.0


@pytest.mark.ros
def test_graph(domain_id):
    result = last_line(run("graph", "--smoke", "--domain-id", str(domain_id), "--command", MISSION_COMMAND), "graph")
    assert None not in result.values(), "everything was measured"
    assert 0.0 < result["latency_p50_ms"] <= result["latency_p99_ms"] <= result["latency_max_ms"]
    assert 0.0 < result["realtime_cpu_share"] <= 1.0
    flown_s = 4.0  # the smoke run's missions end then
    wall_s = flown_s / result["real_time_factor"]
    assert result["lockstep_cpu_s"] < 1.2 * wall_s * os.cpu_count(), "no process works before it is there"
    assert 100.0 < result["memory_mb"] < 1500.0
    assert result["lockstep_deadline_misses"] == 0
    assert result["share_of_empty"] == pytest.approx(
        result["real_time_factor"] / result["real_time_factor_empty"], rel=2e-3
    ), "of the one turn"
    assert 0.1 < result["start_ratio_empty"] < 10.0


@pytest.mark.parametrize(
    ("command", "said"), [("false", "exit status 1 (allowed: (0, 3)) of false"), ("/no/such/mission", "cannot start")]
)
def test_graph_tells_what_the_mission_said_when_it_fails(command, said):
    done = run("graph", "--smoke", "--command", command)
    assert done.returncode == 1
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert '"benchmark"' not in done.stdout


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("engine", ["--turns", "0"]),
        ("mission", ["--batch", "0"]),
        ("graph", ["--missions", "0"]),
        ("scale", ["--turns", "0"]),
    ],
)
def test_nothing_to_measure_is_bad_usage(name, words):
    done = run(name, *words)
    assert done.returncode == 2
    assert "0: allowed: a whole number from 1" in done.stderr


def test_the_last_line_rounds_and_has_null_for_what_is_not_a_number(capsys):
    figures.conclude("some", {"a": 1.23456789, "b": math.nan, "c": 3, "d": 1234567.0, "e": None})
    assert json.loads(capsys.readouterr().out) == {
        "benchmark": "some", "a": 1.235, "b": None, "c": 3, "d": 1235000.0, "e": None,
    }  # fmt: skip


def test_cpu_time_is_seen_for_a_command_and_its_children():
    burn = "import time\nwhile time.process_time() < 0.3: pass\n"
    parent = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {burn!r}, '__node:=worker']); input()"
    command = subprocess.Popen([sys.executable, "-c", parent], stdin=subprocess.PIPE, text=True)
    with CpuSampler(command.pid, period_s=0.02) as sampler:
        deadline = time.monotonic() + 60.0
        while sampler.between(sampler.began, time.monotonic()).get("worker", 0.0) < 0.2:
            assert time.monotonic() < deadline, "the worker's CPU time was not seen"
            time.sleep(0.02)
        command.communicate("\n")
    assert command.returncode == 0
