"""What goes wrong is said in one sentence, counted, and never left hanging."""

import os
import resource
import signal
import sys
import time
from pathlib import Path

import pytest
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock

from tests.ros.mission_command import FLYING, MissionCommand, read_bag
from tethernet_bringup.bags.salvage import salvage
from tethernet_bringup.mission import shared_memory
from tethernet_core.system import load_system
from tethernet_msgs.msg import MissionState
from tethernet_planner.docking_groups import docking_groups
from tethernet_ros import topics
from tethernet_ros.checks import mission_from
from tethernet_ros.conversions import time_message
from tethernet_ros.qos import CONTROL, STATE

pytestmark = pytest.mark.ros
LOCKSTEP = ("--pace", "lockstep")


def short(tmp_path, seconds=4.0, **more):
    """A parameter file with which a mission is given up soon."""
    path = tmp_path / "short.yaml"
    lines = [f"    {key}: {value}" for key, value in {"give_up_s": seconds, **more}.items()]
    path.write_text("/**:\n  ros__parameters:\n" + "\n".join(lines) + "\n")
    return ("--params", str(path))


def test_a_controller_killed_in_flight_is_reported_and_the_mission_goes_on(tmp_path, domain_id):
    flags = (*LOCKSTEP, *short(tmp_path, 30.0, trigger_distance_m=0.5, answer_timeout_s=0.5))
    with MissionCommand(tmp_path / "runs", domain_id, *flags) as mission:
        mission.wait_for(FLYING)
        segments = shared_memory.held_by(mission.nodes().values())
        assert segments
        mission.kill_node("mu3_controller")
        status = mission.finish()
        assert status in (0, 3), mission.text
        assert "mu3_controller died (killed by SIGKILL)" in mission.text
        outcome = mission.outcome
        assert outcome["lost_controllers"] == [3]
        assert outcome["faults"] == []
        assert outcome["late_commands"] > 100
        assert "mu3_controller died" in outcome["warnings"][0]
        messages = read_bag(mission.run)
        assert len(messages["/mu3/thrust"]) < len(messages["/mu3/odom"]) <= len(messages["/mu4/thrust"])
        # Some names are used again by whatever else runs on this machine.
        in_use = shared_memory.held_by(int(p.name) for p in Path("/proc").iterdir() if p.name.isdigit())
        assert [name for name in segments - in_use if (shared_memory.FOLDER / name).exists()] == []


def test_the_others_close_the_net_when_a_controller_is_killed_in_flight(tmp_path, domain_id):
    with MissionCommand(tmp_path / "runs", domain_id, *LOCKSTEP) as mission:
        mission.wait_for(FLYING)
        mission.kill_node("mu3_controller")
        assert mission.finish() == 0, mission.text
        states = [mission_from(message) for message in read_bag(mission.run)["/mission/state"]]
        planned = next(state for state in states if state.closing_points)
        assert docking_groups(planned.closing_points, load_system("zenit_8mu")) == [[1, 5, 2, 6, 4, 8, 7]], (
            "the closing leaves the lost one out"
        )
        outcome = mission.outcome
        assert outcome["captured"] is True
        assert outcome["lost_controllers"] == [3]
        assert outcome["locked_pairs"] >= 6
        assert outcome["fuel_kg"][2] < min(fuel for mu, fuel in enumerate(outcome["fuel_kg"]) if mu != 2)


@pytest.mark.parametrize("node", ["planner", "sim", "assessor", "recorder", "mu5_controller"])
def test_a_node_killed_before_launch_ends_the_mission(tmp_path, domain_id, node):
    with MissionCommand(tmp_path, domain_id, *LOCKSTEP) as mission:
        mission.kill_node(node)
        assert mission.finish() == 1, mission.text
        assert f"run_mission.py: fault: {node} died (killed by SIGKILL)" in mission.text
        assert mission.outcome["faults"] == [f"{node} died (killed by SIGKILL)"]
        assert mission.outcome["phase"] != "COMPLETE"


@pytest.mark.parametrize("node", ["planner", "sim", "assessor", "recorder"])
def test_an_essential_node_killed_in_flight_ends_the_mission(tmp_path, domain_id, node):
    with MissionCommand(tmp_path, domain_id, "--pace", "realtime") as mission:
        mission.wait_for(FLYING)
        mission.kill_node(node)
        assert mission.finish() == 1, mission.text
        assert mission.outcome["verdict"].startswith(f"{node} died (killed by SIGKILL)")
        assert mission.outcome["captured"] is False
        if node != "recorder":
            assert len(read_bag(mission.run)["/mu3/thrust"]) > 10


def test_a_planner_that_hangs_in_flight_ends_the_mission(tmp_path, domain_id):
    patience = short(tmp_path, 40.0, hang_timeout_s=2.0)
    with MissionCommand(tmp_path / "runs", domain_id, "--pace", "realtime", *patience) as mission:
        mission.wait_for(FLYING)
        os.kill(mission.nodes()["planner"], signal.SIGSTOP)
        assert mission.finish() == 1, mission.text
        assert mission.outcome["verdict"] == "planner hangs: it has answered nothing for 2 s"
        assert len(read_bag(mission.run)["/mu3/thrust"]) > 10


