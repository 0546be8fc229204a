"""What each message must keep to be used: the contract of every topic and service, as code.

A :class:`Check` turns the bytes of one message into plain values or a message that can be used as it is, or raises
:class:`.well_formed.MessageError` with what was given and what is allowed. Nothing else in the project decides whether
a message is sound. What is common to all types (finite numbers, stamps, lengths of texts) is in
:mod:`.well_formed`, the types that arrive at every control tick are in :mod:`.serialized`; which stamps and sequences
follow on which is up to who receives them. What others have written for people to read comes out escaped and cut.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, NamedTuple, Protocol, TypeVar

from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from tethernet_core.bounds import FARTHEST_M
from tethernet_core.mission import Mission, Mode, Phase
from tethernet_core.settings import HARDEST_TOW_N, LONGEST_HOLD_S
from tethernet_core.shown import shown
from tethernet_core.system import MOST_UNITS, System
from tethernet_core.unknown import restore
from tethernet_msgs.msg import CaptureAssessment, MissionState, MuStatus, NetState, SimStatus
from tethernet_msgs.srv import PlanAimingPoints
from tethernet_ros.conversions import Vector, coordinates, nanoseconds
from tethernet_ros.field_checks import not_negative, one_of, within
from tethernet_ros.net_state import NetMeasurement, NetStateReader
from tethernet_ros.serialized import (
    OdometrySample,
    ThrustCommand,
    check_bounds,
    check_frame,
    decoded,
    header_stamp,
    odometry_sample,
    thrust_command,
)
from tethernet_ros.topics import mu_frame
from tethernet_ros.well_formed import Message, MessageError, check_well_formed


class StampedMessage(Message, Protocol):
    """Any message with a header."""

    header: Header


Checked = TypeVar("Checked")
Stamped = TypeVar("Stamped", bound=StampedMessage)

SOURCES = ("net_state", "mu_odometry")
"""What an assessment may be made from."""

_SMALL, _MIDDLE, _LARGE = 16_384, 65_536, 4_194_304
"""Most bytes of a message with a header and numbers, with texts, with a whole net: longer ones are not read."""

_MODES, _PHASES = range(max(Mode) + 1), range(max(Phase) + 1)
_LONGEST_S = 1e6
"""Of a duration [s]."""


@dataclass(frozen=True)
class Check(Generic[Checked]):
    """How the messages of one topic are checked."""

    kind: type[Message]
    """The message's type."""
    read: Callable[[bytes], Checked]
    """The checked values from the message's bytes; raises MessageError."""
    largest_bytes: int = _MIDDLE
    """More are refused unread."""


class MissionNews(NamedTuple):
    """What a mission state says."""

    mission: Mission
    stamp_ns: int
    """When it was decided [ns]."""
    confirmed: bool
    """Every reachable controller has echoed it."""
    message: MissionState
    """As it came, checked."""


class PlanRequest(NamedTuple):
    """What somebody asks the planner."""

    policy: str
    """Empty: the planner's own."""
    mu_count: int
    """0: as many as the planner's system has."""
    debris_position: Vector
    """[m]."""


class PlanAnswer(NamedTuple):
    """What the planner answers."""

    success: bool
    message: str
    policy: str
    """That made the points."""
    points: list[Vector]
    """[m], one for each unit; empty without success."""


THRUST: Check[ThrustCommand] = Check(WrenchStamped, thrust_command, _SMALL)
"""geometry_msgs/WrenchStamped of a controller."""

HEARTBEAT: Check[int] = Check(Header, header_stamp, _SMALL)
"""std_msgs/Header of the planner: the stamp [ns]."""


def odometry(mu: int | None = None) -> Check[OdometrySample]:
    """nav_msgs/Odometry of unit ``mu``, and of no other; None: of the debris or the chaser."""
    return Check(Odometry, functools.partial(odometry_sample, child=None if mu is None else mu_frame(mu)), _SMALL)


