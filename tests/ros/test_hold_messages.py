"""What messages tell of a hold test and of loads, and what of it is refused."""

import math

import pytest
from rclpy.serialization import serialize_message

from tethernet_core.mission import Mission, Phase, arm, launch
from tethernet_core.system import load_system
from tethernet_core.unknown import answer
from tethernet_msgs.msg import CaptureAssessment, MissionState, NetState
from tethernet_ros import checks, topics
from tethernet_ros.conversions import mission_message, time_message
from tethernet_ros.well_formed import MessageError

SYSTEM = load_system("zenit_8mu")
SECOND = 1_000_000_000


def holding() -> Mission:
    """A mission that is in its hold test."""
    flying = launch(arm(Mission(8, mission_id=5, hold_s=60.0, tow_n=20.0), (0.0, 0.0, -50.0), "nominal"), SECOND)
    return flying.next(
        Phase.HOLDING, closing_ns=25 * SECOND, end_ns=40 * SECOND, hold_ns=41 * SECOND, hold_end_ns=101 * SECOND
    )


def read(message, check):
    return check.read(bytes(serialize_message(message)))


def net(**fields) -> NetState:
    grid = SYSTEM.net.grid
    knots, units = [0.0] * (3 * SYSTEM.net.node_count), [0.0] * 24
    message = NetState(
        rows=grid.rows, columns=grid.columns, knot_positions=knots, knot_velocities=knots, mu_positions=units,
        mu_velocities=units, locked=[False] * SYSTEM.closing.max_locked_pairs, **fields,
    )  # fmt: skip
    message.header.frame_id = topics.FRAME
    return message


def assessment(**fields) -> CaptureAssessment:
    message = CaptureAssessment(source="net_state", max_locked_pairs=8, required_locked_pairs=6, **fields)
    message.header.frame_id = topics.FRAME
    return message


def test_a_mission_that_is_tested_for_holding_comes_through_whole():
    mission = holding()
    assert MissionState.HOLDING == Phase.HOLDING
    assert read(mission_message(mission, 0, True), checks.mission_state(SYSTEM)).mission == mission


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"tow": -1.0}, "tow is -1 N; allowed: 0 to 1000"),
        ({"tow": 1e6}, "tow is 1e+06 N; allowed: 0 to 1000"),
        ({"hold_duration": 1e9}, "hold_duration is 1e+09 s; allowed: 0 to 1000"),
        ({"tow": math.nan}, "tow is nan"),
        ({"hold_time": time_message(39 * SECOND)}, "allowed: in this order, 0 where not known yet"),
        ({"hold_end_time": time_message(40 * SECOND)}, "allowed: in this order"),
        ({"hold_time": time_message(0)}, "HOLDING from 0 ns to"),
        ({"hold_end_time": time_message(0)}, "allowed: both are known"),
        ({"phase": 8}, "phase is 8; allowed: 0 to 7"),
    ],
)
def test_a_state_that_cannot_be_is_refused(change, said):
    message = mission_message(holding(), 0, True)
    for name, value in change.items():
        setattr(message, name, value)
    with pytest.raises(MessageError) as error:
        read(message, checks.mission_state(SYSTEM))
    assert said in str(error.value)


def test_loads_come_through_and_are_nan_where_they_are_not_known():
    told = net(load_share_valid=True, max_load_share=0.2, contact_force_valid=True, max_contact_force=420.0)
    found = read(told, checks.net_state(SYSTEM))
    assert (found.max_load_share, found.max_contact_force) == (0.2, 420.0)
    silent = read(net(max_load_share=0.2, max_contact_force=1.0), checks.net_state(SYSTEM))
    assert math.isnan(silent.max_load_share)
    assert math.isnan(silent.max_contact_force)
    huge = net(load_share_valid=True, max_load_share=1e12)  # a strength of nearly nothing may be described
    assert read(huge, checks.net_state(SYSTEM)).max_load_share == 1e12


@pytest.mark.parametrize("name", ["load_share", "max_load_share", "contact_force", "max_contact_force"])
@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
def test_loads_that_cannot_be_are_refused(name, value):
    with pytest.raises(MessageError, match=rf"{name} is .*allowed: finite, 0 and more"):
        read(net(**{name: value}), checks.net_state(SYSTEM))


def test_what_a_hold_test_came_to_comes_through():
    told = assessment(
        stage=CaptureAssessment.HELD, held_valid=True, held=True, hold_verdict="held\x1b[2J", mcqi_valid=True, mcqi=0.2
    )
    found = read(told, checks.assessment(SYSTEM))
    assert (answer(found, "held"), answer(found, "enclosed"), found.mcqi) == (True, None, 0.2)
    assert found.hold_verdict == "held\\x1b[2J"
    assert math.isnan(found.max_load_share)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"stage": 4}, "stage is 4; allowed: 0 to 3"),
        ({"mcqi": -1.0}, "mcqi is -1"),
        ({"max_load_share": -1.0}, "max_load_share is -1"),
        ({"max_contact_force": math.inf}, "max_contact_force is inf"),
        ({"hold_verdict": "x" * 100_000}, "hold_verdict has 100000 characters|bytes; allowed"),
    ],
)
def test_an_assessment_that_cannot_be_is_refused(change, said):
    with pytest.raises(MessageError, match=said):
        read(assessment(**change), checks.assessment(SYSTEM))