def test_a_full_disk_ends_the_mission_and_keeps_what_was_recorded(tmp_path, domain_id):
    with MissionCommand(tmp_path, domain_id, *LOCKSTEP) as mission:
        # No file of the mission may grow beyond this: to the recorder that is a disk without room.
        resource.prlimit(mission.process.pid, resource.RLIMIT_FSIZE, (5_000_000, 5_000_000))
        assert mission.finish() == 1, mission.text
        assert "recorder died (exit status 1)" in mission.outcome["verdict"]
        found = salvage(mission.run, tmp_path / "salvaged")
        assert found.message_count > 1000
        assert len(read_bag(tmp_path, "salvaged")["/mu3/thrust"]) > 10


def test_a_second_mission_in_the_same_domain_is_refused_before_it_starts_a_node(tmp_path, domain_id):
    with MissionCommand(tmp_path / "first", domain_id, "--external-mu", "3", "--external-timeout", "80") as first:
        first.wait_for(r"mu_driver\.py --mu 3")
        with MissionCommand(tmp_path / "second", domain_id, *LOCKSTEP, *short(tmp_path)) as second:
            assert second.finish() == 1
            flown_by = f"started by process {first.process.pid}"
            assert f"somebody else is in DDS domain {domain_id}: another mission flies there, {flown_by}" in second.text
            assert "--domain-id" in second.text
            assert list((second.run / "logs").iterdir()) == []
        assert first.process.poll() is None
        assert first.stop(signal.SIGINT)[0] == 130


def test_strangers_in_flight_are_named_and_not_obeyed(tmp_path, domain_id, probe):
    pushing = []

    def push(odometry) -> None:
        """As a second controller would: an answer to each sample, here with all force."""
        command = WrenchStamped(header=odometry.header)
        command.wrench.force.x = 5.0
        pushing[0].publish(command)

    with MissionCommand(tmp_path, domain_id, "--pace", "realtime", *short(tmp_path, 6.0)) as mission:
        mission.wait_for(FLYING)
        pushing.append(probe.node.create_publisher(WrenchStamped, topics.mu_thrust(3), CONTROL))
        probe.listen(topics.mu_odometry(3), Odometry, CONTROL, push)
        state = probe.node.create_publisher(MissionState, topics.MISSION_STATE, STATE)
        state.publish(MissionState(phase=MissionState.ABORTED, sequence=4_000_000_000, mu_count=8))
        while mission.process.poll() is None:
            probe.spin_for(0.05)
        assert mission.finish() == 3, mission.text
        outcome = mission.outcome
        assert outcome["phase"] == "MISSED"
        named = [warning for warning in outcome["warnings"] if "no node of this mission" in warning]
        assert sorted(warning.split(" publishes ")[1] for warning in named) == [
            "/mission/state: not heard, unless with this mission's own DDS profile",
            "/mu3/thrust: not heard, unless with this mission's own DDS profile",
        ]
        assert all("probe, which is no node" in warning and warning in mission.text for warning in named)
        assert not any("not recorded" in warning for warning in outcome["warnings"])
        assert outcome["rejected_commands"] == outcome["clipped_commands"] == 0
        assert outcome["max_tracking_error_m"] < 2.0, "the stranger's 5 N would have carried MU 3 tens of metres away"
        assert len(probe.received[topics.mu_odometry(3)]) > 20, "whoever looks on hears all"


def test_an_external_mu_without_a_driver_is_named(tmp_path, domain_id):
    with MissionCommand(tmp_path, domain_id, "--external-mu", "3", "5", "--external-timeout", "0.5") as mission:
        assert mission.finish() == 1
        assert f"ROS_DOMAIN_ID={domain_id} {sys.executable} examples/mu_driver.py --mu 3" in mission.text
        assert "no driver publishes /mu3/odom, /mu5/odom" in mission.outcome["verdict"]


def test_drivers_that_break_the_contract_are_named_and_nothing_is_launched(tmp_path, domain_id, probe):
    """MU 3 speaks of another frame, MU 5 is on another clock."""
    out = {mu: probe.node.create_publisher(Odometry, topics.mu_odometry(mu), qos_profile_sensor_data) for mu in (3, 5)}

    def answer(clock: Clock) -> None:
        for mu, publisher in out.items():
            message = Odometry(child_frame_id=topics.mu_frame(mu))
            message.header.frame_id = "map" if mu == 3 else topics.FRAME
            message.header.stamp = clock.clock if mu == 3 else time_message(time.time_ns())
            message.pose.pose.orientation.w = 1.0
            publisher.publish(message)

    probe.listen(topics.CLOCK, Clock, CONTROL, answer)
    flags = ("--external-mu", "3", "5", *LOCKSTEP, *short(tmp_path, driver_patience_s=2.0))
    with MissionCommand(tmp_path / "runs", domain_id, *flags) as mission:
        while mission.process.poll() is None:
            probe.spin_for(0.05)
        assert mission.finish() == 1, mission.text
        frame = "header.frame_id is 'launch': seen 'map'"
        assert f"MU 3 cannot fly yet: {frame}" in mission.text
        assert "MU 5 cannot fly yet: stamps agree with the mission's clock within 50 ms: seen" in mission.text
        assert "breaks the driver contract" in mission.outcome["verdict"]
        assert mission.outcome["phase"] == "WAITING"
        assert sum(fuel or 0.0 for fuel in mission.outcome["fuel_kg"]) == 0.0


