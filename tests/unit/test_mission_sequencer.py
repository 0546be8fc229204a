"""The mission's handshake with its controllers, with a clock that the test moves."""

import math

import pytest

from tethernet_core.mission import Phase
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.system import load_system
from tethernet_planner.sequencer import MissionSequencer

CONTROL, RULES = load(ControlParameters), load(MissionParameters)
PERIOD = CONTROL.period_ns
DEBRIS, FAR = (0.0, 0.0, -50.0), (0.0, 0.0, -10.0)
UNKNOWN = (math.nan,) * 3


class Harness:
    """A sequencer with everything it says written down."""

    def __init__(self, mus=8, rules=RULES):
        self.now = 100.0
        self.said = []
        self.beats = []
        self.mus = range(1, mus + 1)
        system = load_system(f"zenit_{mus}mu")
        self.sequencer = MissionSequencer(system, rules, CONTROL, self.publish, self.beats.append, lambda: self.now)

    def publish(self, mission, stamp_ns, confirmed, reason):
        self.said.append((mission.phase, mission.sequence, confirmed, reason))

    def echo(self, *without):
        sequence = self.sequencer.mission.sequence
        for mu in self.mus:
            if mu not in without:
                self.sequencer.echoed(mu, sequence)

    def pass_time(self, seconds):
        self.now += seconds
        self.sequencer.poll()

    def tick(self, number, net=FAR, debris=DEBRIS):
        self.sequencer.measured(number * PERIOD, net, debris)

    def deployed(self):
        self.sequencer.start(DEBRIS, "nominal")
        self.echo()
        self.echo()
        self.said.clear()
        return self


def test_each_state_is_confirmed_when_all_have_echoed_it():
    h = Harness()
    h.sequencer.start(DEBRIS, "nominal")
    assert h.said == [(Phase.ARMED, 1, False, "")]
    h.echo(5)
    assert len(h.said) == 1
    h.sequencer.echoed(5, 0)  # an older state: not this one
    assert len(h.said) == 1
    h.sequencer.echoed(5, 1)
    assert h.said[1:] == [(Phase.ARMED, 1, True, ""), (Phase.DEPLOYING, 2, False, "")]
    h.echo()
    assert h.said[3:] == [(Phase.DEPLOYING, 2, True, "")]
    assert h.sequencer.mission.launch_ns == 0


def test_a_hold_test_follows_the_verdict_and_is_confirmed_as_every_change_is():
    rules = load(MissionParameters, {"hold_s": 2.0, "tow_n": 20.0, "release_docked": False, "regroup_period_s": 0.0})
    h = Harness(rules=rules).deployed()
    assert (h.sequencer.mission.hold_s, h.sequencer.mission.tow_n) == (2.0, 20.0)
    h.tick(480, DEBRIS)
    h.echo()
    end = 481 + round(RULES.capture_duration_s / CONTROL.control_period_s)
    h.tick(end)
    mission = h.sequencer.mission
    assert (mission.phase, mission.judged, mission.phase.over) == (Phase.HOLDING, True, False)
    assert (mission.hold_ns, mission.hold_end_ns) == ((end + 1) * PERIOD, (end + 41) * PERIOD)
    beats = len(h.beats)
    h.tick(end + 1)
    assert len(h.beats) == beats, "no beat before all have confirmed"
    h.echo()
    assert len(h.beats) == beats + 1
    h.tick(end + 40)
    assert h.sequencer.mission is mission
    h.tick(end + 41)
    assert h.sequencer.mission.phase == Phase.COMPLETE


def test_planning_gets_its_own_time_limit_on_top():
    h = Harness()
    h.sequencer.start(DEBRIS, "nominal")
    h.echo(2, 7)
    h.pass_time(CONTROL.plan_timeout_s + RULES.confirm_timeout_s - 0.01)
    assert h.sequencer.mission.phase == Phase.ARMED
    h.pass_time(0.02)
    assert h.said[1] == (Phase.ARMED, 1, True, "not confirmed by MU 2, MU 7")
    assert h.sequencer.mission.phase == Phase.DEPLOYING


def test_a_lost_controller_is_not_waited_for_again_until_it_answers():
    h = Harness()
    h.sequencer.start(DEBRIS, "nominal")
    h.echo(3)
    h.pass_time(10.0)
    h.echo(3)
    assert h.said[-1] == (Phase.DEPLOYING, 2, True, "not confirmed by MU 3")
    assert h.sequencer.lost == {3}
    h.sequencer.echoed(3, 2)  # it is back
    assert h.sequencer.lost == set()
    h.tick(480, net=DEBRIS)
    h.echo(3)
    assert not h.sequencer.confirmed
    h.sequencer.echoed(3, 3)
    assert h.said[-1] == (Phase.CLOSING, 3, True, "")


