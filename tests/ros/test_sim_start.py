"""The simulator's process while it loads its kernels: in the graph already, not yet at work, free to end."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger

from tethernet_msgs.msg import NetState
from tethernet_ros import qos, topics
from tethernet_ros.connections import service_name

pytestmark = pytest.mark.ros

BEGUN = "the kernels are being loaded"
PROGRAM = f"""
import sys
import time
from pathlib import Path
from tethernet_sim.ros import kernel_loading, sim_node

loaded, broken = map(Path, sys.argv[1:3])

def load(say, *_):
    say({BEGUN!r})
    while not loaded.exists():
        if broken.exists():
            raise OSError("the cache cannot be read")
        time.sleep(0.01)

kernel_loading.load_kernels = load
sys.exit(sim_node.main(["sim", "--ros-args", "-p", "system:=zenit_4mu", "-p", "pace:=lockstep"]))
"""


class Loading:
    """The simulator's process, whose kernels are loaded when the test says so."""

    def __init__(self, probe, processes, folder: Path):
        program = folder / "slow_sim.py"
        program.write_text(PROGRAM, encoding="utf-8")
        self._loaded, self._broken = folder / "loaded", folder / "broken"
        self.debris = probe.listen(topics.DEBRIS_ODOMETRY, Odometry, qos.STATE)
        self._net = probe.listen(topics.NET_STATE, NetState, qos.BULK)
        self.process = processes.start("slow_sim", str(program), str(self._loaded), str(self._broken))
        probe.wait_for(lambda: BEGUN in self.process.output, "the begin of loading")
        self.asker = probe.node.create_client(Trigger, service_name("sim"))

        def there() -> bool:
            published = [topics.CLOCK, topics.DEBRIS_ODOMETRY, topics.NET_STATE, topics.mu_odometry(4)]
            heard = [topics.MISSION_STATE, topics.PLANNER_HEARTBEAT, topics.mu_thrust(4)]
            return all(map(probe.node.count_publishers, published)) and all(map(probe.node.count_subscribers, heard))

        probe.wait_for(lambda: there() and self.asker.service_is_ready(), "the simulator's endpoints")

    def end(self) -> None:
        self._loaded.touch()

    def fail(self) -> None:
        self._broken.touch()


@pytest.fixture
def loading(probe, processes, tmp_path) -> Loading:
    return Loading(probe, processes, tmp_path)


def test_its_node_is_found_while_its_kernels_load_and_answers_when_they_are_there(probe, loading):
    answer = loading.asker.call_async(Trigger.Request())
    probe.spin_for(1.0)
    assert not answer.done()
    assert not loading.debris, "nothing is told of a world that is not there yet"
    loading.end()
    probe.wait_for(answer.done, "the answer")
    assert answer.result().success
    probe.wait_for(lambda: loading.debris, "the debris' odometry")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_a_signal_while_its_kernels_load_ends_it_in_order(probe, loading, number):
    loading.process.send(number)
    assert loading.process.wait() == 0
    assert loading.process.output.splitlines() == [BEGUN]
    # A participant that does not say goodbye stays in the graph for its lease, 20 s by default.
    probe.wait_for(lambda: "sim" not in probe.node.get_node_names(), "the end of its node", 10.0)


def test_why_its_kernels_cannot_be_loaded_is_told(loading):
    loading.process.expected = {1}
    loading.fail()
    assert loading.process.wait() == 1
    assert "stopped by OSError: the cache cannot be read" in loading.process.output
    loading.process.log.write_text("")  # the traceback is wanted here