def test_without_a_simulator_too_nothing_is_launched_and_the_reason_is_what_the_driver_says(tmp_path, domain_id, probe):
    """On the drivers' own clock, all of them best effort: MU 2 speaks of another frame."""
    out = [probe.node.create_publisher(Odometry, topics.mu_odometry(mu), qos_profile_sensor_data) for mu in range(1, 5)]
    flags = ("--mus", "4", "--no-sim", "--debris", "0", "0", "-50", *short(tmp_path, driver_patience_s=2.0))
    with MissionCommand(tmp_path / "runs", domain_id, *flags) as mission:
        while mission.process.poll() is None:
            for mu, publisher in enumerate(out, 1):
                message = Odometry(child_frame_id=topics.mu_frame(mu))
                message.header.frame_id = "map" if mu == 2 else topics.FRAME
                message.header.stamp = time_message(time.time_ns())
                message.pose.pose.orientation.w = 1.0
                publisher.publish(message)
            probe.spin_for(0.05)
        assert mission.finish() == 1, mission.text
        frame = "header.frame_id is 'launch': seen 'map'"
        assert f"MU 2 cannot fly yet: {frame}" in mission.text
        assert "breaks the driver contract" in mission.outcome["verdict"], "and not that there is no odometry"
        assert mission.outcome["phase"] == "WAITING"


def test_an_external_driver_killed_in_flight_is_named_and_the_others_close_the_net(tmp_path, domain_id, processes):
    with MissionCommand(tmp_path, domain_id, "--external-mu", "3", *LOCKSTEP) as mission:
        mission.wait_for(r"mu_driver\.py --mu 3")
        driver = processes.start("driver", "examples/mu_driver.py", "--mu", "3", "--clock", "sim")
        mission.wait_for(FLYING)
        driver.kill()
        assert mission.finish() == 0, mission.text
        [warning] = [text for text in mission.outcome["warnings"] if "has fallen silent" in text]
        assert "the driver of MU 3 has fallen silent" in warning
        assert warning in mission.text
        states = [mission_from(message) for message in read_bag(mission.run)["/mission/state"]]
        planned = next(state for state in states if state.closing_points)
        assert 3 not in {
            mu for group in docking_groups(planned.closing_points, load_system("zenit_8mu")) for mu in group
        }
        assert mission.outcome["locked_pairs"] >= 6


def test_an_output_folder_that_cannot_be_written_is_refused_at_once(tmp_path, domain_id):
    (tmp_path / "file").write_text("")
    with MissionCommand(tmp_path / "file" / "runs", domain_id) as mission:
        assert mission.finish() == 1
        assert "cannot make a run's folder there: Not a directory" in mission.text
        assert mission.nodes() == {}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--mus", "5"), "--mus 5: no such system; allowed: 4 or 8"),
        (("--debris", "0", "0", "-10"), "allowed: -60 to -40 m"),
        (("--debris", "0", "0", "nan"), "finite"),
        (("--params", "/nowhere.yaml"), "/nowhere.yaml"),
        (("--policy", "best"), "allowed: nominal"),
        (("--policy", "/nowhere/policy.safetensors"), "there is no file /nowhere/policy.safetensors"),
    ],
)
def test_bad_usage_starts_nothing(tmp_path, domain_id, words, message):
    with MissionCommand(tmp_path / "runs", domain_id, *words) as mission:
        assert mission.finish() == 2
        assert message in mission.text
        assert not (tmp_path / "runs").exists()


def test_all_is_written_and_told_before_the_middleware_can_hang_in_leaving(tmp_path, domain_id):
    program = tmp_path / "hanging.py"
    program.write_text(
        "import ctypes\n"
        "import rclpy\n"
        "from tethernet_bringup.mission import command_line\n"
        "from tethernet_ros import executor\n"
        "executor._LEAVE_S = 0.5\n"
        "rclpy.try_shutdown = lambda: ctypes.PyDLL(None).pause()  # with the interpreter's lock\n"
        "raise SystemExit(command_line.main())\n"
    )
    flags = (*LOCKSTEP, *short(tmp_path))
    with MissionCommand(tmp_path / "runs", domain_id, *flags, program=(str(program),)) as mission:
        assert mission.finish() == 3, mission.text
        assert mission.outcome["exit_status"] == 3
        assert mission.outcome["phase"] == "MISSED"
        assert mission.outcome["verdict"] in mission.text
        assert read_bag(mission.run)["/mission/state"]
