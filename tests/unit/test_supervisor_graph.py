import pytest

from tethernet_bringup.mission.connection_check import ConnectionCheck
from tethernet_bringup.mission.graph import (
    Endpoint,
    GraphCheck,
    Publisher,
    UnexpectedPublisherWatch,
    exclusive_topics,
    expected,
)
from tethernet_core.system import load_system
from tethernet_ros.connections import Connections


class Graph:
    """A graph in which every expected endpoint is there."""

    def __init__(self, endpoints):
        self.endpoints = list(endpoints)

    def publishers(self, topic):
        return [e.node for e in self.endpoints if e.topic == topic and e.publishes]

    def subscribers(self, topic):
        return [e.node for e in self.endpoints if e.topic == topic and not e.publishes]

    def check(self, wanted):
        return GraphCheck(wanted, self.publishers, self.subscribers)


ZENIT_4, ZENIT_8 = load_system("zenit_4mu"), load_system("zenit_8mu")


def test_a_mission_needs_every_controller_heard_by_simulator_planner_and_recorder():
    endpoints = expected(ZENIT_8, (), simulated=True)
    assert len(endpoints) == len(set(endpoints))
    for mu in range(1, 9):
        assert Endpoint(f"/mu{mu}/odom", "sim", True) in endpoints
        assert Endpoint(f"/mu{mu}/thrust", "sim", False) in endpoints
        assert Endpoint(f"/mu{mu}/thrust", "recorder", False) in endpoints
        assert Endpoint(f"/mu{mu}/status", "planner", False) in endpoints
        assert Endpoint(f"/mu{mu}/odom", "planner", False) in endpoints
    assert Endpoint("/mu1/odom", "planner", False) not in expected(ZENIT_4, (), simulated=True), "winches need no plan"
    assert Endpoint("/mu1/odom", "planner", False) in expected(ZENIT_4, (1, 2, 3, 4), simulated=False)


def test_the_odometry_of_an_external_mu_is_somebody_elses():
    endpoints = expected(ZENIT_4, (3,), simulated=True)
    assert Endpoint("/mu3/odom", "sim", True) not in endpoints
    assert Endpoint("/mu3/odom", "sim", False) in endpoints
    assert Endpoint("/mu3/odom", "recorder", False) in endpoints


def test_without_a_simulator_nobody_is_expected_to_simulate():
    endpoints = expected(ZENIT_8, range(1, 9), simulated=False)
    assert not any(endpoint.node == "sim" for endpoint in endpoints)
    assert not any(endpoint.topic == "/net/state" for endpoint in endpoints)


def test_what_is_missing_is_named():
    wanted = expected(ZENIT_4, (), simulated=True)
    gone = Endpoint("/mu3/odom", "mu3_controller", False)
    graph = Graph(endpoint for endpoint in wanted if endpoint != gone)
    check = graph.check(wanted)
    assert not check.update()
    assert check.describe() == "mu3_controller does not subscribe to /mu3/odom"
    assert check.waiting_for == "mu3_controller"
    graph.endpoints.append(gone)
    assert check.update()
    assert check.describe() == ""


def test_a_long_list_is_cut_short():
    check = Graph([]).check(expected(ZENIT_8, (), simulated=True))
    assert not check.update()
    assert "in all" in check.describe()
    assert len(check.describe()) < 500


class Publishers:
    """Who publishes what, by topic."""

    def __init__(self, **topics):
        self.topics = topics

    def watch(self):
        return UnexpectedPublisherWatch(self.topics, lambda topic: len(self.topics[topic]), self.topics.__getitem__)


def test_a_second_publisher_is_a_stranger_whatever_its_name_and_named_once():
    graph = Publishers(thrust=[Publisher("mu3_controller", b"1")], state=[Publisher("planner", b"2")])
    watch = graph.watch()
    assert watch.crowded == {}
    assert watch.update() == []
    graph.topics["thrust"].append(Publisher("mu3_controller", b"3"))
    assert watch.update() == [("mu3_controller", "thrust")]
    assert watch.update() == []
    graph.topics["thrust"].append(Publisher("_ros2cli_77", b"4"))
    assert watch.update() == [("_ros2cli_77", "thrust")]