def mission_state(system: System | None = None) -> Check[MissionNews]:
    """tethernet_msgs/MissionState.

    Args:
        system: it must be of a mission with as many units; None for any number.
    """
    mu_count, name = (None, "") if system is None else (system.unit_count, system.name)

    def read(data: bytes) -> MissionNews:
        message = _sound(data, MissionState, "reason")
        mission = mission_from(message)
        if mu_count is not None and mission.mu_count != mu_count:
            raise MessageError(f"a mission of {mission.mu_count} units; allowed: {mu_count}, of system {name}")
        return MissionNews(mission, nanoseconds(message.header.stamp), message.confirmed, message)

    return Check(MissionState, read)


def mission_from(message: MissionState) -> Mission:
    """The mission that a message tells of.

    Args:
        message: well-formed, see :func:`.well_formed.check_well_formed`.

    Raises:
        MessageError: for a phase that does not exist, more units than a system has, times in the wrong order, points
            that no unit can fly to.
    """
    one_of("phase", message.phase, _PHASES)
    one_of("mu_count", message.mu_count, range(MOST_UNITS + 1))
    for name, given in (("closing_points", message.closing_points), ("docked_times", message.docked_times)):
        one_of(f"the number of {name}", len(given), sorted({0, message.mu_count}))
    stamps = (message.launch_time, message.closing_time, message.end_time, message.hold_time, message.hold_end_time)
    times = [nanoseconds(time) for time in stamps]
    known = [time_ns for time_ns in times if time_ns]
    if known != sorted(known):
        raise MessageError(
            f"launch, closing, end, hold and its end at {times} ns; allowed: in this order, 0 where not known yet"
        )
    within("closing_duration", message.closing_duration, _LONGEST_S, "s")
    within("hold_duration", message.hold_duration, LONGEST_HOLD_S, "s")
    within("tow", message.tow, HARDEST_TOW_N, "N")
    for point in (message.debris_position, *message.closing_points):
        check_bounds(coordinates(point), FARTHEST_M, "a point", "m")
    launch_ns, closing_ns, end_ns, hold_ns, hold_end_ns = times
    phase = Phase(message.phase)
    if phase == Phase.HOLDING and not 0 < hold_ns <= hold_end_ns:
        raise MessageError(f"HOLDING from {hold_ns} ns to {hold_end_ns} ns; allowed: both are known")
    return Mission(
        mu_count=message.mu_count,
        phase=phase,
        sequence=message.sequence,
        mission_id=message.mission_id,
        policy=message.policy,
        launch_ns=launch_ns,
        closing_ns=closing_ns,
        end_ns=end_ns,
        debris_position=coordinates(message.debris_position),
        closing_points=tuple(map(coordinates, message.closing_points)),
        closing_duration_s=message.closing_duration,
        points_ns=nanoseconds(message.points_time),
        docked_ns=tuple(map(nanoseconds, message.docked_times)),
        hold_s=message.hold_duration,
        tow_n=message.tow,
        hold_ns=hold_ns,
        hold_end_ns=hold_end_ns,
        reason=message.reason,
    )


def mu_status(mu: int) -> Check[MuStatus]:
    """tethernet_msgs/MuStatus on the topic of unit ``mu``."""

    def read(data: bytes) -> MuStatus:
        message = _sound(data, MuStatus, "aiming_source")
        one_of("mu", message.mu, (mu,))
        one_of("mode", message.mode, _MODES)
        not_negative(message, "tracking_error", "max_tracking_error", "fuel", "fuel_at_trigger")
        not_negative(message, "position_sigma", "velocity_sigma")
        for point in (message.aiming_point, message.desired_position):
            check_bounds(coordinates(point), FARTHEST_M, "a point", "m")
        return message

    return Check(MuStatus, read)


def net_state(system: System) -> Check[NetMeasurement]:
    """tethernet_msgs/NetState.

    Args:
        system: whose net it must be.
    """
    return Check(NetState, NetStateReader(system).read, _LARGE)


