from tethernet_bringup.pulse import Pulse


class Node:
    """Answers at once, or not at all."""

    def __init__(self):
        self.answers = self.reachable = True
        self.asked = 0

    def ask(self):
        if not self.reachable:
            return None
        self.asked += 1
        return lambda: "here" if self.answers else None


class Watch:
    """A pulse with a clock in hand."""

    def __init__(self, **nodes):
        self.now = 100.0
        self.pulse = Pulse({name: node.ask for name, node in nodes.items()}, 10.0, lambda: self.now)

    def look(self, duration_s, step_s=0.1):
        found = []
        for _ in range(round(duration_s / step_s)):
            self.now += step_s
            found += self.pulse.update()
        return found


def test_nodes_that_answer_are_asked_once_a_second_and_never_hang():
    planner = Node()
    watch = Watch(planner=planner)
    assert watch.look(60.0) == []
    assert 50 <= planner.asked <= 61


def test_a_node_that_stops_answering_is_found_within_its_patience_and_named_once():
    planner, sim = Node(), Node()
    watch = Watch(planner=planner, sim=sim)
    watch.look(5.0)
    planner.answers = False
    assert watch.look(9.0) == []
    assert watch.look(30.0) == ["planner"]
    assert watch.pulse.hung == {"planner"}
    planner.answers = True
    watch.look(1.0)
    assert watch.pulse.hung == set()


def test_a_node_that_cannot_even_be_asked_hangs_too():
    sim = Node()
    sim.reachable = False
    assert Watch(sim=sim).look(12.0) == ["sim"]


def test_where_the_watch_itself_stood_still_nobody_hangs():
    planner = Node()
    watch = Watch(planner=planner)
    watch.look(1.0)
    planner.answers = False
    watch.now += 60.0  # the whole machine slept
    assert watch.pulse.update() == []
    planner.answers = True
    assert watch.look(30.0) == []


def test_nothing_is_expected_of_a_node_that_has_ended():
    controller = Node()
    watch = Watch(mu3_controller=controller)
    controller.answers = False
    watch.pulse.forget("mu3_controller")
    assert watch.look(60.0) == []
