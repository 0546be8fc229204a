"""The command's view of a mission on a machine that is too busy to look at it."""

from __future__ import annotations

import pytest

from tests.ros.test_door import honest_messages
from tethernet_bringup.mission.monitor_node import Monitor
from tethernet_bringup.mission.outcome import FlightRecord
from tethernet_core.system import load_system
from tethernet_msgs.msg import CaptureAssessment
from tethernet_ros import qos, topics
from tethernet_ros.conversions import set_stamp

pytestmark = pytest.mark.ros


@pytest.fixture
def record() -> FlightRecord:
    return FlightRecord(system=load_system("zenit_8mu"), seed=1, policy="nominal")


@pytest.fixture
def monitor(record, domain_id):
    monitor = Monitor(record)
    yield monitor
    monitor.close(0)


def test_what_is_said_once_is_heard_however_much_is_said_after_it(monitor, record, probe):
    message = honest_messages()[topics.CAPTURE_ASSESSMENT]
    # In lock-step some 20 assessments come in a second; the command did not look for half a second and more.
    for tick in range(1, 81):
        message.stage = CaptureAssessment.TRIGGER if tick == 1 else CaptureAssessment.PROGRESS
        set_stamp(message.header.stamp, tick * 50_000_000)
        probe.publish(topics.CAPTURE_ASSESSMENT, message, qos.STATE_BACKLOG)
    probe.wait_for(lambda: monitor.spin(0.1) or record.progress is not None, "an assessment")
    probe.wait_for(lambda: monitor.spin(0.1) or record.progress.header.stamp.sec == 4, "the newest")
    assert record.trigger is not None
    assert record.trigger.header.stamp.nanosec == 50_000_000
