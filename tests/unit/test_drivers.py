"""What is heard of drivers before launch, and what keeps their MUs on the ground."""

import pytest

from tests.unit.test_control_driver_contract import CONTROL, clocked
from tethernet_bringup.mission.drivers import DriverDesk, DriverFaultError, DriverWatch


class Watch:
    """A watch on MU 3 with a clock in hand."""

    def __init__(self, waiting=False):
        self.now = 0.0
        self.drivers = DriverWatch([3], CONTROL, waiting, lambda: self.now)

    def hear(self, samples):
        for sample in samples:
            self.now += CONTROL.control_period_s
            self.drivers.saw(3, sample)
            self.drivers.obstacles()


def test_a_driver_of_which_nothing_comes_is_silent_whatever_the_graph_says():
    watch = Watch()
    assert watch.drivers.silent == [3]
    assert watch.drivers.obstacles() == {}


def test_a_good_driver_flies_once_it_has_been_heard_for_two_seconds():
    watch = Watch()
    watch.hear(clocked(0.0)[:30])
    assert watch.drivers.silent == []
    assert watch.drivers.obstacles() == {3: ""}
    watch.hear(clocked(0.0)[30:40])
    assert watch.drivers.obstacles() == {}


def test_a_driver_on_a_clock_that_waits_needs_one_sample():
    watch = Watch(waiting=True)
    watch.hear(clocked(0.0)[:1])
    assert watch.drivers.obstacles() == {}


def test_a_driver_that_puts_itself_right_is_forgiven():
    watch = Watch()
    watch.hear(clocked(0.0, frame="map")[:20])
    assert "seen 'map'" in watch.drivers.obstacles()[3]
    assert 0.8 < watch.drivers.bad_for_s(3) < 1.2
    watch.hear(clocked(0.0)[20:80])
    assert watch.drivers.obstacles() == {}
    assert watch.drivers.bad_for_s(3) == 0.0


def test_a_clock_that_is_off_keeps_an_mu_on_the_ground():
    watch = Watch()
    watch.hear(clocked(0.2)[:60])
    assert "clock within 50 ms: seen 0.198 s ahead" in watch.drivers.obstacles()[3]


def test_a_driver_that_falls_silent_in_flight_is_named_once_and_again_when_it_is_heard():
    watch = Watch()
    heard = clocked(0.0)
    watch.hear(heard[:40])
    newest = heard[39].stamp_ns
    assert watch.drivers.changes(newest + CONTROL.held_ns) == []
    assert watch.drivers.changes(newest + CONTROL.held_ns + 1) == [(3, True)]
    assert watch.drivers.changes(newest + 3 * CONTROL.held_ns) == []
    watch.hear(heard[60:61])
    assert watch.drivers.changes(heard[60].stamp_ns) == [(3, False)]


def desk(watch, heard=True, published=True):
    return DriverDesk(watch.drivers, lambda _: heard, lambda _: published, 2.0)


def test_what_is_wrong_is_said_once_and_ends_the_waiting_when_it_lasts():
    watch = Watch()
    told = desk(watch)
    watch.hear(clocked(0.0, frame="map")[:20])
    assert told.update() == ["MU 3 cannot fly yet: header.frame_id is 'launch': seen 'map'"]
    assert told.waiting == [3]
    assert told.update() == []
    watch.hear(clocked(0.0, frame="map")[20:50])
    with pytest.raises(DriverFaultError, match="MU 3 breaks the driver contract: header"):
        told.update()


def test_no_mission_is_launched_before_the_controller_has_taken_odometry():
    watch = Watch()
    watch.hear(clocked(0.0))
    assert desk(watch).update() == []
    deaf = desk(watch, heard=False)
    deaf.update()
    assert deaf.waiting == [3]
    assert "the controllers of MU 3 take nothing" in deaf.problem(60.0, 0, simulated=True)
    heard = desk(watch)
    heard.update()
    assert heard.waiting == []


def test_a_driver_that_is_missing_is_told_from_one_that_says_nothing():
    watch = Watch()
    assert "no driver publishes /mu3/odom after 9 s" in desk(watch, published=False).problem(9.0, 5, simulated=False)
    silent = desk(watch).problem(9.0, 5, simulated=True)
    assert silent == (
        "/mu3/odom: somebody publishes it, and not one message has come after 9 s; "
        "in a simulated mission a driver follows /clock"
    )
