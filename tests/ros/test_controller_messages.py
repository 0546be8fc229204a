"""Messages at the nodes' edges; no process, no DDS."""

import math
import random
import struct

import pytest
from geometry_msgs.msg import Quaternion, Vector3
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message

from tethernet_core import rotation
from tethernet_core.mission import Mission, abort, arm, launch
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.system import load_system
from tethernet_planner.mission_rules import advance
from tethernet_ros import checks
from tethernet_ros.conversions import coordinates, mission_message, nanoseconds, time_message
from tethernet_ros.serialized import odometry_sample
from tethernet_ros.well_formed import MessageError

DEBRIS = (0.1, 0.2, -50.0)


def odometry(generator, child="mu3", turned=False):
    message = Odometry()
    message.header.frame_id, message.child_frame_id = "launch", child
    message.header.stamp.sec, message.header.stamp.nanosec = generator.randrange(2**31), generator.randrange(10**9)
    place, speed = message.pose.pose.position, message.twist.twist.linear
    place.x, place.y, place.z = (generator.gauss(0.0, 30.0) for _ in range(3))
    speed.x, speed.y, speed.z = (generator.gauss(0.0, 30.0) for _ in range(3))
    message.pose.covariance[:] = [generator.random() for _ in range(36)]
    message.twist.covariance[:] = [generator.random() for _ in range(36)]
    q = message.pose.pose.orientation
    q.z, q.w = (0.6, 0.8) if turned else (0.0, 1.0)
    return message


@pytest.mark.parametrize("length", range(10))
@pytest.mark.parametrize("turned", [False, True])
def test_bytes_say_the_same_as_the_message(length, turned):
    message = odometry(random.Random(length), "m" * length, turned)
    pose, twist = message.pose.pose, message.twist.twist
    sample = odometry_sample(serialize_message(message))
    q, velocity = pose.orientation, coordinates(twist.linear)
    assert sample.stamp_ns == nanoseconds(message.header.stamp)
    assert sample.position == coordinates(pose.position)
    assert sample.attitude == (q.x, q.y, q.z, q.w)
    assert (sample.linear, sample.angular) == (velocity, coordinates(twist.angular))
    assert sample.velocity == (rotation.turned(rotation.unit(sample.attitude), velocity) if turned else velocity)


def test_bytes_of_another_machine_say_the_same():
    message = odometry(random.Random(5))
    stamp = message.header.stamp
    pose, twist = message.pose.pose, message.twist.twist
    q = pose.orientation
    big = struct.pack(">iI", stamp.sec, stamp.nanosec) + struct.pack(">I", 7) + b"launch\0\0"
    big += struct.pack(">I", 4) + b"mu3\0"
    big += b"\0" * (-len(big) % 8)
    big += struct.pack(">7d36d", *coordinates(pose.position), q.x, q.y, q.z, q.w, *message.pose.covariance)
    big += struct.pack(">6d36d", *coordinates(twist.linear), *coordinates(twist.angular), *message.twist.covariance)
    assert odometry_sample(b"\0\0\0\0" + big) == odometry_sample(serialize_message(message))


def test_odometry_that_breaks_the_contract_is_refused_with_the_reason():
    for change, words in (
        (lambda m: setattr(m.header, "frame_id", "mäp"), "frame 'mäp'; allowed: 'launch'"),
        (lambda m: setattr(m.header.stamp, "sec", -5), "allowed: from 0 s on"),
        (lambda m: setattr(m.header.stamp, "nanosec", 1_000_000_000), "less than 1e9 ns"),
        (lambda m: setattr(m.pose.pose.orientation, "w", 0.0), "norm 0; allowed: 1"),
        (lambda m: setattr(m.pose.pose.orientation, "w", 1e200), "norm inf; allowed: 1"),
        (lambda m: setattr(m.pose.pose.orientation, "x", math.nan), "norm nan; allowed: 1"),
        (lambda m: setattr(m.pose.pose.position, "y", math.nan), "nan"),
        (lambda m: setattr(m.pose.pose.position, "y", 1e200), "allowed: finite, within 1e+06 m"),
        (lambda m: setattr(m.twist.twist.linear, "z", -math.inf), "allowed: finite, within 100000 m/s"),
        (lambda m: setattr(m.twist.twist.angular, "x", math.nan), "angular rate (nan"),
    ):
        message = odometry(random.Random(1))
        change(message)
        with pytest.raises(MessageError) as error:
            odometry_sample(serialize_message(message))
        assert words in str(error.value)


@pytest.mark.parametrize("child", ["", "mu5", "mu33", "mu", "mü3", "x" * 1000])
def test_odometry_of_another_unit_is_refused(child):
    """One publisher on the topic of another: its numbers are sound, and of another unit."""
    message = odometry(random.Random(4))
    message.child_frame_id = child
    data = serialize_message(message)
    with pytest.raises(MessageError, match=rf"child frame '{child[:40]}'; allowed: 'mu3'"):
        checks.odometry(3).read(data)
    assert checks.odometry().read(data) == odometry_sample(data)
    message.child_frame_id = "mu3"
    assert checks.odometry(3).read(serialize_message(message)) == odometry_sample(data)


@pytest.mark.parametrize("size", [0, 3, 4, 11, 16, 30, 100, 700])
def test_bytes_cut_short_are_an_error_and_not_nonsense(size):
    data = serialize_message(odometry(random.Random(2)))
    with pytest.raises(MessageError, match=r"bytes that are no Odometry|frame"):
        odometry_sample(data[:size])


def test_velocity_is_turned_by_a_normalised_attitude_and_a_wrong_one_refused():
    half = math.sqrt(0.5) * 1.0005
    message = odometry(random.Random(4))
    message.twist.twist.linear = Vector3(x=1.0)
    message.pose.pose.orientation = Quaternion(z=half, w=half)
    assert odometry_sample(serialize_message(message)).velocity == pytest.approx((0.0, 1.0, 0.0))
    for bad in (Quaternion(w=1.1), Quaternion(x=math.nan, w=0.9), Quaternion(x=5.0, w=1.0)):
        message.pose.pose.orientation = bad
        with pytest.raises(MessageError, match="allowed: 1 within"):
            odometry_sample(serialize_message(message))


def test_missions_survive_the_way_through_a_message():
    control, rules = load(ControlParameters), load(MissionParameters)
    armed = arm(Mission(8), DEBRIS, "nominal")
    flying = launch(armed, 1_795_321_864_694_434_410)
    closing = advance(flying, load_system("zenit_8mu"), flying.launch_ns + 10**10, DEBRIS, DEBRIS, rules, control)
    for mission in (armed, flying, closing, abort(closing, "why")):
        message = mission_message(mission, 7, True)
        assert checks.mission_state(load_system("zenit_8mu")).read(serialize_message(message)).mission == mission
        assert (nanoseconds(message.header.stamp), message.confirmed, message.header.frame_id) == (7, True, "launch")
    assert mission_message(flying, 0, True, "not confirmed by MU 3").reason == "not confirmed by MU 3"


def test_stamps_are_exact():
    for stamp_ns in (0, 1, 999_999_999, 1_000_000_000, 2_147_483_647_999_999_999):
        assert nanoseconds(time_message(stamp_ns)) == stamp_ns