def test_a_stranger_is_found_in_the_place_of_a_node_that_has_gone():
    graph = Publishers(thrust=[Publisher("mu3_controller", b"1")])
    watch = graph.watch()
    graph.topics["thrust"] = []
    assert watch.update() == []
    graph.topics["thrust"] = [Publisher("rogue", b"9")]
    assert watch.update() == [("rogue", "thrust")]


def test_two_publishers_from_the_start_are_a_crowd():
    graph = Publishers(state=[Publisher("planner", b"2"), Publisher("other", b"3")])
    assert graph.watch().crowded == {"state": ["other", "planner"]}


def test_what_only_the_mission_publishes_leaves_out_drivers_and_what_is_everybodys():
    with_simulator = exclusive_topics(ZENIT_8, (3,), simulated=True)
    assert "/mu3/odom" not in with_simulator
    assert {"/mu4/odom", "/mu3/thrust", "/clock", "/net/state", "/debris/odom", "/mission/state"} <= set(with_simulator)
    without = exclusive_topics(ZENIT_8, range(1, 9), simulated=False)
    assert not {"/tf", "/diagnostics", "/debris/odom", "/clock", "/mu1/odom"} & set(without)
    assert {"/mu1/thrust", "/planner/heartbeat"} <= set(without)


def test_the_audience_of_a_topic_is_named():
    listeners = Graph([]).check(expected(ZENIT_8, (), simulated=True)).listeners()
    assert listeners["sim"]["/mu3/odom"] == {"mu3_controller", "planner", "recorder"}
    assert listeners["mu3_controller"]["/mu3/thrust"] == {"sim", "recorder"}
    assert len(listeners["planner"]["/mission/state"]) == 8 + 4
    assert "recorder" not in listeners


class Node:
    """Answers for its connections at once."""

    def __init__(self, subscribers):
        self.told = Connections(1, {"odom": subscribers}, {})

    def ready(self):
        return True

    def ask(self, _request, _check, callback):
        callback(self.told)


def check_of(node, seen, clock=lambda: 0.0, onlookers=()):
    wanted = {"sim": {"odom": {"controller", "recorder"}}}
    return ConnectionCheck(wanted, {"sim": node}, lambda _: seen, {"odom": onlookers}, clock)


@pytest.mark.parametrize(
    ("found", "seen", "connected"),
    [
        (2, 2, True),
        (1, 2, False),
        (3, 3, True),
        (2, 3, False),  # whoever else listens may be one of the two
    ],
)
def test_who_else_listens_does_not_stand_in_for_who_is_waited_for(found, seen, connected):
    assert check_of(Node(found), seen).update() == connected


def test_a_strangers_subscription_that_is_never_found_does_not_keep_a_mission_on_the_ground():
    now = [0.0]
    check = check_of(Node(2), 3, lambda: now[0])
    assert not check.update()
    now[0] = 6.0
    assert check.update()


def test_an_onlooker_is_waited_for_a_moment():
    now = [0.0]
    node = Node(2)
    check = check_of(node, 2, lambda: now[0], ["viewer"])
    assert not check.update()
    node.told = Node(3).told
    assert check.update()
    check = check_of(Node(2), 2, lambda: now[0], ["viewer"])
    assert not check.update()
    now[0] = 6.0
    assert check.update(), "nobody needs it"


def test_who_has_not_answered_is_told_from_who_lacks_somebody():
    class Silent(Node):
        def ask(self, _request, _check, _callback):
            pass

    for node, told in ((Node(1), "sim lacks subscribers of odom"), (Silent(2), "sim has not answered")):
        check = check_of(node, 2)
        assert not check.update()
        assert check.describe() == told


class Deaf(Node):
    """Whose first answer is lost."""

    asked = 0

    def ask(self, _request, _check, callback):
        self.asked += 1
        if self.asked > 1:
            callback(self.told)


def test_an_answer_that_is_lost_is_asked_for_again():
    now = [0.0]
    node = Deaf(2)
    check = check_of(node, 2, lambda: now[0])
    assert not check.update()
    assert not check.update()
    assert node.asked == 1, "not at every look"
    now[0] = 1.1
    assert check.update()
