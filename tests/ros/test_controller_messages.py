"""Messages at the nodes' edges; no process, no DDS."""

import math
import random

import pytest
from geometry_msgs.msg import Quaternion, Vector3
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message

from tethernet_control.mission import Mission, abort, advance, arm, launch
from tethernet_control.parameters import load
from tethernet_control.ros.conversions import (
    MessageError,
    mission_from,
    mission_message,
    nanoseconds,
    odometry_values,
    time_message,
)
from tethernet_control.ros.serialized_odometry import serialized_odometry_values
from tethernet_control.settings import ControlParameters, MissionParameters

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
    assert serialized_odometry_values(serialize_message(message)) == odometry_values(message)


def test_bytes_in_another_frame_or_without_attitude_are_refused_alike():
    generator = random.Random(1)
    wrong_frame, no_attitude = odometry(generator), odometry(generator)
    wrong_frame.header.frame_id = "mäp"
    no_attitude.pose.pose.orientation.w = 0.0
    for message, words in ((wrong_frame, "frame 'mäp'; allowed: 'launch'"), (no_attitude, "norm 0; allowed: 1")):
        for read, source in ((odometry_values, message), (serialized_odometry_values, serialize_message(message))):
            with pytest.raises(MessageError) as error:
                read(source)
            assert words in str(error.value)


@pytest.mark.parametrize("size", [0, 3, 4, 11, 30, 100, 700])
def test_bytes_cut_short_are_an_error_and_not_nonsense(size):
    data = serialize_message(odometry(random.Random(2)))
    with pytest.raises(Exception, match=r".+"):
        serialized_odometry_values(data[:size])


def test_numbers_that_are_not_finite_pass_to_whoever_counts_them():
    message = odometry(random.Random(3))
    message.pose.pose.position.y = math.nan
    assert math.isnan(serialized_odometry_values(serialize_message(message))[1][1])


def test_velocity_is_turned_by_a_normalised_attitude_and_a_wrong_one_refused():
    half = math.sqrt(0.5) * 1.0005
    message = odometry(random.Random(4))
    message.twist.twist.linear = Vector3(x=1.0)
    message.pose.pose.orientation = Quaternion(z=half, w=half)
    assert odometry_values(message)[2] == pytest.approx((0.0, 1.0, 0.0))
    for bad in (Quaternion(w=1.1), Quaternion(x=math.nan, w=0.9)):
        message.pose.pose.orientation = bad
        with pytest.raises(MessageError, match="allowed: 1 within"):
            odometry_values(message)


def test_missions_survive_the_way_through_a_message():
    control, rules = load(ControlParameters), load(MissionParameters)
    armed = arm(Mission(8), DEBRIS, "nominal")
    flying = launch(armed, 1_795_321_864_694_434_410)
    closing = advance(flying, flying.launch_ns + 10**10, DEBRIS, DEBRIS, rules, control)
    for mission in (armed, flying, closing, abort(closing, "why")):
        message = mission_message(mission, 7, True)
        assert mission_from(message) == mission
        assert (nanoseconds(message.header.stamp), message.confirmed, message.header.frame_id) == (7, True, "launch")
    assert mission_message(flying, 0, True, "not confirmed by MU 3").reason == "not confirmed by MU 3"


def test_stamps_are_exact():
    for stamp_ns in (0, 1, 999_999_999, 1_000_000_000, 2_147_483_647_999_999_999):
        assert nanoseconds(time_message(stamp_ns)) == stamp_ns
