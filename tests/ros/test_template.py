"""Messages that are written over in place, against what the middleware makes of their bytes."""

import dataclasses

import numpy as np
import pytest
from geometry_msgs.msg import Point, TransformStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from tests import rviz_rules
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters
from tethernet_core.system import load_system
from tethernet_msgs.msg import NetState
from tethernet_ros.template import Template
from tethernet_sim.ros.markers import Markers, NetPoints
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.world import World

pytestmark = pytest.mark.ros

STAMP_NS = 12_345_678_901


def decoded(template):
    return deserialize_message(template.bytes(), template.kind)


def stamp_of(message):
    return message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec


@pytest.mark.parametrize("child", ["", "a", "mu12", "a name of odd length"])
def test_numbers_go_where_they_belong_whatever_the_texts_before_them(child):
    message = Odometry(child_frame_id=child)
    message.header.frame_id = "launch"
    message.pose.covariance[7] = 3.0
    template = Template(message)
    template.stamp(STAMP_NS)
    template.doubles("pose.pose.position.x", 7)[:] = range(1, 8)
    template.doubles("twist.twist.linear.x", 6)[:] = range(11, 17)
    template.doubles("twist.covariance[0]", 36)[35] = -4.0
    found = decoded(template)
    assert (stamp_of(found), found.header.frame_id, found.child_frame_id) == (STAMP_NS, "launch", child)
    place, turn = found.pose.pose.position, found.pose.pose.orientation
    assert (place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w) == (1, 2, 3, 4, 5, 6, 7)
    assert (found.twist.twist.linear.x, found.twist.twist.angular.z) == (11.0, 16.0)
    assert (found.pose.covariance[7], found.twist.covariance[35]) == (3.0, -4.0)


@pytest.mark.parametrize("pairs", [0, 1, 7, 8])
@pytest.mark.parametrize("units", [0, 3])
def test_arrays_of_all_kinds_and_what_follows_them(units, pairs):
    message = NetState(knot_positions=[0.0] * 15, knot_velocities=[0.0] * 15, locked=[False] * pairs)
    message.mu_positions = message.mu_velocities = [0.0] * 3 * units
    template = Template(message)
    template.floats("knot_positions[0]", 15)[:] = np.arange(15)
    template.floats("mu_velocities[0]", 3 * units)[:] = 0.5
    template.flags("locked[0]", pairs)[1::2] = True
    template.doubles("tether_length", 2)[:] = (2.5, -1.0)
    found = decoded(template)
    assert list(found.knot_positions) == list(range(15))
    assert list(found.mu_velocities) == [0.5] * 3 * units
    assert list(found.locked) == [index % 2 == 1 for index in range(pairs)]
    assert (found.tether_length, found.tether_tension) == (2.5, -1.0)


def test_every_stamp_of_an_array_of_messages_is_written():
    message = TFMessage(transforms=[TransformStamped(child_frame_id="x" * n) for n in range(5)])
    template = Template(message)
    template.stamp(STAMP_NS)
    template.doubles("transforms[3].transform.rotation.x", 4)[:] = (0.5, 0.5, 0.5, -0.5)
    found = decoded(template)
    assert [stamp_of(transform) for transform in found.transforms] == [STAMP_NS] * 5
    assert found.transforms[3].transform.rotation.w == -0.5
    assert found.transforms[4].transform.rotation.w == 1.0


def test_unchanged_it_is_the_message_itself():
    marker = Marker(ns="a", points=[Point(x=1.0)] * 3, text="text")
    message = MarkerArray(markers=[marker, Marker(), marker])
    assert decoded(Template(message)) == deserialize_message(serialize_message(message), MarkerArray)


def test_a_number_that_is_not_finite_is_noticed():
    template = Template(Odometry())
    place = template.doubles("pose.pose.position.x", 3)
    assert template.finite
    for bad in (np.nan, np.inf, -np.inf):
        place[1] = bad
        assert not template.finite
    place[:] = (1e308, 1e308, 0.0)
    assert template.finite, "their sum is not finite, they are"


@pytest.mark.parametrize("system", ["zenit_4mu", "zenit_8mu_winch", "hexagonal_6mu", "envisat_8mu", "passive_5m"])
def test_rviz_has_nothing_to_say_of_the_markers_of_any_system(system):
    described = load_system(system)
    world = World(
        described,
        np.array([[0.0, 0.0, -50.0]]),
        np.array([[0.5, -0.5, 0.5, 0.5]]),
        np.zeros((1, 3)),
        dataclasses.replace(load(PhysicsParameters), time_step_s=2.5e-5),
        load(ControlParameters),
    )
    message = decoded(Markers(described, 5.0).fill(STAMP_NS, world))
    assert rviz_rules.array_warnings(message.markers) == []
    cloud = decoded(NetPoints(described).fill(STAMP_NS, world))
    assert stamp_of(cloud) == STAMP_NS
    assert len(cloud.data) == cloud.row_step == 12 * described.net.node_count
    places = np.frombuffer(bytes(cloud.data), "<f4").reshape(-1, 3)
    assert np.array_equal(places, world.knots_as_published(0))


def test_what_rviz_warns_of_is_found():
    def warnings(**changed):
        marker = Marker(ns="a", type=Marker.LINE_LIST, points=[Point(), Point()])
        marker.header.frame_id, marker.scale.x, marker.color.a, marker.lifetime.sec = "launch", 0.1, 1.0, 1
        for place, value in changed.items():
            *path, name = place.split("__")
            target = marker
            for part in path:
                target = getattr(target, part)
            setattr(target, name, value)
        return rviz_rules.array_warnings([marker])

    assert warnings() == []
    for changed in (
        {"scale__y": 0.1}, {"scale__x": 0.0}, {"color__a": 0.0}, {"pose__orientation__w": 0.9}, {"lifetime__sec": 0},
        {"points": [Point()]}, {"points": []}, {"header__frame_id": ""}, {"text": "a"}, {"ns": ""},
        {"pose__position__x": np.nan}, {"type": Marker.CUBE},
    ):  # fmt: skip
        assert warnings(**changed), changed
    assert "there 2 times" in rviz_rules.array_warnings([Marker(ns="a"), Marker(ns="a")])[0]
    for wrong in ([("a", "b"), ("c", "b")], [("a", "b"), ("b", "a")]):
        with pytest.raises(ValueError, match="frame"):
            rviz_rules.tree(wrong)


@pytest.mark.parametrize("system", ["zenit_4mu", "envisat_8mu", "passive_5m"])
def test_markers_draw_every_thread_and_the_whole_debris(system):
    described = load_system(system)
    markers = {marker.ns: marker for marker in decoded(Markers(described, 5.0)._template).markers}
    assert len(markers["net"].points) == 2 * described.net.thread_count
    _, faces = described.debris.shape.triangles()
    assert (markers["debris"].type, len(markers["debris"].points)) == (Marker.TRIANGLE_LIST, 3 * len(faces))
    assert ("units" in markers, "masses" in markers) == (bool(described.units), bool(described.net.point_masses))
    assert ("tether" in markers) == (described.tether.stiffness_n_m > 0.0)
    if described.units:
        assert len(markers["units"].points) == described.unit_count
        scale, box = markers["units"].scale, described.units[0].box_m
        assert scale.z / scale.x == pytest.approx(box[2] / box[0])
