"""No message ends a node, and no number that is not finite leaves one: nodes in this process, fed with random bytes."""

import ast
import copy
import functools
import json
import math
import random
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.publisher import Publisher
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger

from tests.faults import hostile
from tests.ros.sound import mu_status, net_state, odometry
from tethernet_bringup.mission import outcome, outcome_text
from tethernet_bringup.mission.live_display import flight_line
from tethernet_bringup.mission.monitor_node import Monitor
from tethernet_bringup.mission.outcome import FlightRecord
from tethernet_control.controller_node import ControllerNode
from tethernet_core.mission import Mission, arm, launch
from tethernet_core.system import load_system
from tethernet_msgs.msg import CaptureAssessment, SimStatus
from tethernet_msgs.srv import PlanAimingPoints
from tethernet_planner.assessor_node import AssessorNode
from tethernet_planner.planner_node import PlannerNode
from tethernet_ros import checks, topics
from tethernet_ros.checks import Check
from tethernet_ros.connections import read_connections, serve_connections
from tethernet_ros.conversions import mission_message, set_stamp
from tethernet_ros.door import Door
from tethernet_ros.well_formed import MessageError
from tethernet_sim.fly import fly
from tethernet_sim.scenario import Scenario

ROOT = Path(__file__).parents[2]
PERIOD = 50_000_000
DEBRIS = (0.1, -0.2, -50.0)
MUS = range(1, 9)
MANY = 1500


def numbers(message) -> Iterator[float]:
    """All floating-point numbers in a message."""
    for name in hostile.fields(message):
        value = getattr(message, name)
        for part in value if hasattr(value, "__len__") and not isinstance(value, str | bytes) else [value]:
            if hasattr(part, "get_fields_and_field_types"):
                yield from numbers(part)
            elif not isinstance(part, str | bytes):
                yield float(part)


