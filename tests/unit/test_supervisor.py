import os
import signal
import sys
import textwrap
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tethernet_bringup.mission import dds_profile, supervisor
from tethernet_bringup.mission.supervisor import NodeProcess, Supervisor, mission_environment
from tethernet_bringup.mission.supervisor_settings import SupervisorParameters
from tethernet_core.parameters import load

DEADLINE_S = 20.0

POLITE = """
    import signal, sys
    from pathlib import Path
    def end(number, frame):
        Path(sys.argv[1]).write_text(signal.Signals(number).name)
        print("closing", flush=True)
        sys.exit(0)
    signal.signal(signal.SIGINT, end)
    print("ready", flush=True)
    signal.pause()
"""
STUBBORN = """
    import signal, time
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    print("ready", flush=True)
    while True:
        time.sleep(0.1)
"""
SCHEDULED = """
    import os, signal, sys, threading
    from pathlib import Path
    found = [os.sched_getscheduler(0)]
    thread = threading.Thread(target=lambda: found.append(os.sched_getscheduler(0)))
    thread.start()
    thread.join()
    Path(sys.argv[1]).write_text(" ".join(map(str, found)))
    signal.pause()
"""
DYING = """
    import sys
    print("ready", flush=True)
    print("the disk is full", file=sys.stderr)
    sys.exit(5)
"""


def until(condition, what):
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.01)


def gone(pid):
    """True when there is no such process, or only its remains."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return True


@pytest.fixture
def modules(tmp_path, monkeypatch):
    folder = tmp_path / "modules"
    folder.mkdir()
    for name, source in (("polite", POLITE), ("stubborn", STUBBORN), ("dying", DYING), ("scheduled", SCHEDULED)):
        (folder / f"{name}.py").write_text(textwrap.dedent(source))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")]))
    return folder


@pytest.fixture
def logs(tmp_path):
    folder = tmp_path / "logs"
    folder.mkdir()
    return folder


@pytest.fixture
def crew(modules, logs):
    parameters = load(SupervisorParameters, {"interrupt_patience_s": 1.0, "recorder_patience_s": 1.0})
    with Supervisor(logs, mission_environment(1, "localhost", logs), parameters) as crew:
        yield crew


def ready(crew, *names):
    until(lambda: all("ready" in crew.tail(name) for name in names), f"not ready: {names}")


def test_all_end_on_request_with_those_marked_last_after_the_others(crew, tmp_path):
    crew.start(NodeProcess("recorder", "polite", last=True, arguments=(str(tmp_path / "recorder"),)))
    crew.start(NodeProcess("sim", "polite", arguments=(str(tmp_path / "sim"),)))
    crew.start(NodeProcess("planner", "polite", arguments=(str(tmp_path / "planner"),)))
    pids = crew.pids
    ready(crew, "recorder", "sim", "planner")
    exits = crew.stop()
    assert {e.node.name: e.code for e in exits} == {"recorder": 0, "sim": 0, "planner": 0}
    assert not any(e.forced for e in exits)
    assert all(gone(pid) for pid in pids.values())
    times = {name: (tmp_path / name).stat().st_mtime_ns for name in ("recorder", "sim", "planner")}
    assert times["recorder"] > max(times["sim"], times["planner"])
    assert (tmp_path / "sim").read_text() == "SIGINT"


WAITING = """
    from pathlib import Path
    from tethernet_ros.start_gate import pass_gate
    print("ready", flush=True)
    pass_gate()
    print("in", flush=True)
