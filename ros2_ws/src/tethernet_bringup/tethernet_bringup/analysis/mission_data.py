"""A recorded mission as series of numbers over time, read from a bag in bounded memory.

The bag is read once for the mission's clock and once for the series, and :mod:`tethernet_bringup.analysis.snapshots`
reads it again for the few moments at which the whole net is looked at. Times are those of stamps, whatever the recorder
took for the time of recording (:mod:`tethernet_bringup.analysis.mission_clock`); they count from the launch [s]; where
no launch is recorded, from the first message.
"""

from __future__ import annotations

import functools
import math
import re
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import yaml

from tethernet_bringup.analysis.decoder import Decoder
from tethernet_bringup.analysis.mission_clock import MissionClock, mission_clock
from tethernet_bringup.analysis.series import Series
from tethernet_bringup.analysis.topic_count import TopicCount
from tethernet_bringup.bags.errors import NotABagError
from tethernet_bringup.bags.reader import BagMessage, BagReader
from tethernet_bringup.bags.run_info import DESCRIPTION, PARAMETERS, TEXTS
from tethernet_bringup.bags.writer import RUN_INFO_RECORD
from tethernet_core.mission import Phase
from tethernet_core.settings import NANOSECOND_S
from tethernet_core.shown import shown
from tethernet_core.system import DescriptionError, System, system_from_text
from tethernet_core.system.option import family
from tethernet_core.unknown import answer, restore
from tethernet_ros import topics

if TYPE_CHECKING:
    from builtin_interfaces.msg import Time
    from geometry_msgs.msg import Point, Vector3, WrenchStamped
    from nav_msgs.msg import Odometry

    from tethernet_msgs.msg import CaptureAssessment, MissionState, MuStatus, NetState

    # What the decoder makes has their fields, whether the messages are built here or not.

_MU_TOPIC = re.compile(r"/mu(\d+)/(odom|thrust|status)$")


@dataclass
class MuData:
    """What is recorded of one MU."""

    measured: Series = field(default_factory=lambda: Series(3))
    """Position by its odometry [m]."""
    thrust: Series = field(default_factory=lambda: Series(3))
    """Commanded force [N]."""
    plan: Series = field(default_factory=lambda: Series(4))
    """Desired position [m], and 1 where it is being flown to, else 0."""
    fuel: Series = field(default_factory=lambda: Series(1))
    """Used since launch [kg]."""
    status: MuStatus | None = None
    """The newest MuStatus."""
    modes: list[tuple[int, int]] = field(default_factory=list)
    """When it reported another mode than before [ns], and which (MuStatus)."""
    taken_over_ns: dict[int, int] = field(default_factory=dict)
    """Newest tick that was answered when a state of the mission was taken over [ns], by the state's sequence."""


@dataclass(frozen=True)
class Assessment:
    """One CaptureAssessment, the newest of its stage."""

    time_ns: int
    message: CaptureAssessment


@dataclass(frozen=True)
class PhaseChange:
    """The mission entered a phase."""

    time_ns: int
    phase: Phase
    reason: str


