"""The graph benchmark's baseline: a mission's processes with empty callbacks, described after one that was flown.

Nodes, topics and who hears whom are those of :mod:`tethernet_bringup.mission.graph`; types, bytes and rates are those
of the bag that the mission left. The empty processes know the description alone.
"""

from __future__ import annotations

import base64
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.mission.dds_profile import use_profile
from tethernet_bringup.mission.graph import exclusive_topics, expected
from tethernet_bringup.mission.supervisor import mission_environment
from tethernet_bringup.nodes import ASSESSOR, MONITOR, PLANNER, RECORDER, SIM, controller
from tethernet_bringup.recorder.recorded_topics import mission_topics
from tethernet_bringup.recorder.settings import RecorderParameters
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters
from tethernet_core.system import System, load_system
from tethernet_ros import topics

from .processes import CpuSampler

ROOT = Path(__file__).resolve().parent.parent
_TIMERS_S = {PLANNER: (0.05, 1.0), ASSESSOR: (0.25,), SIM: (0.2,)}
"""Periods of the nodes' timers on the wall clock [s]."""


class EmptyMissionError(Exception):
    """The baseline did not come to its end; the message has its own words."""


@dataclass(frozen=True)
class EmptyFlown:
    """One run of the empty processes."""

    start_s: float
    """From the command to the first tick [s]."""
    real_time_factor: float
    """Mission time of the ticks by the time that they took."""
    cpu_s: dict[str, float]
    """CPU time of each process in flight [s]."""
    start_cpu_s: dict[str, float]
    """CPU time of each process up to the first tick [s]."""


def describe(run: Path) -> dict[str, Any]:
    """The description of the empty processes.

    Args:
        run: folder of a lock-step mission with its bag.
    """
    system = load_system(str(run / "system.yaml"))
    recorded = {topic.name: topic for topic in mission_topics(system.unit_count)}
    newest: dict[str, bytes] = {}
    counts = dict.fromkeys(recorded, 0)
    for message in open_bag(run).messages():
        newest[message.topic] = message.data
        counts[message.topic] = counts.get(message.topic, 0) + 1
    ticks = counts[topics.CLOCK]
    described = {
        name: {
            "type": topic.type_name,
            "latched": topic.latched,
            "depth": topic.depth,
            "data": base64.b64encode(newest.get(name, b"")).decode(),
            "every": max(1, round(ticks / counts[name])) if counts[name] else 0,
        }
        for name, topic in recorded.items()
    }
    described[topics.DIAGNOSTICS]["every"] = described[topics.SIM_STATUS]["every"]
    described[topics.MISSION_STATE]["every"] = 0  # when a phase begins: at the start only, here
    control = load(ControlParameters)
    return {
        "ticks": ticks,
        "period_s": control.control_period_s,
        "take_period_s": load(RecorderParameters).take_period_s,
        "plan_type": "tethernet_msgs/srv/PlanAimingPoints",
        "topics": described,
        "nodes": _nodes(system, control.control_period_s),
    }


def _nodes(system: System, period_s: float) -> dict[str, Any]:
    """Endpoints and timers of each node, in the order in which a mission starts them."""
    names = [SIM, ASSESSOR, RECORDER, PLANNER, *(controller(mu) for mu in range(1, system.unit_count + 1)), MONITOR]
    nodes: dict[str, Any] = {
        name: {"publishes": [], "subscribes": [], "wanted": {}, "timers": _TIMERS_S.get(name, ())} for name in names
    }
    for name in names:
        if name.endswith("_controller"):
            nodes[name]["timers"] = (period_s,)
    endpoints = expected(system, (), simulated=True)
    for endpoint in endpoints:
        nodes[endpoint.node]["publishes" if endpoint.publishes else "subscribes"].append(endpoint.topic)
    # What nobody waits for at the start is published and recorded all the same.
    others = [topics.NET_MARKERS, topics.NET_POINTS, topics.DIAGNOSTICS]
    nodes[SIM]["publishes"] += others
    nodes[RECORDER]["subscribes"] += others
    nodes[MONITOR]["subscribes"].append(topics.SIM_STATUS)
    for node in nodes.values():
        heard = [endpoint.topic for endpoint in endpoints if not endpoint.publishes]
        node["wanted"] = {topic: heard.count(topic) for topic in node["publishes"]}
    return nodes


def fly_empty(run: Path, scratch: Path, domain_id: int) -> EmptyFlown:
    """Run the empty processes of a mission once.

    Args:
        run: the mission's folder.
        scratch: exists; for what the run leaves.
        domain_id: DDS domain.

    Raises:
        EmptyMissionError: when they did not come to the last tick.
    """
    description = describe(run)
    with tempfile.TemporaryDirectory(dir=scratch) as folder:
        path = Path(folder, "graph.json")
        path.write_text(json.dumps(description), encoding="utf-8")
        system = load_system(str(run / "system.yaml"))
        environment = mission_environment(domain_id, "localhost", Path(folder))
        exclusive = exclusive_topics(system, (), simulated=True)
        environment = use_profile(environment, Path(folder), "empty-mission", exclusive)
        command = [sys.executable, "-m", "benchmarks.empty_mission", str(path)]
        environment.pop("PYTHONSAFEPATH", None)  # the benchmarks are found by the folder in which they are run
        process = subprocess.Popen(
            command, cwd=ROOT, env=os.environ | environment, stdout=subprocess.PIPE, text=True, start_new_session=True
        )
        with CpuSampler(process.pid) as sampler:
            said, _ = process.communicate()
    if process.returncode:
        raise EmptyMissionError(f"exit status {process.returncode} of {' '.join(command)}")
    result = json.loads(said)
    launched_s, wall_s = result["launched_s"], result["wall_time_s"]
    return EmptyFlown(
        start_s=launched_s - sampler.began,
        real_time_factor=description["ticks"] * description["period_s"] / wall_s,
        cpu_s=sampler.between(launched_s, launched_s + wall_s),
        start_cpu_s=sampler.between(sampler.began, launched_s),
    )