class Fed:
    """A node whose callbacks are called by hand; remembers what it publishes."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, make: Callable, parameters: tuple[str, ...]):
        self.takers: dict[str, tuple[Check, Callable[[bytes], None]]] = {}
        self.published: list[tuple[str, object]] = []
        create, publish = rclpy.node.Node.create_subscription, Publisher.publish

        def remember(door, listen, check, topic, *rest):
            self.newest = check
            return listen(door, check, topic, *rest)

        def create_subscription(node, kind, topic, take, *rest, **options):
            if options.get("raw"):
                self.takers[topic] = (self.newest, take)
            return create(node, kind, topic, take, *rest, **options)

        def record(publisher, message):
            read = deserialize_message(message, publisher.msg_type) if isinstance(message, bytes) else message
            assert all(map(math.isfinite, numbers(read))), f"{publisher.topic_name}: {read}"
            self.published.append((publisher.topic_name, copy.deepcopy(read)))
            publish(publisher, message)

        for listen in (Door.subscribe, Door.poll):
            monkeypatch.setattr(Door, listen.__name__, functools.partialmethod(remember, listen))
        monkeypatch.setattr(rclpy.node.Node, "create_subscription", create_subscription)
        monkeypatch.setattr(Publisher, "publish", record)
        arguments = [word for parameter in parameters for word in ("-p", parameter)]
        self.node = make(["--ros-args", *arguments] if arguments else [])

    def feed(self, topic: str, message) -> None:
        """One message or its bytes."""
        self.takers[topic][1](message if isinstance(message, bytes) else serialize_message(message))

    def request(self, name: str, request):
        """One request; returns the response."""
        service = next(s for s in self.node.services if s.srv_name == name)
        return service.callback(request, service.srv_type.Response())

    def heard(self, topic: str) -> list:
        """What was published on a topic."""
        return [message for name, message in self.published if name == topic]

    def ill(self, generator: random.Random, honest: dict[str, object]) -> tuple[str, bytes]:
        """A topic and bytes that seldom keep its contract."""
        topic = generator.choice(sorted(self.takers))
        kind = self.takers[topic][0].kind
        example = honest.get(topic)
        if example is None or generator.random() < 0.2:
            message = hostile.fill(kind(), generator)
        else:
            message = hostile.mutate(example, generator)
        data = serialize_message(message)
        how = generator.random()
        if how < 0.1:
            return topic, data[: generator.randrange(len(data))]
        if how < 0.2:
            at = generator.randrange(len(data))
            return topic, data[:at] + generator.randbytes(generator.randrange(1, 9)) + data[at + 1 :]
        return topic, serialize_message(String(data="x" * 100)) if how < 0.22 else data

    def malformed(self, generator: random.Random, honest: dict[str, object]) -> tuple[str, bytes]:
        """Likewise, and certain to break the contract."""
        while True:
            topic, data = self.ill(generator, honest)
            check = self.takers[topic][0]
            try:
                if len(data) <= check.largest_bytes:
                    check.read(data)
            except MessageError:
                return topic, data


def started(make_node: Callable) -> Callable:
    """Makes a node as its process does."""

    def make(ros_arguments: list[str]):
        rclpy.init(args=ros_arguments)
        node = make_node()
        serve_connections(node)
        return node

    return make


def simulator():
    from tethernet_sim.ros.sim_node import SimNode  # compiles, or loads what was compiled

    node = SimNode()
    node.make_world()
    return node


NODES: dict[str, tuple[Callable, tuple[str, ...]]] = {
    "controller": (started(lambda: ControllerNode("mu3_controller")), ("mu:=3", "plan_timeout_s:=0.1")),
    "planner": (started(PlannerNode), ("policy:=nominal",)),
    "planner without simulator": (started(PlannerNode), ("policy:=nominal", "simulated:=false")),
    "assessor": (started(AssessorNode), ()),
    "assessor without simulator": (started(AssessorNode), ("simulated:=false",)),
    "sim": (started(simulator), ("pace:=lockstep", "external_mus:='3'", "markers_every:=1")),
}


@pytest.fixture
def fed(monkeypatch, domain_id) -> Iterator[Callable]:
    nodes = []

    def make(name: str) -> Fed:
        close()
        nodes.append(Fed(monkeypatch, *NODES[name]))
        return nodes[-1]

    def close() -> None:
        while nodes:
            nodes.pop().node.destroy_node()
        rclpy.try_shutdown()
        monkeypatch.undo()

    yield make
    close()


def honest_messages(phase_tick: int = 3) -> dict[str, object]:
    """A message of each topic that keeps its contract, stamped at a control tick."""
    stamp_ns = phase_tick * PERIOD
    flying = launch(arm(Mission(8), DEBRIS, "nominal"), 0)
    assessment = CaptureAssessment(source="net_state", max_locked_pairs=8, required_locked_pairs=6)
    status = SimStatus(
        **{f"{name}_commands": [0] * 8 for name in ("late", "rejected", "clipped", "zeroed")}, applied_fuel=[0.0] * 8
    )
    beat = Header(frame_id=topics.FRAME)
    thrust = WrenchStamped()
    thrust.header.frame_id = assessment.header.frame_id = status.header.frame_id = topics.FRAME
    for stamp in (beat.stamp, thrust.header.stamp, assessment.header.stamp, status.header.stamp):
        set_stamp(stamp, stamp_ns)
    found = {
        topics.MISSION_STATE: mission_message(flying, 0, True),
        topics.PLANNER_HEARTBEAT: beat,
        topics.DEBRIS_ODOMETRY: odometry("debris", stamp_ns, DEBRIS),
        topics.NET_STATE: net_state(load_system("zenit_8mu"), stamp_ns),
        topics.SIM_STATUS: status,
        topics.CAPTURE_ASSESSMENT: assessment,
    }
    for mu in MUS:
        found[topics.mu_odometry(mu)] = odometry(topics.mu_frame(mu), stamp_ns, (float(mu), 0.0, -2.0))
        found[topics.mu_thrust(mu)] = thrust
        found[topics.mu_status(mu)] = mu_status(mu, 0)
    return found


@pytest.mark.parametrize("name", NODES)
def test_no_message_ends_a_node_or_makes_it_publish_what_is_not_finite(fed, name):
    f, generator = fed(name), random.Random(name)
    asked = [s for s in f.node.services if s.srv_type in (Trigger, PlanAimingPoints)]
    assert f.takers
    for count in range(MANY):
        topic, data = f.ill(generator, honest_messages(count // 10))
        f.feed(topic, data)
        if count % 20 == 0:
            service = generator.choice(asked)
            request = hostile.fill(service.srv_type.Request(), generator)
            response = service.callback(request, service.srv_type.Response())
            assert isinstance(response, service.srv_type.Response)
            assert all(map(math.isfinite, numbers(response)))
            assert response.message.isprintable()

    assert f.node._door.dropped > MANY // 3


def fly_controller(f: Fed, disturb: Callable[[], None]) -> list:
    flying = launch(arm(Mission(8), DEBRIS, "nominal"), 0)
    f.feed(topics.MISSION_STATE, mission_message(flying, 0, True))
    time.sleep(0.11)
    f.node._on_wall_period()  # nobody plans: the nominal points
    for tick in range(20):
        disturb()
        f.feed(topics.mu_odometry(3), odometry("mu3", tick * PERIOD, (0.0, 0.0, -1.5)))
    return f.heard(topics.mu_thrust(3))


def fly_planner(f: Fed, disturb: Callable[[], None]) -> list:
    f.feed(topics.DEBRIS_ODOMETRY, odometry("debris", 0, DEBRIS))
    assert f.request(topics.START, Trigger.Request()).success
    for sequence in (1, 2):
        for mu in MUS:
            disturb()
            f.feed(topics.mu_status(mu), mu_status(mu, sequence))
    for tick in range(20):
        f.feed(topics.NET_STATE, net_state(load_system("zenit_8mu"), tick * PERIOD))
        for mu in MUS:
            f.feed(topics.mu_odometry(mu), odometry(topics.mu_frame(mu), tick * PERIOD, (float(mu), 0.0, -2.0)))
        disturb()
        f.feed(topics.DEBRIS_ODOMETRY, odometry("debris", tick * PERIOD, DEBRIS))
    return f.heard(topics.PLANNER_HEARTBEAT)


def fly_assessor(f: Fed, disturb: Callable[[], None]) -> list:
    flying = launch(arm(Mission(8), DEBRIS, "nominal"), 0)
    f.feed(topics.MISSION_STATE, mission_message(flying, 0, True))
    for tick in range(40):
        disturb()
        f.feed(topics.DEBRIS_ODOMETRY, odometry("debris", tick * PERIOD, DEBRIS))
        disturb()
        f.feed(topics.NET_STATE, net_state(load_system("zenit_8mu"), tick * PERIOD))
    return f.heard(topics.CAPTURE_ASSESSMENT)


def fly_sim(f: Fed, disturb: Callable[[], None]) -> list:
    first_ns = f.node.stamp_ns
    flying = launch(arm(Mission(8), DEBRIS, "nominal"), first_ns)
    f.feed(topics.MISSION_STATE, mission_message(flying, first_ns, True))
    for tick in range(10):
        honest = honest_messages(first_ns // PERIOD + tick)
        for topic in (topics.PLANNER_HEARTBEAT, topics.mu_odometry(3), *map(topics.mu_thrust, MUS)):
            disturb()
            f.feed(topic, honest[topic])
    return f.heard(topics.NET_STATE)


@pytest.mark.parametrize(
    ("name", "flight", "expected"),
    [
        ("controller", fly_controller, 20),
        ("planner", fly_planner, 20),
        ("assessor", fly_assessor, 4),
        ("sim", fly_sim, 11),
    ],
)
def test_malformed_messages_among_good_ones_change_not_a_bit(fed, name, flight, expected):
    alone = flight(fed(name), lambda: None)
    assert len(alone) == expected
    f, generator = fed(name), random.Random(name)

    def disturb() -> None:
        for _ in range(3):
            f.feed(*f.malformed(generator, honest_messages(generator.randrange(50))))

    assert flight(f, disturb) == alone
    assert f.node._door.dropped >= 3 * expected


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e30])
def test_a_simulation_that_diverges_says_the_same_over_ros_as_in_one_call(fed, value):
    broken_tick = 4
    f = fed("sim")
    first_ns = f.node.stamp_ns
    flying = launch(arm(Mission(8), DEBRIS, "nominal"), first_ns)
    f.feed(topics.MISSION_STATE, mission_message(flying, first_ns, True))
    for tick in range(broken_tick + 3):
        honest = honest_messages(first_ns // PERIOD + tick)
        if tick == broken_tick - 1:
            f.node.world.state.knot_vel[0, 0, 77] = value
        for topic in (topics.PLANNER_HEARTBEAT, topics.mu_odometry(3), *map(topics.mu_thrust, MUS)):
            f.feed(topic, honest[topic])
    status = f.heard(topics.SIM_STATUS)[-1]

    def break_down(stamp_ns, world, _):
        if stamp_ns == broken_tick * PERIOD:
            world.state.knot_vel[0, 0, 77] = value

    flown = fly(Scenario(debris_position=DEBRIS), observer=break_down)
    assert (status.fault, status.finished) == (flown.error, True)
    assert status.fault == "the simulation diverged 0.20 s after launch"
    assert len(f.heard(topics.NET_STATE)) == broken_tick  # ticks 0 to 3; none of the broken ones


def test_no_message_ends_the_command_and_its_outcome_is_written(monkeypatch, domain_id, tmp_path):
    record = FlightRecord(system=load_system("zenit_8mu"), seed=1, policy="nominal")
    f = Fed(monkeypatch, lambda _: Monitor(record), ())
    generator = random.Random("command")
    try:
        for count in range(MANY):
            f.feed(*f.ill(generator, honest_messages(count // 10)))
            if count % 10 == 0:
                content = outcome.build(record)
                text = json.dumps(content, allow_nan=False)
                lines = [*outcome_text.describe(record, content, tmp_path, ""), flight_line(record)]
                assert all(line.isprintable() for line in lines), lines
                assert len(text) < 20_000
        assert all(text.isprintable() and len(text) < 600 for text in f.node.dropped.values())
        assert sum(drops.count for drops in f.node._door.incoming.values()) > MANY // 3
    finally:
        f.node.close(0)


@pytest.mark.parametrize("seed", range(300))
def test_answers_of_services_are_checked_too(seed):
    generator = random.Random(seed)
    for check, kind in (
        (checks.plan_answer(8), PlanAimingPoints.Response),
        (checks.trigger_answer, Trigger.Response),
        (read_connections, Trigger.Response),
    ):
        response = hostile.fill(kind(), generator)
        try:
            check(response)
        except MessageError as error:
            assert str(error)


@pytest.mark.parametrize(
    "text",
    [
        "", "null", "[]", "{}", '{"pid": 1}', "[" * 90_000,
        '{"pid": "x", "subscribers": {}, "publishers": {}}',
        '{"pid": 1, "subscribers": {"a": 1e999}, "publishers": {}}',
        '{"pid": 1, "subscribers": [], "publishers": 3}',
        '{"pid": ' + "9" * 10_000 + ', "subscribers": {}, "publishers": {}}',
        '"' + "x" * 1_000_000 + '"',
    ],
)  # fmt: skip
def test_an_answer_of_a_connections_service_that_is_none_is_refused(text):
    with pytest.raises(MessageError, match="no answer of a connections service") as error:
        read_connections(Trigger.Response(message=text))
    assert len(str(error.value)) < 200


def test_every_node_goes_through_its_door():
    allowed = {
        "any_quality.py": {"create_subscription"},  # makes the door's
        "door.py": {"create_publisher", "create_service", "create_client"},
        "recorder_node.py": {"create_subscription"},  # writes bytes as they come and decodes nothing
        "polled.py": {"create_subscription"},  # checks what it takes as the door does
        "check_driver.py": {"create_publisher"},  # looks at what breaks the contract
    }
    found = []
    for path in ROOT.glob("ros2_ws/src/tethernet_*/tethernet_*/**/*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and node.attr.startswith("create_"):
                makes = node.attr in set.union(*allowed.values())
                if makes and node.attr not in allowed.get(path.name, ()):
                    found.append(f"{path.name}:{node.lineno} {node.attr}")
    assert found == []
