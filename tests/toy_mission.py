"""A mission's messages made up from straight lines and a folding sheet: kinematics for tests of recordings, no physics.

Everything is a plain function of time, so that a test knows what has to come out.
"""

from __future__ import annotations

import array
import functools
import importlib
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rclpy.serialization import serialize_message

from tests.systems import zenit
from tethernet_bringup.bags.message_definitions import installed_type
from tethernet_bringup.bags.metadata import BagTopic, as_texts, qos_profiles
from tethernet_bringup.bags.writer import BagWriter
from tethernet_bringup.recorder.recorded_topics import mission_topics
from tethernet_bringup.recorder.timeline import StampReader
from tethernet_core.aiming import nominal_aiming_points
from tethernet_msgs.msg import CaptureAssessment, MissionState, MuStatus

PERIOD_NS = 50_000_000
START_NS = 20 * PERIOD_NS
"""The launch on the mission's clock; all other times here count from it."""
TRIGGER_S = 24.45
END_S = 39.45
DEPLOYMENT_S = 25.0
DEBRIS = np.array([1.0, -2.0, -50.0])
ATTITUDE = (-0.5, 0.5, 0.0, math.sqrt(0.5))  # long axis, body z, along (1, 1, 0)
RADIUS_M, HALF_LENGTH_M = 1.95, 5.55
LATE_MU, LATE_TICKS = 3, 2
"""MU 3 hears of the trigger this much later than the others."""
TOW_N = 20.0
"""Tension of the main tether in a hold test; the chaser follows it from its start on."""
LOAD_PER_S, CONTACT_N = 0.002, 7.0
"""Load of the threads, which grows with time, and force of contact."""
THRUST_N = 1.5
FUEL_KG_S = THRUST_N / (9.81 * 60.0)
RUN_INFO = {
    "seed": "7",
    "commit": "0123abc",
    "mus": "8",
    "policy": "nominal",
    "pace": "lockstep",
    "parameters": "a: 1\n",
}


def desired(mu: int, time_s: float, mus: int = 8) -> np.ndarray:
    """Where an MU should be, x y z [m]."""
    aim = np.array(nominal_aiming_points(zenit(mus), DEBRIS)[mu - 1])
    if time_s >= TRIGGER_S and mus == 8:
        start, goal = desired(mu, TRIGGER_S - 1e-9), DEBRIS - [0.0, 0.0, 3.5]
        return start + (goal - start) * min((time_s - TRIGGER_S) / 8.0, 1.0)
    start = _start(mu, mus)
    return start + (aim - start) * min(time_s / DEPLOYMENT_S, 1.0)


def tracking_error(time_s: float) -> float:
    """How far each MU lags behind along x [m]."""
    return 0.8 * math.exp(-time_s / 6.0) + 0.1


def true_position(mu: int, time_s: float, mus: int = 8) -> np.ndarray:
    """Where an MU is, x y z [m]."""
    return desired(mu, time_s, mus) - [tracking_error(time_s), 0.0, 0.0]


def knots(time_s: float, mus: int = 8) -> np.ndarray:
    """The net, shape (529, 3) [m]: a bulging sheet that spreads, flies and in the end lies round the debris."""
    x, y = np.meshgrid(np.arange(23) - 11.0, np.arange(23) - 11.0)
    spread = 0.05 + 0.93 * min(time_s / DEPLOYMENT_S, 1.0)
    center = sum(desired(mu, min(time_s, TRIGGER_S - 1e-9), mus) for mu in range(1, mus + 1)) / mus
    lag = 6.0 * min(time_s / 5.0, 1.0) * (1.0 - (np.hypot(x, y) / 16.0) ** 2)
    flat = np.stack([center[0] + spread * x, center[1] + spread * y, center[2] + lag], axis=-1).reshape(-1, 3)
    share = min(max((time_s - TRIGGER_S) / 8.0, 0.0), 1.0)
    return flat + share * (_wrapped(x, y) - flat)


def locked_pairs(time_s: float, mus: int = 8) -> int:
    """Pairs that hold: one more each second, from 5 s after the trigger on."""
    return int(min(max(time_s - TRIGGER_S - 5.0, 0.0), zenit(mus).closing.max_locked_pairs))


def end_of_hold(hold_s: float) -> float:
    """When a hold test that is so long is over [s]."""
    return END_S + PERIOD_NS * 1e-9 + hold_s