def test_with_all_controllers_lost_the_mission_goes_on():
    h = Harness()
    h.sequencer.start(DEBRIS, "nominal")
    h.pass_time(10.0)
    assert (h.sequencer.mission.phase, h.sequencer.confirmed) == (Phase.DEPLOYING, True)


def test_beats_at_once_when_nothing_changes():
    h = Harness().deployed()
    for tick in range(5):
        h.tick(tick)
    assert h.beats == [tick * PERIOD for tick in range(5)]
    assert h.said == []


def test_the_beat_of_a_change_waits_for_its_confirmation():
    h = Harness().deployed()
    h.tick(479)
    h.tick(480, net=DEBRIS)
    assert h.said == [(Phase.CLOSING, 3, False, "")]
    assert h.beats == [479 * PERIOD]
    h.echo()
    assert h.said[1:] == [(Phase.CLOSING, 3, True, "")]
    assert h.beats == [479 * PERIOD, 480 * PERIOD]


def test_in_real_time_ticks_come_while_a_change_is_unconfirmed():
    h = Harness().deployed()
    h.tick(480, net=DEBRIS)
    h.tick(481, net=DEBRIS)
    h.tick(482, net=DEBRIS)
    assert h.beats == []
    h.echo(1)
    h.pass_time(RULES.confirm_timeout_s + 0.01)
    assert h.beats == [482 * PERIOD]
    assert h.said[-1] == (Phase.CLOSING, 3, True, "not confirmed by MU 1")


def test_flies_to_the_end():
    h = Harness(mus=4).deployed()
    h.tick(480, net=DEBRIS)
    h.echo()
    h.tick(780, net=DEBRIS)
    assert h.sequencer.mission.phase == Phase.CLOSING
    h.tick(781, net=DEBRIS)
    h.echo()
    assert h.said[-1] == (Phase.COMPLETE, 4, True, "")
    h.tick(782, net=DEBRIS)
    assert h.beats[-1] == 782 * PERIOD


def test_gives_up_and_says_why():
    h = Harness().deployed()
    h.tick(800)
    h.echo(8)
    h.pass_time(1.0)
    phase, _, confirmed, reason = h.said[-1]
    assert (phase, confirmed) == (Phase.MISSED, True)
    assert reason.startswith("the net did not come")
    assert reason.endswith("not confirmed by MU 8")


def test_unknown_positions_do_not_trigger_and_do_not_stop_the_beat():
    h = Harness().deployed()
    h.tick(480, net=UNKNOWN)
    h.tick(481, net=DEBRIS, debris=UNKNOWN)
    assert h.sequencer.mission.phase == Phase.DEPLOYING
    assert h.beats == [480 * PERIOD, 481 * PERIOD]


def test_an_abort_overtakes_a_change_that_is_unconfirmed():
    h = Harness().deployed()
    h.tick(480, net=DEBRIS)
    assert h.sequencer.abort("asked for")
    h.echo()
    assert h.said[-1] == (Phase.ABORTED, 4, True, "asked for")
    assert h.beats == [480 * PERIOD]
    assert not h.sequencer.abort("again")


def test_starts_only_once_and_only_for_debris_within_bounds():
    h = Harness()
    with pytest.raises(ValueError, match="debris z = -70 m is out of bounds; allowed: -60 to -40 m"):
        h.sequencer.start((0.0, 0.0, -70.0), "nominal")
    assert (h.sequencer.mission.phase, h.said) == (Phase.WAITING, [])
    h.sequencer.start(DEBRIS, "nominal")
    with pytest.raises(ValueError, match="ARMED"):
        h.sequencer.start(DEBRIS, "nominal")


def test_launch_is_after_the_newest_measurement():
    rules = load(MissionParameters, {"launch_delay_s": 2.0})
    h = Harness(rules=rules)
    h.sequencer.saw_time(123 * PERIOD)
    h.sequencer.start(DEBRIS, "nominal")
    h.echo()
    assert h.sequencer.mission.launch_ns == 163 * PERIOD


def test_a_clock_that_is_set_back_sets_back_the_launch():
    h = Harness()
    h.sequencer.saw_time(10**18)
    h.sequencer.saw_time(3 * PERIOD)
    h.sequencer.saw_time(2 * PERIOD)
    assert h.sequencer.stamp_ns == 3 * PERIOD, "out of order is not set back"


def test_every_state_carries_the_planners_identity():
    system = load_system("zenit_8mu")
    sequencer = MissionSequencer(system, RULES, CONTROL, lambda *_: None, lambda _: None, mission_id=42)
    sequencer.start(DEBRIS, "nominal")
    assert sequencer.mission.mission_id == 42
