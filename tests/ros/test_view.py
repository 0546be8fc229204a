"""A mission that is shown flies as one that is not, whatever becomes of the viewer."""

import os
import select
import signal
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.rerun_file import read
from tests.ros.mission_command import FLYING, MissionCommand
from tests.ros.test_mission_faults import LOCKSTEP, short
from tests.ros.test_mission_flight import assert_same, in_process
from tests.unit.test_view import ENTITIES
from tethernet_bringup.view import command_line
from tethernet_bringup.view.application import Application, listens
from tethernet_bringup.view.arguments import WEB

pytestmark = [pytest.mark.ros, pytest.mark.skipif(find_spec("rerun") is None, reason="needs rerun")]


@pytest.fixture
def rerun_file(tmp_path):
    return tmp_path / "flight.rrd"


def test_a_mission_is_recorded_while_it_flies_and_its_bag_shows_the_same(tmp_path, domain_id, rerun_file):
    with MissionCommand(tmp_path / "runs", domain_id, *LOCKSTEP, "--view", str(rerun_file)) as mission:
        assert mission.finish() == 0, mission.text
        assert mission.outcome["warnings"] == mission.outcome["faults"] == []
        assert mission.outcome["deadline_misses"] == mission.outcome["late_commands"] == 0
        assert f"view: recorded to {rerun_file}" in mission.text
        assert_same(mission.outcome, in_process())
        outcome = mission.outcome
    subprocess.run([sys.executable, "-m", "rerun_cli", "rrd", "verify", rerun_file], check=True, timeout=60.0)
    live = read(rerun_file)
    assert set(live) == ENTITIES
    end_ns = outcome["end_time_s"] * 1e9
    for name in ("/scene/units", "/scene/net/threads", "/scene/debris", "/plots/thrust", "/plots/fuel"):
        times = live[name].times_ns
        assert times == sorted(times) and times[0] < 3e9
        assert times[-1] == pytest.approx(end_ns, abs=1e8), f"{name}: to the end"
    texts = {row["text"][0]: time_ns for time_ns, row in live["/events"].rows}
    assert {"DEPLOYING", "CLOSING", "COMPLETE", outcome["verdict"]} <= set(texts)
    assert texts["CLOSING"] == pytest.approx(outcome["trigger_time_s"] * 1e9)
    assert live["/plots/locked_pairs"].last("scalars") == [outcome["locked_pairs"]]

    output = tmp_path / "bag.rrd"
    assert command_line.main([str(mission.run), "--view", str(output)]) == 0
    bag = read(output)
    assert set(bag) == set(live)
    # A picture of the flight shows the same as the bag at that time.
    for name in ("/scene/units", "/scene/net/knots"):
        flown = [time_ns for time_ns in live[name].times_ns if time_ns > 0]  # at 0 is all that was before the launch
        same = [time_ns for time_ns in flown if time_ns in set(bag[name].times_ns)]
        assert len(flown) - 1 <= len(same) > 10
        for time_ns in same[:: max(1, len(same) // 8)]:
            assert dict(live[name].rows)[time_ns]["positions"] == dict(bag[name].rows)[time_ns]["positions"], name


@pytest.mark.parametrize("number", [signal.SIGSTOP, signal.SIGKILL])
def test_a_viewer_that_stalls_or_dies_in_flight_costs_the_mission_nothing(tmp_path, domain_id, rerun_file, number):
    flags = ("--mus", "4", *LOCKSTEP, "--view", str(rerun_file))
    with MissionCommand(tmp_path / "runs", domain_id, *flags) as mission:
        mission.wait_for(FLYING)
        os.kill(mission.nodes()["viewer"], number)
        assert mission.finish() == 0, mission.text
        outcome = mission.outcome
        assert outcome["deadline_misses"] == outcome["late_commands"] == 0
        assert outcome["faults"] == []
        assert_same(outcome, in_process(system="zenit_4mu"))
        if number == signal.SIGKILL:
            assert outcome["warnings"] == ["viewer died (killed by SIGKILL); the mission went on without it"]
        else:
            assert outcome["warnings"] == [], "it goes on when it is asked to end, and ends in order"
            assert {"/scene", "/scene/debris/shape"} <= set(read(rerun_file)), "and leaves a whole file"


def test_rerun_that_stands_still_costs_a_mission_in_real_time_nothing(tmp_path, domain_id):
    flags = ("--mus", "4", "--pace", "realtime", *short(tmp_path, 6.0), "--view", "web")
    with MissionCommand(tmp_path / "runs", domain_id, *flags) as mission:
        mission.wait_for(FLYING)
        [server] = children(mission.process.pid, "rerun")
        os.kill(server, signal.SIGSTOP)
        mission.wait_for(r"view: stays at http://127\.0\.0\.1:\d+/\?url=\S+ until Ctrl-C")
        assert mission.outcome["faults"] == []
        assert mission.outcome["phase"] == "MISSED"
        mission.process.send_signal(signal.SIGINT)
        assert mission.finish() == 3, "as flown, whenever the page is closed"
        assert children(mission.process.pid, "rerun") == []


def test_a_server_ends_with_the_command_that_started_it(tmp_path):
    code = (
        "import sys, time; from tethernet_bringup.view.application import Application; "
        f"a = Application({WEB!r}, 100); a.await_start(); print(a.pid, a.address, flush=True); time.sleep(600)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as command:
        pid, address = command.stdout.readline().split()
        port = int(address.rsplit(":", 1)[1].partition("/")[0])
        assert listens(port)
        command.kill()
    pidfd = None
    try:
        pidfd = os.pidfd_open(int(pid))
        assert select.select([pidfd], [], [], 60.0)[0], "ends by itself"
    except ProcessLookupError:
        pass  # it has ended already
    finally:
        if pidfd is not None:
            os.close(pidfd)


def test_two_servers_take_different_ports():
    servers: list[Application] = []
    try:
        for _ in range(2):
            servers.append(Application(WEB, 100))
            servers[-1].await_start()
        assert len({server.address for server in servers}) == len({server.page for server in servers}) == 2
    finally:
        for server in servers:
            server.stop()
    assert not any(server.running for server in servers)


def children(pid: int, name: str) -> list[int]:
    """Processes of this name that a process has started."""
    found = []
    for child in Path("/proc").iterdir():
        try:
            before, _, after = (child / "stat").read_text().rpartition(")")
        except OSError:
            continue
        if before.partition("(")[2] == name and int(after.split()[1]) == pid and after.split()[0] != "Z":
            found.append(int(child.name))
    return found