"""


def test_nodes_wait_until_they_are_let_in(crew, modules):
    (modules / "waiting.py").write_text(textwrap.dedent(WAITING))
    for name in ("sim", "planner"):
        crew.start(NodeProcess(name, "waiting"))
    ready(crew, "sim", "planner")
    time.sleep(0.2)
    assert crew.deaths() == []
    crew.let_in()
    crew.start(NodeProcess("recorder", "waiting"))
    until(lambda: all(crew.tail(name)[-1:] == ("in",) for name in ("sim", "planner", "recorder")), "one still waits")


def test_nodes_that_nobody_lets_in_end_without_a_word(crew, modules):
    (modules / "waiting.py").write_text(textwrap.dedent(WAITING))
    crew.start(NodeProcess("sim", "waiting"))
    ready(crew, "sim")
    [ended] = crew.stop()
    assert (ended.code, ended.tail, ended.forced) == (0, ("ready",), False)


def test_a_node_is_shown_with_its_own_command_line_and_none_of_its_parents_descriptors(crew, tmp_path):
    with (tmp_path / "open").open("w"):
        crew.start(NodeProcess("mu12_controller", "polite", arguments=(str(tmp_path / "x"), "__node:=mu12_controller")))
    ready(crew, "mu12_controller")
    place = Path(f"/proc/{crew.pids['mu12_controller']}")
    shown = (place / "cmdline").read_bytes().replace(b"\0", b" ").decode().rstrip()
    assert shown == f"{sys.executable} -P -m polite {tmp_path / 'x'} __node:=mu12_controller"
    assert (place / "comm").read_text() == "mu12_controller\n"
    assert not [link for link in (place / "fd").iterdir() if link.readlink() == tmp_path / "open"]


def test_who_does_not_end_is_killed_in_time(crew, tmp_path):
    crew.start(NodeProcess("sim", "stubborn"))
    crew.start(NodeProcess("recorder", "polite", last=True, arguments=(str(tmp_path / "recorder"),)))
    ready(crew, "sim", "recorder")
    began = time.monotonic()
    exits = {e.node.name: e for e in crew.stop()}
    assert time.monotonic() - began < 5.0
    assert exits["sim"].forced
    assert exits["sim"].how == "killed by SIGKILL"
    assert not exits["recorder"].forced
    assert crew.stop() == []


def test_after_its_end_no_node_is_started(crew):
    """Its pipe is closed: a node would read the terminal instead, and never learn that the supervisor is gone."""
    crew.stop()
    with pytest.raises(RuntimeError, match="sim cannot be started: this supervisor has stopped; make another one"):
        crew.start(NodeProcess("sim", "polite"))
    assert not crew.pids


def test_the_shipped_patience_ends_everything_within_six_seconds():
    p = load(SupervisorParameters)
    worst = p.abort_timeout_s + p.interrupt_patience_s + p.recorder_patience_s
    worst += 2.0 * (p.terminate_patience_s + supervisor._KILL_PATIENCE_S)
    assert worst <= 6.0


def test_a_death_is_reported_once_with_exit_status_and_last_lines(crew):
    crew.start(NodeProcess("assessor", "dying"))
    deaths = []
    until(lambda: deaths.extend(crew.deaths()) or deaths, "no death seen")
    assert deaths[0].code == 5
    assert deaths[0].tail[-1] == "the disk is full"
    assert "assessor died (exit status 5)" in deaths[0].report()
    assert "| the disk is full" in deaths[0].report()
    assert crew.deaths() == []
    assert crew.stop() == []


def test_a_killed_node_is_named_by_its_signal(crew, tmp_path):
    crew.start(NodeProcess("mu3_controller", "polite", essential=False, arguments=(str(tmp_path / "x"),)))
    os.kill(crew.pids["mu3_controller"], signal.SIGKILL)
    deaths = []
    until(lambda: deaths.extend(crew.deaths()) or deaths, "no death seen")
    assert deaths[0].how == "killed by SIGKILL"


def test_nodes_do_not_get_the_terminals_interrupt(crew, tmp_path):
    crew.start(NodeProcess("sim", "polite", arguments=(str(tmp_path / "sim"),)))
    until(lambda: os.getsid(crew.pids["sim"]) == crew.pids["sim"], "it stays in the terminal's session")


def test_the_environment_is_built_and_not_inherited(tmp_path):
    base = {
        "PATH": "/bin",
        "HOME": "/home/u",
        "SECRET": "x",
        "ROS_DOMAIN_ID": "9",
        "ROS_LOCALHOST_ONLY": "1",
        "RMW_IMPLEMENTATION": "r",
        "PYTHONPATH": ":/mine:lib:.:",
        "LD_LIBRARY_PATH": ":.",
    }
    made = mission_environment(42, "subnet", tmp_path, base)
    assert made["ROS_DOMAIN_ID"] == "42"
    assert made["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"
    assert made["ROS_LOG_DIR"] == str(tmp_path)
    assert made["OMP_NUM_THREADS"] == made["NUMBA_NUM_THREADS"] == "1"
    assert (made["PATH"], made["HOME"], made["RMW_IMPLEMENTATION"]) == ("/bin", "/home/u", "r")
    assert not {"SECRET", "ROS_LOCALHOST_ONLY"} & set(made)
    assert made["PYTHONPATH"] == "/mine", "nothing that depends on the folder the user stands in"
    assert "LD_LIBRARY_PATH" not in made
    assert mission_environment(0, "localhost", tmp_path, {})["HOME"]


def test_nodes_talk_through_the_profile_that_stays_on_this_machine(tmp_path):
    base = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "HOME": "/"}
    changed = dds_profile.use_profile(base, tmp_path)
    assert changed["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SYSTEM_DEFAULT"
    path = Path(changed["FASTRTPS_DEFAULT_PROFILES_FILE"])
    text = ElementTree.parse(path).getroot()
    assert path.parent == tmp_path
    assert [e.text for e in text.iter() if e.tag.endswith("}address")] == ["127.0.0.1", "127.0.0.1"]
    [lease] = [e for e in text.iter() if e.tag.endswith("}leaseDuration")]
    assert float(lease[0].text) > 300.0, "longer than a mission in real time"
    [announced] = [e for e in text.iter() if e.tag.endswith("}initialAnnouncements")]
    count, period = announced
    seconds, nanoseconds = (float(part.text) for part in period)
    assert seconds + 1e-9 * nanoseconds <= 0.2, "what is lost comes again soon"
    assert float(count.text) * (seconds + 1e-9 * nanoseconds) >= 3.0, "until all nodes of a mission are there"


def test_what_only_the_mission_publishes_is_read_in_its_own_partition_and_written_for_all(tmp_path):
    base = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    changed = dds_profile.use_profile(base, tmp_path, "mission-1", ["/mu1/thrust"])
    root = ElementTree.parse(changed["FASTRTPS_DEFAULT_PROFILES_FILE"]).getroot()
    found = {
        (end, e.get("profile_name")): next(v.text for v in e.iter() if v.tag.endswith("}value"))
        for end in ("writer", "reader")
        for e in root.iter()
        if e.tag.endswith(f"}}data_{end}")
    }
    assert found == {("writer", "/mu1/thrust"): ";mission-1", ("reader", "/mu1/thrust"): "mission-1"}


def test_who_only_looks_on_shares_no_memory_with_those_that_fly(tmp_path):
    base = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    kinds = {}
    for shared in (True, False):
        changed = dds_profile.use_profile(base, tmp_path, "mission-1", ["/mu1/thrust"], shared_memory=shared)
        path = Path(changed["FASTRTPS_DEFAULT_PROFILES_FILE"])
        root = ElementTree.parse(path).getroot()
        kinds[path.name] = [e.text for e in root.iter() if e.tag.endswith("}type")]
        readers = [e for e in root.iter() if e.tag.endswith("}data_reader")]
        assert [e.get("profile_name") for e in readers] == ["/mu1/thrust"], "and hears the mission alone"
    assert kinds == {"fast_dds.xml": ["SHM", "UDPv4"], "fast_dds_aside.xml": ["UDPv4"]}


def test_discovery_in_the_subnet_is_not_bound_to_this_machine(tmp_path):
    changed = dds_profile.use_profile({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, tmp_path)
    assert changed["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"
    assert "127.0.0.1" not in Path(changed["FASTRTPS_DEFAULT_PROFILES_FILE"]).read_text()


@pytest.mark.parametrize(
    "chosen", [{"FASTRTPS_DEFAULT_PROFILES_FILE": "/my.xml"}, {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}]
)
def test_what_the_user_has_chosen_of_the_middleware_stays(tmp_path, chosen):
    base = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", **chosen}
    assert dds_profile.use_profile(base, tmp_path) == base
    assert list(tmp_path.iterdir()) == []


def test_memory_counts_all_processes(crew, tmp_path):
    alone = crew.memory_mb()
    assert alone > 1.0
    crew.start(NodeProcess("sim", "polite", arguments=(str(tmp_path / "sim"),)))
    ready(crew, "sim")
    assert crew.memory_mb() > alone + 1.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_node_that_is_stopped_while_python_starts_says_nothing(crew, number):
    for index in range(8):  # at moments from the very first on
        name = f"node{index}"
        crew.start(NodeProcess(name, "polite", arguments=("/dev/null",)))
        time.sleep(0.01 * index)
        os.kill(crew.pids[name], number)
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == set(), "the supervisor itself holds nothing back"
    until(lambda: crew.deaths() == [] and not crew.pids, "not all have ended")
    assert {crew.tail(f"node{index}") for index in range(8)} <= {(), ("ready",), ("ready", "closing")}


def test_the_threads_of_a_batch_process_interrupt_nobody_and_those_of_others_do(crew, tmp_path):
    for name, batch in (("recorder", True), ("sim", False)):
        crew.start(NodeProcess(name, "scheduled", batch=batch, arguments=(str(tmp_path / name),)))
    for name, expected in (("recorder", os.SCHED_BATCH), ("sim", os.SCHED_OTHER)):
        until(lambda name=name: (tmp_path / name).exists() and (tmp_path / name).read_text(), name)
        assert (tmp_path / name).read_text() == f"{expected} {expected}", name