def sim_status(system: System) -> Check[SimStatus]:
    """tethernet_msgs/SimStatus.

    Args:
        system: it must tell of as many units.
    """
    mu_count = system.unit_count

    def read(data: bytes) -> SimStatus:
        message = _sound(data, SimStatus, "fault")
        for name in ("late_commands", "rejected_commands", "clipped_commands", "zeroed_commands", "applied_fuel"):
            one_of(f"the number of {name}", len(getattr(message, name)), (mu_count,))
        lost = list(message.lost_controllers)
        if len(lost) > mu_count or not all(1 <= mu <= mu_count for mu in lost):
            raise MessageError(f"lost_controllers are {lost[:mu_count]}; allowed: numbers from 1 to {mu_count}")
        not_negative(message, "real_time_factor", "latency_p50", "latency_p99", "latency_max")
        if any(value < 0.0 for value in message.applied_fuel):
            raise MessageError(f"applied_fuel is {list(message.applied_fuel)} kg; allowed: 0 and more")
        return message

    return Check(SimStatus, read)


def assessment(system: System) -> Check[CaptureAssessment]:
    """tethernet_msgs/CaptureAssessment; numbers that are not known are NaN in what comes out.

    Args:
        system: whose capture it must tell of.
    """
    most, required = system.closing.max_locked_pairs, system.capture.required_locked_pairs

    def read(data: bytes) -> CaptureAssessment:
        message = _sound(data, CaptureAssessment, "verdict", "hold_verdict", "predictor")
        one_of("stage", message.stage, range(CaptureAssessment.HELD + 1))
        one_of("source", message.source, SOURCES)
        one_of("max_locked_pairs", message.max_locked_pairs, (most,))
        one_of("required_locked_pairs", message.required_locked_pairs, (required,))
        one_of("locked_pairs", message.locked_pairs, range(most + 1))
        not_negative(
            message, "cqi", "cqi_all", "mcqi", "hull_volume", "hull_area", "mouth_area", "net_debris_distance",
            "max_load_share", "max_contact_force",
        )  # fmt: skip
        if not 0.0 <= message.predicted_capture_probability <= 1.0:
            raise MessageError(
                f"predicted_capture_probability is {message.predicted_capture_probability:g}; allowed: 0 to 1"
            )
        return restore(message)

    return Check(CaptureAssessment, read)


def plan_request(message: PlanAimingPoints.Request) -> PlanRequest:
    """What somebody asks the planner; whether there is such a policy and such a place is the planner's business.

    Raises:
        MessageError: for numbers that are not finite, or a name without end.
    """
    check_well_formed(message)
    return PlanRequest(message.policy, message.mu_count, coordinates(message.debris_position))


def plan_answer(mu_count: int) -> Callable[[PlanAimingPoints.Response], PlanAnswer]:
    """The check of the planner's answer.

    Args:
        mu_count: how many aiming points there must be, where there are any.
    """

    def read(message: PlanAimingPoints.Response) -> PlanAnswer:
        check_well_formed(message)
        points = [coordinates(point) for point in message.aiming_points]
        allowed = (mu_count,) if message.success else sorted({0, mu_count})
        one_of("the number of aiming_points", len(points), allowed)
        for point in points:
            check_bounds(point, FARTHEST_M, "an aiming point", "m")
        return PlanAnswer(message.success, shown(message.message), message.policy, points)

    return read


def trigger_request(message: Trigger.Request) -> None:
    """std_srvs/Trigger asks nothing that could be wrong."""


def trigger_answer(message: Trigger.Response) -> tuple[bool, str]:
    """Whether a std_srvs/Trigger was done, and what is said of it.

    Raises:
        MessageError: for a text without end.
    """
    check_well_formed(message)
    return message.success, shown(message.message)


def _sound(data: bytes, kind: type[Stamped], *texts: str) -> Stamped:
    """The message, well-formed and in frame launch; ``texts`` are for people and made fit to be seen."""
    message = decoded(data, kind)
    check_frame(message.header.frame_id, kind)
    check_well_formed(message)
    for name in texts:
        setattr(message, name, shown(getattr(message, name)))
    return message