def messages(mus: int = 8, end_s: float = END_S, *, seed: int = 7, hold_s: float = 0.0) -> Iterator[tuple[str, object]]:
    """All messages of the mission in the order in which they are said.

    Args:
        mus: 4 or 8.
        end_s: the tape is cut here [s].
        seed: of the sensor noise.
        hold_s: length of a hold test [s]; 0: none. It goes well.
    """
    kinds = {topic.name: topic.type_name for topic in mission_topics(mus)}
    rng = np.random.default_rng(seed)
    new = {name: _message_class(kind) for name, kind in kinds.items()}
    yield "/debris/odom", _odometry(new, "/debris/odom", START_NS, DEBRIS, ATTITUDE)
    for sequence, phase in ((1, MissionState.ARMED), (2, MissionState.DEPLOYING)):
        for confirmed in (False, True):
            yield "/mission/state", _state(new, START_NS, phase, sequence, confirmed, mus, hold_s)
    for tick in range(round(end_s * 1e9 / PERIOD_NS) + 1):
        stamp, time_s = START_NS + tick * PERIOD_NS, tick * PERIOD_NS * 1e-9
        yield from _tick(new, rng, mus, tick, stamp, time_s, hold_s)


def serialized(mus: int = 8, end_s: float = END_S, hold_s: float = 0.0) -> list[tuple[int, int, bytes]]:
    """The same as (number of the topic in mission_topics, stamp [ns], bytes).

    Made once: the middleware leaves random bytes in the gaps between fields, so twice is not the same.
    """
    return _serialized(mus, end_s, hold_s)


@functools.cache
def _serialized(mus: int, end_s: float, hold_s: float) -> list[tuple[int, int, bytes]]:
    result = []
    number = {topic.name: index for index, topic in enumerate(mission_topics(mus))}
    readers = [StampReader.of(installed_type(topic.type_name)) for topic in mission_topics(mus)]
    for name, message in messages(mus, end_s, hold_s=hold_s):
        data = serialize_message(message)
        result.append((number[name], readers[number[name]](data), data))
    return result


def bag_topics(mus: int = 8) -> list[BagTopic]:
    """The topics of a mission's bag."""
    return [
        BagTopic(topic.name, installed_type(topic.type_name).message_type, qos_profiles(latched=topic.latched))
        for topic in mission_topics(mus)
    ]


def write_bag(
    folder: Path, mus: int = 8, end_s: float = END_S, *, without=(), flush_every_s: float = 1.0, hold_s: float = 0.0
) -> Path:
    """Record the mission.

    Args:
        folder: of the bag.
        mus: 4 or 8.
        end_s: the tape is cut here [s].
        without: topics to leave out.
        flush_every_s: mission time between two flushes [s].
        hold_s: length of a hold test [s]; 0: none.
    """
    topics = bag_topics(mus)
    kept = [topic for topic in topics if topic.name not in without]
    number = {index: kept.index(topic) for index, topic in enumerate(topics) if topic in kept}
    writer = BagWriter(folder, kept, run_info=as_texts(RUN_INFO | {"mus": str(mus)}))
    next_flush, counter = START_NS * 1e-9, [0] * len(topics)
    for index, stamp, data in serialized(mus, end_s, hold_s):
        if index not in number:
            continue
        if stamp * 1e-9 >= next_flush:
            writer.flush()
            next_flush += flush_every_s
        counter[index] += 1
        writer.write(number[index], stamp, stamp, counter[index], data)
    writer.close()
    return folder


