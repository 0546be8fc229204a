"""The recorder as a process: keeps what is said, whatever ends it."""

import importlib
import json
import os
import resource
import signal
import subprocess
import sys
import time

import pytest
import yaml
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rosbags.highlevel import AnyReader

from tests import toy_mission
from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.bags.salvage import salvage
from tethernet_bringup.recorder.recorded_topics import mission_topics

pytestmark = pytest.mark.ros

MODULE = "tethernet_bringup.recorder.recorder_node"
SHORT_S = 3.0


class Mission:
    """Says on all topics what the toy mission says."""

    def __init__(self, probe, mus=8):
        self.mus = mus
        self.probe = probe
        self.publishers = []
        self.said = 0
        for topic in mission_topics(mus):
            package, _, name = topic.type_name.split("/")
            kind = getattr(importlib.import_module(f"{package}.msg"), name)
            durability = QoSDurabilityPolicy.TRANSIENT_LOCAL if topic.latched else QoSDurabilityPolicy.VOLATILE
            qos = QoSProfile(depth=topic.depth, durability=durability)
            self.publishers.append(probe.node.create_publisher(kind, topic.name, qos))

    def wait_for_recorder(self, process):
        """Until both sides know of each other: what a publisher sends before the recorder knows it is lost."""
        self.probe.wait_for(lambda: "all topics have a publisher" in process.output, "the recorder's publishers")
        self.probe.wait_for(lambda: all(p.get_subscription_count() for p in self.publishers), "the subscriptions")

    def fly(self, end_s=SHORT_S, rate_hz=400.0, until=lambda: False):
        """Say it all, at so many control ticks a second."""
        begin = time.monotonic()
        for number, stamp, data in toy_mission.serialized(self.mus, end_s):
            ahead = (stamp - toy_mission.START_NS) * 1e-9 * 20.0 / rate_hz - (time.monotonic() - begin)
            if ahead > 0.0:
                time.sleep(ahead)
            elif ahead < -2.0 / rate_hz:
                begin -= ahead  # no bursts to catch up: nobody flies like that
            self.publishers[number].publish(data)
            self.said += 1
            if until():
                return


INTERRUPTED = """
import os, signal, sys
from tethernet_bringup.recorder import recorder_node

subscribe, made = recorder_node.Recorder._subscribe, []


def interrupted(self, source, quality):
    subscribe(self, source, quality)
    made.append(source)
    if len(made) == 3:
        os.kill(os.getpid(), signal.SIGINT)


recorder_node.Recorder._subscribe = interrupted
status = recorder_node.main(sys.argv)
print(len(made))
sys.exit(status)
"""


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "info.json").write_text(json.dumps({"seed": 7, "mus": 8}))
    return folder


def start(processes, run, *, expected=0, **parameters):
    given = {"output": run / "bag", "run_info": run / "info.json"} | parameters
    return processes.node(MODULE, *(f"{name}:={value}" for name, value in given.items()), expected=expected)


def test_interrupted_while_it_subscribes_it_closes_the_bag(domain_id, run):
    given = ("-p", f"output:={run / 'bag'}", "-p", f"run_info:={run / 'info.json'}")
    command = [sys.executable, "-P", "-c", INTERRUPTED, "--ros-args", *given]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == ["3"], "what else could be heard nobody needs"
    assert "Traceback" not in done.stderr
    with AnyReader([run / "bag"]) as reader:
        assert reader.message_count == 0


def stop(process, number=signal.SIGINT):
    process.send(number)
    return process.wait(10.0)


def report(run):
    return json.loads((run / "recorder.json").read_text())


def read_strictly(bag):
    """All messages, by a reader that insists on a finished bag."""
    with AnyReader([bag]) as reader:
        return sorted((c.topic, t, unpadded(data)) for c, t, data in reader.messages())


def unpadded(data):
    """DDS fills the last word of a message up, without a rule with what."""
    return bytes(data).rstrip(b"\0")