@dataclass
class MissionData:
    """A mission as recorded."""

    facts: dict[str, str] = field(default_factory=dict)
    """What the recorder was told of the run: seed, commit, system, mus, policy, pace, parameters."""
    mus: dict[int, MuData] = field(default_factory=dict)
    """By number, from 1."""
    phases: list[PhaseChange] = field(default_factory=list)
    states: list[MissionState] = field(default_factory=list)
    """Newest MissionState of each sequence."""
    decided_ns: dict[int, int] = field(default_factory=dict)
    """Tick that was decided on [ns], by sequence: the stamp of the first of its states."""
    assessments: Series = field(default_factory=lambda: Series(2))
    """CQI (NaN where unmeasured) and locked pairs."""
    distances: Series = field(default_factory=lambda: Series(1))
    """Net to debris by the assessor [m]."""
    enclosure: Series = field(default_factory=lambda: Series(2))
    """Whether the closed net goes round the whole debris (1 or 0), and the MCQI (-1 where unmeasured)."""
    final: Assessment | None = None
    trigger: Assessment | None = None
    hold: Assessment | None = None
    """What the hold test came to."""
    debris: Series = field(default_factory=lambda: Series(7))
    """Position [m] and attitude x y z w."""
    chaser: Series = field(default_factory=lambda: Series(7))
    net: Series = field(default_factory=lambda: Series(3))
    """The net's centre of mass [m]."""
    truth: dict[int, Series] = field(default_factory=dict)
    """True positions of the units [m], where a simulator published them."""
    locked: Series = field(default_factory=lambda: Series(1))
    """Closing pairs that hold, by /net/state."""
    load_share: Series = field(default_factory=lambda: Series(1))
    """Largest tension of any thread over its strength [-], by /net/state."""
    contact: Series = field(default_factory=lambda: Series(1))
    """Force of contact on the debris [N], likewise."""
    tether: Series = field(default_factory=lambda: Series(1))
    """Tension of the main tether [N], likewise."""
    lacks: set[str] = field(default_factory=set)
    """Fields that messages of this recording do not have, because it was made before there were any."""
    net_stamps: array[int] = field(default_factory=lambda: array("q"))
    """Of every /net/state in the order of the bag [ns]."""
    node_count: int | None = None
    """Nodes of the net, by /net/state; None where that is not recorded."""
    topics: dict[str, TopicCount] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)
    """What is wrong with the bag."""
    undecodable: dict[str, int] = field(default_factory=dict)
    """Messages that do not fit their type, by topic."""

    @property
    def mu_count(self) -> int:
        """Number of units, as the mission's state or the run's facts tell; else what units there are."""
        if self.states:
            return int(self.states[-1].mu_count)
        if self.facts.get("mus", "").isdigit():
            return int(self.facts["mus"])
        return max(self.mus, default=0)

    @property
    def origin_ns(self) -> int:
        """The launch, or the first message where there is none [ns]."""
        for change in self.phases:
            if change.phase == Phase.DEPLOYING:
                return change.time_ns
        return min((topic.times[0] for topic in self.topics.values() if topic.times), default=0)

    @property
    def end_ns(self) -> int:
        """The last message [ns]."""
        return max((max(topic.times) for topic in self.topics.values() if topic.times), default=0)

    @property
    def over_ns(self) -> int | None:
        """When the mission was over, one way or the other [ns]; None if the recording ends before."""
        return next((change.time_ns for change in self.phases if change.phase.over), None)

    @property
    def planned_debris(self) -> np.ndarray | None:
        """Where the planner took the debris to be, x y z [m]; None where it did not say."""
        for state in reversed(self.states):
            place = np.array(_xyz(state.debris_position))
            if np.isfinite(place).all() and place.any():
                return place
        return None

    @property
    def closing_ns(self) -> int | None:
        """When closing began [ns]; None if it did not."""
        return next((change.time_ns for change in self.phases if change.phase == Phase.CLOSING), None)

    @property
    def judged_ns(self) -> int | None:
        """When the capture was judged where a hold test followed [ns]; None without one."""
        return next((change.time_ns for change in self.phases if change.phase == Phase.HOLDING), None)

    def seconds(self, stamps_ns: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Time since the launch [s]."""
        return np.asarray((np.asarray(stamps_ns) - self.origin_ns) * NANOSECOND_S)

    @functools.cached_property
    def system(self) -> System | None:
        """What was flown, as the recording describes it; in one that does not, the shipped system of the paper with as
        many units and, where the net is recorded, as many nodes. None where there is no such, or the description cannot
        be read.
        """
        try:
            if DESCRIPTION in self.facts:
                return system_from_text(self.facts[DESCRIPTION], source="the recording's description")
            return next(filter(self._is_like, family()), None)
        except DescriptionError as error:
            self.problems.append(f"what was flown is not known: {shown(error)}")
            return None

    def _is_like(self, system: System) -> bool:
        return system.unit_count == self.mu_count and self.node_count in (None, system.net.node_count)

    @property
    def parameters(self) -> Any:
        """The run's parameters as nested mappings; empty where unknown."""
        try:
            return yaml.load(self.facts.get(PARAMETERS, ""), getattr(yaml, "CSafeLoader", yaml.SafeLoader)) or {}
        except yaml.YAMLError:
            return {}


def load(bag: BagReader) -> MissionData:
    """Read the series.

    Args:
        bag: whole or torn.

    Raises:
        NotABagError: when there is no message in it, or none of a mission's topics.
        BagError: when it cannot be read.
    """
    data, decode = MissionData(), Decoder()
    reader = _Reader(bag, data, decode, mission_clock(bag, decode))
    for message in bag.messages():
        reader.take(message)
    data.problems = list(bag.problems)
    facts = bag.metadata.get(RUN_INFO_RECORD, {})
    data.facts = {name: text if name in TEXTS else shown(text) for name, text in facts.items()}
    for name in bag.topics:
        data.topics.setdefault(name, TopicCount(bag.topics[name].message_type.name))
    if not any(topic.times for topic in data.topics.values()):
        raise NotABagError(f"not one message is in {bag.files[0]} ({'; '.join(data.problems) or 'it is empty'})")
    if not reader.used:
        named = ", ".join(sorted(data.topics)[:8])
        raise NotABagError(f"{bag.files[0]} holds no mission: none of its topics is one of ours; it has {named}")
    return data


class _Reader:
    def __init__(self, bag: BagReader, data: MissionData, decode: Decoder, clock: MissionClock):
        self._bag = bag
        self._data = data
        self._decode = decode
        self._clock = clock
        self.used = 0
        self._takers: dict[str, Callable[[Any], None]] = {
            topics.MISSION_STATE: self._state,
            topics.CAPTURE_ASSESSMENT: self._assessment,
            topics.NET_STATE: self._net,
            topics.DEBRIS_ODOMETRY: lambda message: self._body(self._data.debris, message),
            topics.CHASER_ODOMETRY: lambda message: self._body(self._data.chaser, message),
        }

    def take(self, message: BagMessage) -> None:
        data = self._data
        kind = self._bag.topics[message.topic].message_type
        if message.topic not in data.topics:
            data.topics[message.topic] = TopicCount(kind.name)
        time_ns = self._clock.time_ns(self._decode.stamp_ns(kind, message.data), message.log_time)
        data.topics[message.topic].count(time_ns, message.sequence)
        taker = self._takers.get(message.topic)
        if taker is None:
            found = _MU_TOPIC.match(message.topic)
            if not found:
                return
            taker = self._takers[message.topic] = self._mu_taker(int(found[1]), found[2])
        try:
            decoded = self._decode(kind, message.data)
            _date(decoded.header.stamp, time_ns)
            taker(decoded)
            self.used += 1
        except (ValueError, AttributeError):  # damaged, or a topic of ours with another type
            data.undecodable[message.topic] = data.undecodable.get(message.topic, 0) + 1

    def _mu_taker(self, mu: int, what: str) -> Callable[[Any], None]:
        series = self._data.mus.setdefault(mu, MuData())

        def odometry(message: Odometry) -> None:
            series.measured.add(_stamp(message), *_xyz(message.pose.pose.position))

        def thrust(message: WrenchStamped) -> None:
            series.thrust.add(_stamp(message), *_xyz(message.wrench.force))

        def status(message: MuStatus) -> None:
            stamp = _stamp(message)
            series.plan.add(stamp, *_xyz(message.desired_position), float(message.mode in (1, 2)))
            series.fuel.add(stamp, message.fuel)
            series.status = message
            if not series.modes or series.modes[-1][1] != message.mode:
                series.modes.append((stamp, message.mode))
            series.taken_over_ns.setdefault(message.mission_sequence, stamp)

        takers: dict[str, Callable[[Any], None]] = {"odom": odometry, "thrust": thrust, "status": status}
        return takers[what]

    def _state(self, message: MissionState) -> None:
        data = self._data
        stamp = _stamp(message)
        data.decided_ns[message.sequence] = min(stamp, data.decided_ns.get(message.sequence, stamp))
        if data.states and data.states[-1].sequence == message.sequence:
            data.states[-1] = message
            return
        data.states.append(message)
        phase = Phase(message.phase)
        # Of HOLDING too it is the tick at which it was decided: there the capture was judged.
        time = {Phase.DEPLOYING: message.launch_time, Phase.CLOSING: message.closing_time}.get(
            phase, message.header.stamp
        )
        data.phases.append(PhaseChange(_nanoseconds(time), phase, shown(message.reason)))

    def _assessment(self, message: CaptureAssessment) -> None:
        data, stamp = self._data, _stamp(message)
        message = restore(message)
        message.verdict, message.predictor = shown(message.verdict), shown(message.predictor)
        # Series leaves out rows with NaN: where the quality cannot be measured, pairs are still worth a line.
        data.assessments.add(stamp, message.cqi if math.isfinite(message.cqi) else -1.0, message.locked_pairs)
        data.distances.add(stamp, message.net_debris_distance)
        if not hasattr(message, "enclosed"):
            data.lacks.add("enclosed")
        elif (inside := answer(message, "enclosed")) is not None:
            data.enclosure.add(stamp, float(inside), message.mcqi if math.isfinite(message.mcqi) else -1.0)
        if message.stage == 1:
            data.trigger = Assessment(stamp, message)
        elif message.stage == 2:
            data.final = Assessment(stamp, message)
        elif message.stage == 3:
            message.hold_verdict = shown(message.hold_verdict)
            data.hold = Assessment(stamp, message)

    def _net(self, message: NetState) -> None:
        stamp = _stamp(message)
        self._data.net_stamps.append(stamp)
        self._data.node_count = len(message.knot_positions) // 3
        self._data.net.add(stamp, *_xyz(message.center_of_mass))
        self._data.locked.add(stamp, float(np.count_nonzero(message.locked)))
        self._data.tether.add(stamp, message.tether_tension)
        if not hasattr(message, "load_share"):
            self._data.lacks.add("load_share")
        else:
            if message.load_share_valid:
                self._data.load_share.add(stamp, message.load_share)
            if message.contact_force_valid:
                self._data.contact.add(stamp, message.contact_force)
        positions = np.asarray(message.mu_positions, dtype=float)
        for mu in range(len(positions) // 3):
            self._data.truth.setdefault(mu + 1, Series(3)).add(stamp, *positions[3 * mu : 3 * mu + 3])

    @staticmethod
    def _body(series: Series, message: Odometry) -> None:
        turn = message.pose.pose.orientation
        series.add(_stamp(message), *_xyz(message.pose.pose.position), turn.x, turn.y, turn.z, turn.w)


def _nanoseconds(stamp: Time) -> int:
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def _date(stamp: Time, time_ns: int) -> None:
    """Set a stamp that nobody has set: the message was sent before its node knew the time, and others tell it."""
    if not _nanoseconds(stamp):
        stamp.sec, stamp.nanosec = divmod(time_ns, 1_000_000_000)


def _stamp(message: Any) -> int:
    return _nanoseconds(message.header.stamp)


def _xyz(point: Point | Vector3) -> tuple[float, float, float]:
    return point.x, point.y, point.z


def find_number(tree: Any, key: str) -> float | None:
    """The first number of this name in nested mappings."""
    if isinstance(tree, dict):
        value = tree.get(key)
        if isinstance(value, int | float) and value > 0:
            return float(value)
        for branch in tree.values():
            if (found := find_number(branch, key)) is not None:
                return found
    return None