def _tick(new, rng, mus, tick, stamp, time_s, hold_s):
    clock = new["/clock"]()
    _stamp(clock.clock, stamp)
    yield "/clock", clock
    positions = [true_position(mu, time_s, mus) for mu in range(1, mus + 1)]
    for mu, position in enumerate(positions, start=1):
        measured = position + rng.normal(0.0, 0.1 / 3.0, 3)
        yield f"/mu{mu}/odom", _odometry(new, f"/mu{mu}/odom", stamp, measured)
        thrust = new["/mu1/thrust"]()
        _head(thrust, stamp)
        thrust.wrench.force.x = THRUST_N
        yield f"/mu{mu}/thrust", thrust
        if tick % 4 == 0 or tick - _first_closing_tick(mu) in (-1, 0):
            yield f"/mu{mu}/status", _status(new, mu, mus, tick, stamp, time_s)
    yield "/debris/odom", _odometry(new, "/debris/odom", stamp, DEBRIS, ATTITUDE)
    yield "/chaser/odom", _odometry(new, "/chaser/odom", stamp, (0.0, 0.0, 0.75))
    yield "/net/state", _net(new, mus, stamp, time_s, positions)
    transforms = new["/tf"]()
    transforms.transforms.append(_message_class("geometry_msgs/msg/TransformStamped")())
    _head(transforms.transforms[0], stamp)
    yield "/tf", transforms
    if tick % 4 == 0:
        yield "/capture/assessment", _assessment(new, mus, stamp, time_s)
    if math.isclose(time_s, TRIGGER_S):
        for confirmed in (False, True):
            yield "/mission/state", _state(new, stamp - PERIOD_NS, MissionState.CLOSING, 3, confirmed, mus, hold_s)
        yield "/capture/assessment", _assessment(new, mus, stamp, time_s, CaptureAssessment.TRIGGER)
    if math.isclose(time_s, END_S):
        after = MissionState.HOLDING if hold_s else MissionState.COMPLETE
        for confirmed in (False, True):
            yield "/mission/state", _state(new, stamp, after, 4, confirmed, mus, hold_s)
        yield "/capture/assessment", _assessment(new, mus, stamp, time_s, CaptureAssessment.FINAL)
    if hold_s and math.isclose(time_s, end_of_hold(hold_s)):
        for confirmed in (False, True):
            yield "/mission/state", _state(new, stamp, MissionState.COMPLETE, 5, confirmed, mus, hold_s)
        yield "/capture/assessment", _assessment(new, mus, stamp, time_s, CaptureAssessment.HELD)
    heartbeat = new["/planner/heartbeat"]()
    _stamp(heartbeat.stamp, stamp)
    yield "/planner/heartbeat", heartbeat


def _start(mu, mus):
    x, y = zenit(mus).aiming.offsets[mu - 1]
    return np.array([0.05 * x, 0.05 * y, -1.5])


def _wrapped(x, y):
    """Knots that reach over the edge of the debris hang down behind it."""
    along, across = (x + y) / math.sqrt(2.0), (x - y) / math.sqrt(2.0)
    scale = np.maximum(np.maximum(abs(along) / (HALF_LENGTH_M + 0.3), abs(across) / (RADIUS_M + 0.3)), 1.0)
    over = np.minimum(np.hypot(along, across) * (1.0 - 1.0 / scale), 6.0)
    along, across = along / scale, across / scale
    shrink = np.where(over > 2.0 * RADIUS_M, 1.0 - (over - 2.0 * RADIUS_M) / 4.0, 1.0)
    depth = RADIUS_M + 0.2 - np.minimum(over, 2.0 * RADIUS_M + 0.6)
    across, along = across * shrink, along * shrink
    return np.stack(
        [
            DEBRIS[0] + (along + across) / math.sqrt(2.0),
            DEBRIS[1] + (along - across) / math.sqrt(2.0),
            DEBRIS[2] + depth,
        ],
        axis=-1,
    ).reshape(-1, 3)


def _message_class(type_name):
    package, _, name = type_name.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def _stamp(target, ns):
    target.sec, target.nanosec = divmod(ns, 1_000_000_000)


def _head(message, ns):
    _stamp(message.header.stamp, ns)
    message.header.frame_id = "launch"


def _xyz(target, values):
    target.x, target.y, target.z = (float(value) for value in values)


def _odometry(new, topic, stamp, position, attitude=(0.0, 0.0, 0.0, 1.0)):
    message = new[topic]()
    _head(message, stamp)
    _xyz(message.pose.pose.position, position)
    turn = message.pose.pose.orientation
    turn.x, turn.y, turn.z, turn.w = attitude
    return message