def expected(end_s=SHORT_S):
    names = [topic.name for topic in mission_topics(8)]
    return sorted((names[number], stamp, unpadded(data)) for number, stamp, data in toy_mission.serialized(8, end_s))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_everything_said_is_in_the_bag(processes, probe, run, number):
    process = start(processes, run)
    mission = Mission(probe)
    mission.wait_for_recorder(process)
    mission.fly()
    assert stop(process, number) == 0  # at once: the queues are drained first
    assert read_strictly(run / "bag") == expected()
    assert report(run)["state"] == "complete"
    assert report(run)["message_count"] == mission.said
    assert report(run)["messages"]["/mu3/thrust"] == round(SHORT_S * 20) + 1
    assert report(run)["never_arrived"] == {}
    information = yaml.safe_load((run / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["custom_data"] == {"seed": "7", "mus": "8"}
    assert information["message_count"] == mission.said


def test_latched_messages_from_before_are_recorded(processes, probe, run):
    mission = Mission(probe)
    number = next(i for i, topic in enumerate(mission_topics(8)) if topic.name == "/mission/state")
    data = next(data for which, _, data in toy_mission.serialized(8, SHORT_S) if which == number)
    mission.publishers[number].publish(data)
    process = start(processes, run)
    mission.wait_for_recorder(process)
    assert stop(process) == 0
    (message,) = open_bag(run).messages()
    assert (message.topic, unpadded(message.data)) == ("/mission/state", unpadded(data))


def test_a_message_without_a_stamp_is_dated_by_the_missions_time(processes, probe, run):
    """What a node latches before it knows the time carries a stamp of 0, which readers take for unset."""
    from tethernet_msgs.msg import MuStatus

    mission = Mission(probe)
    number = next(i for i, topic in enumerate(mission_topics(8)) if topic.name == "/mu4/status")
    mission.publishers[number].publish(MuStatus(mu=4))
    process = start(processes, run)
    mission.wait_for_recorder(process)
    mission.fly(0.5)
    assert stop(process) == 0
    times = [(m.log_time, m.publish_time) for m in open_bag(run).messages() if m.topic == "/mu4/status"]
    assert len(times) == 1 + 3
    first, last = toy_mission.START_NS, toy_mission.START_NS + 500_000_000
    assert all(first <= log_time == publish_time <= last for log_time, publish_time in times)


def test_after_kill_9_all_but_the_last_second_is_readable(processes, probe, run):
    process = start(processes, run)
    mission = Mission(probe)
    mission.wait_for_recorder(process)
    toy_mission.serialized(8, 40.0)  # makes it, if no other test has
    killed = time.monotonic() + 2.5
    mission.fly(end_s=40.0, rate_hz=20.0, until=lambda: time.monotonic() >= killed)
    flown_s = toy_mission.serialized(8, 40.0)[mission.said - 1][1] * 1e-9
    process.kill()
    result = salvage(run / "bag", run / "salvaged")
    assert result.end_ns * 1e-9 > flown_s - 1.0
    assert result.end_ns > 0
    read = read_strictly(result.folder)
    sent = expected(40.0)
    assert set(read) <= set(sent)
    whole_until = result.end_ns - 200_000_000  # a look at the queues and a tick in flight
    assert [m for m in read if m[1] < whole_until] == [m for m in sent if m[1] < whole_until]
    information = yaml.safe_load((run / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert len(information["topics_with_message_count"]) == len(mission_topics(8)), "written at the start"
    assert 0 < report(run)["message_count"] <= len(read), "the report is renewed in flight"


def test_lock_step_traffic_is_kept_up_with(processes, probe, run):
    """Some 4000 messages a second, as in lock-step at eight times real time."""
    process = start(processes, run)
    mission = Mission(probe)
    mission.wait_for_recorder(process)
    mission.fly(end_s=20.0, rate_hz=160.0)
    assert stop(process) == 0
    assert report(run)["message_count"] == mission.said
    assert report(run)["never_arrived"] == {}


def test_extra_topics_are_recorded(processes, probe, run):
    from std_msgs.msg import String

    process = start(processes, run, extra_topics="/weather std_msgs/msg/String")
    publisher = probe.node.create_publisher(String, "/weather", 10)
    mission = Mission(probe)
    mission.wait_for_recorder(process)
    probe.wait_for(publisher.get_subscription_count, "the recorder on the topic of our own")
    publisher.publish(String(data="early"))
    mission.fly(0.5)
    publisher.publish(String(data="solar wind"))
    assert stop(process) == 0
    with AnyReader([run / "bag"]) as reader:
        said = [
            (time_ns, reader.deserialize(data, c.msgtype).data)
            for c, time_ns, data in reader.messages()
            if c.topic == "/weather"
        ]
    assert [text for _, text in said] == ["early", "solar wind"]
    launch = toy_mission.START_NS
    assert launch <= said[0][0] <= said[1][0] <= launch + 500_000_000, "logged at the mission's time"


def small_disk(path):
    """Mount a file system of 6 MiB, where that is allowed."""
    path.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=6m", "none", path], capture_output=True, check=False)
    if done.returncode:
        pytest.skip(f"no file system may be mounted here: {done.stderr.decode().strip()}")
    return path


def test_a_full_disk_ends_the_recording_and_keeps_all_of_it(processes, probe, run):
    disk = small_disk(run / "disk")
    try:
        process = start(processes, run, output=disk / "bag", expected=1)
        mission = Mission(probe)
        mission.wait_for_recorder(process)
        mission.fly(end_s=40.0, until=lambda: not process.running)
        assert process.wait(10.0) == 1
        assert "recording ended early" in process.output
        assert "No space left on device" in process.output
        read = read_strictly(disk / "bag")
        assert len(read) > 1000
        assert set(read) <= set(expected(40.0))
        content = json.loads((disk / "recorder.json").read_text())
        assert content["state"] == "fault"
        assert content["message_count"] == len(read)
        assert "No space left" in content["fault"]
    finally:
        subprocess.run(["umount", disk], check=True)


def test_a_write_error_keeps_what_is_there(processes, probe, run):
    """A file may not grow beyond 1 MB: every later write fails, also that of the index."""
    process = start(processes, run, chunk_bytes=100_000, expected=1)
    mission = Mission(probe)
    mission.wait_for_recorder(process)
    resource.prlimit(process._popen.pid, resource.RLIMIT_FSIZE, (1_000_000, 1_000_000))
    mission.fly(end_s=40.0, until=lambda: not process.running)
    assert process.wait(10.0) == 1
    assert "File too large" in process.output
    kept = list(open_bag(run).messages())
    assert len(kept) == report(run)["message_count"] > 1000
    assert {(m.topic, m.log_time, unpadded(m.data)) for m in kept} <= set(expected(40.0))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_an_unwritable_folder_is_told(processes, run):
    run.chmod(0o555)
    process = start(processes, run, expected=1)
    assert process.wait() == 1
    assert "Permission denied" in process.output


def test_a_file_in_the_way_is_told(processes, run):
    (run / "bag").write_text("a file")
    process = start(processes, run, expected=1)
    assert process.wait() == 1
    assert "recorder: cannot make the bag's folder" in process.output


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ({"system": "zenit_5mu"}, "no system 'zenit_5mu'"),
        ({"flush_period_s": 0.0}, "allowed: 0.05 to 60"),
        ({"flush_perod_s": 1.0}, "has no parameter 'flush_perod_s'"),
        ({"run_info": "/nowhere.json"}, "run_info: cannot read /nowhere.json"),
        ({"extra_topics": "/a no_msgs/msg/Thing"}, "cannot record /a: message type no_msgs/msg/Thing"),
        ({"extra_topics": "/clock rosgraph_msgs/msg/Clock"}, "/clock is recorded already"),
    ],
)
def test_bad_parameters_are_told(processes, run, parameters, told):
    process = start(processes, run, expected=2, **parameters)
    assert process.wait() == 2
    assert told in process.output
    assert not (run / "bag").exists()


def test_an_unexpected_argument_is_told(processes):
    process = processes.start("recorder", "-m", MODULE, "--fast", expected=2)
    assert process.wait() == 2
    assert "unexpected argument '--fast'" in process.output