def _state(new, stamp, phase, sequence, confirmed, mus, hold_s):
    message = new["/mission/state"](phase=phase, sequence=sequence, confirmed=confirmed, mu_count=mus, policy="nominal")
    _head(message, stamp)
    _xyz(message.debris_position, DEBRIS)
    if phase >= MissionState.DEPLOYING:
        _stamp(message.launch_time, START_NS)
    if phase >= MissionState.CLOSING:
        _stamp(message.closing_time, START_NS + round(TRIGGER_S * 1e9))
        _stamp(message.end_time, START_NS + round(END_S * 1e9))
    if hold_s:
        message.hold_duration, message.tow = hold_s, TOW_N
        if sequence > 3:
            _stamp(message.hold_time, START_NS + round(END_S * 1e9) + PERIOD_NS)
            _stamp(message.hold_end_time, START_NS + round(end_of_hold(hold_s) * 1e9))
    return message


def _first_closing_tick(mu):
    return round(TRIGGER_S * 1e9 / PERIOD_NS) + (LATE_TICKS if mu == LATE_MU else 0)


def _status(new, mu, mus, tick, stamp, time_s):
    closing = _first_closing_tick(mu)  # the state was taken over after the tick before it was answered
    message = new[f"/mu{mu}/status"](
        mu=mu,
        mode=MuStatus.DEPLOYING if tick < closing else MuStatus.CLOSING,
        mission_sequence=2 if tick < closing - 1 else 3,
        aiming_source="nominal",
        tracking_error=tracking_error(time_s),
        max_tracking_error=tracking_error(0.0),
        fuel=FUEL_KG_S * time_s,
        fuel_at_trigger=FUEL_KG_S * min(time_s, TRIGGER_S),
        commands=tick + 1,
        saturated=(tick + 1) // 10,
    )
    _head(message, stamp)
    _xyz(message.aiming_point, nominal_aiming_points(zenit(mus), DEBRIS)[mu - 1])
    _xyz(message.desired_position, desired(mu, time_s, mus))
    return message


def _net(new, mus, stamp, time_s, positions):
    points = knots(time_s, mus)
    pairs = zenit(mus).closing.max_locked_pairs
    message = new["/net/state"](rows=23, columns=23)
    _head(message, stamp)
    _xyz(message.center_of_mass, points.mean(axis=0))
    message.center_of_mass_all_valid = True
    _xyz(message.center_of_mass_all, np.mean(positions, axis=0))
    message.knot_positions = array.array("f", points.astype(np.float32).tobytes())
    message.knot_velocities = array.array("f", bytes(4 * points.size))
    message.mu_positions = array.array("f", np.array(positions, np.float32).tobytes())
    message.mu_velocities = array.array("f", bytes(4 * 3 * mus))
    message.load_share_valid = message.contact_force_valid = True
    message.load_share = message.max_load_share = LOAD_PER_S * time_s
    message.contact_force = message.max_contact_force = CONTACT_N
    message.tether_tension = TOW_N if time_s > END_S else 0.0
    message.locked = [i < locked_pairs(time_s, mus) for i in range(pairs)]
    return message


def _assessment(new, mus, stamp, time_s, stage=CaptureAssessment.PROGRESS):
    system = zenit(mus)
    message = new["/capture/assessment"](
        stage=stage,
        hull_valid=True,
        cqi_all_valid=True,
        distance_valid=True,
        cqi=0.9 + 30.0 * max(1.0 - time_s / 35.0, 0.0),
        cqi_all=1.7 + 30.0 * max(1.0 - time_s / 35.0, 0.0),
        mouth_area=535.0,
        net_debris_distance=float(np.linalg.norm(knots(time_s, mus).mean(axis=0) - DEBRIS)),
        locked_pairs=locked_pairs(time_s, mus),
        max_locked_pairs=system.closing.max_locked_pairs,
        required_locked_pairs=system.capture.required_locked_pairs,
        source="net_state",
        load_share_valid=True,
        max_load_share=LOAD_PER_S * time_s,
        contact_force_valid=True,
        max_contact_force=CONTACT_N,
        enclosed_valid=time_s >= TRIGGER_S,
        enclosed=time_s >= TRIGGER_S + 5.0,
        mcqi_valid=time_s >= END_S,
        mcqi=0.3 if time_s >= END_S else 0.0,
    )
    _head(message, stamp)
    if stage == CaptureAssessment.FINAL:
        message.captured = True
        message.verdict = "captured: CQI 0.90 below 2.5, 8 of 8 pairs locked"
    if stage == CaptureAssessment.HELD:
        message.held_valid = message.held = True
        message.hold_verdict = "held: the closed net goes round the whole debris"
    return message
