"""What the recorded series say: tracking errors, distances, thrust, fuel, how complete the recording is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from tethernet_bringup.analysis.mission_data import MissionData
from tethernet_bringup.analysis.series import Series
from tethernet_bringup.analysis.topic_count import TopicCount
from tethernet_bringup.bags.run_info import IDENTIFYING
from tethernet_core.mission import Phase
from tethernet_core.settings import NANOSECOND_S
from tethernet_ros import topics

SETTLED_S = 10.0
"""Errors are judged from so long after launch on [s]: before, the MUs are still catching up with the line."""
_GAP_FACTOR = 1.5
_NOT_NEEDED = (
    topics.CLOCK,
    topics.PLANNER_HEARTBEAT,
    topics.NET_MARKERS,
    topics.NET_POINTS,
    topics.TF,
    topics.SIM_STATUS,
    topics.DIAGNOSTICS,
)
"""Topics of a mission that say nothing which is not in others, too, or which is not looked at here."""


@dataclass(frozen=True)
class Curve:
    """Something over time; NaN where it is not defined."""

    time_s: np.ndarray  # (n,)
    value: np.ndarray  # (n,) or (n, 3)

    @property
    def known(self) -> bool:
        """Whether there is anything to see."""
        return bool(np.isfinite(self.value).any())


@dataclass(frozen=True)
class MuReport:
    """One MU in numbers; NaN where nothing is recorded."""

    mu: int
    fuel_kg: float
    fuel_at_trigger_kg: float
    max_error_m: float
    """Largest distance from the desired position, from 10 s after launch to the trigger."""
    rms_error_m: float
    max_closing_error_m: float
    """The same while closing; NaN for an MU that is off then."""
    saturated_share: float
    """Commands that reached a thrust limit."""
    impulse_n_s: float
    """Integral of the commanded thrust's magnitude."""
    deadline_misses: int | None


def curve(data: MissionData, series: Series) -> Curve:
    """A series over the time since launch, one column flattened."""
    stamps, values = series.sorted()
    return Curve(data.seconds(stamps), values[:, 0] if values.shape[1] == 1 else values)


def error_source(data: MissionData) -> str:
    """Which positions the errors are of."""
    return "true position" if data.truth else "measured position, with its sensor noise"


def tracking_error(data: MissionData, mu: int) -> Curve:
    """Distance between desired and actual position of an MU [m]; NaN while no position is desired.

    The true position is taken where a simulator told it, else the measured one. The plan is recorded a few times a
    second and made of straight lines, so that interpolating is exact but for the moment in which a line ends.
    """
    empty = Curve(np.zeros(0), np.zeros(0))
    if mu not in data.mus:
        return empty
    plan_stamps, plan = data.mus[mu].plan.sorted()
    stamps, positions = data.truth.get(mu, data.mus[mu].measured).sorted()
    if not len(plan_stamps) or not len(stamps):
        return empty
    desired = np.stack([np.interp(stamps, plan_stamps, plan[:, axis]) for axis in range(3)], axis=1)
    active = plan[np.clip(np.searchsorted(plan_stamps, stamps, side="right") - 1, 0, None), 3] > 0.5
    active &= (stamps >= plan_stamps[0]) & (stamps <= plan_stamps[-1])
    return Curve(data.seconds(stamps), np.where(active, np.linalg.norm(desired - positions, axis=1), np.nan))


def net_distance(data: MissionData) -> Curve:
    """Distance between the centres of mass of net and debris [m], by the net's state, else as the assessor saw it."""
    stamps, net = data.net.sorted()
    debris_stamps, debris = data.debris.sorted()
    if not len(stamps) or not len(debris_stamps):
        return curve(data, data.distances)
    there = np.stack([np.interp(stamps, debris_stamps, debris[:, axis]) for axis in range(3)], axis=1)
    return Curve(data.seconds(stamps), np.linalg.norm(net - there, axis=1))


def quality(data: MissionData) -> tuple[Curve, Curve]:
    """CQI (NaN where it could not be measured) and locked pairs (by the net's state, else as the assessor saw them)."""
    both = curve(data, data.assessments)
    cqi = np.where(both.value[:, 0] < 0.0, np.nan, both.value[:, 0])
    pairs = curve(data, data.locked) if len(data.locked) else Curve(both.time_s, both.value[:, 1])
    return Curve(both.time_s, cqi), pairs


def enclosure(data: MissionData) -> tuple[Curve, Curve]:
    """Whether the closed net goes round the whole debris (1 or 0), and the MCQI (NaN where it was not measured)."""
    both = curve(data, data.enclosure)
    if not len(both.time_s):
        return Curve(np.zeros(0), np.zeros(0)), Curve(np.zeros(0), np.zeros(0))
    mcqi = np.where(both.value[:, 1] < 0.0, np.nan, both.value[:, 1])
    return Curve(both.time_s, both.value[:, 0]), Curve(both.time_s, mcqi)


def thrust_curve(data: MissionData, mu: int) -> Curve:
    """Commanded force of an MU per axis [N]."""
    return curve(data, data.mus[mu].thrust)


def report(data: MissionData, mu: int) -> MuReport:
    """The numbers of one MU."""
    series = data.mus[mu]
    status = series.status
    error = tracking_error(data, mu)
    trigger_s = math.inf if data.closing_ns is None else float(data.seconds(data.closing_ns))
    flying = error.value[(error.time_s >= SETTLED_S) & (error.time_s < trigger_s)]
    closing = error.value[error.time_s >= trigger_s]
    saturated, commands = getattr(status, "saturated", 0), getattr(status, "commands", 0)
    return MuReport(
        mu=mu,
        fuel_kg=float(getattr(status, "fuel", math.nan)),
        fuel_at_trigger_kg=float(getattr(status, "fuel_at_trigger", math.nan)),
        max_error_m=_largest(flying),
        rms_error_m=float(np.sqrt(np.nanmean(flying**2))) if np.isfinite(flying).any() else math.nan,
        max_closing_error_m=_largest(closing),
        saturated_share=saturated / commands if commands else math.nan,
        impulse_n_s=_impulse(series.thrust),
        deadline_misses=getattr(status, "deadline_misses", None),
    )


def _largest(values: np.ndarray) -> float:
    return float(np.nanmax(values)) if np.isfinite(values).any() else math.nan


def _impulse(thrust: Series) -> float:
    """Each command holds until the next."""
    stamps, force = thrust.sorted()
    if len(stamps) < 2:
        return math.nan
    return float(np.sum(np.linalg.norm(force[:-1], axis=1) * np.diff(stamps)) * NANOSECOND_S)


@dataclass(frozen=True)
class TopicReport:
    """How completely a topic is recorded."""

    name: str
    type_name: str
    messages: int
    rate_hz: float
    """By the recorded times; NaN with fewer than two messages."""
    longest_gap_s: float
    gaps: int
    """Pauses of more than 1.5 times the usual one; only counted on topics with a regular beat."""
    never_arrived: int | None
    """Messages that the publisher counted and the recorder did not get; None where the recorder kept no counters."""


def topic_report(name: str, topic: TopicCount) -> TopicReport:
    """Count messages, gaps and losses of one topic."""
    steps = np.diff(np.unique(np.array(topic.times, dtype=np.int64))).astype(float) * NANOSECOND_S
    usual = float(np.median(steps)) if len(steps) else math.nan
    # Status and the like also come at every change: no beat, no gaps.
    regular = len(steps) > 10 and float(np.mean(np.isclose(steps, usual, rtol=0.2))) > 0.9
    return TopicReport(
        name=name,
        type_name=topic.type_name,
        messages=len(topic.times),
        rate_hz=1.0 / usual if len(steps) else math.nan,
        longest_gap_s=float(steps.max()) if len(steps) else math.nan,
        gaps=int((steps > _GAP_FACTOR * usual).sum()) if regular else 0,
        never_arrived=None if not topic.is_counted else 0 if topic.shared else topic.never_arrived,
    )


def phase_spans(data: MissionData) -> list[tuple[Phase, float, float, str]]:
    """Each phase with its beginning and end [s since launch] and the reason given for it."""
    if not data.phases:
        return []
    ends = [change.time_ns for change in data.phases[1:]] + [max(data.end_ns, data.phases[-1].time_ns)]
    return [
        (change.phase, float(data.seconds(change.time_ns)), float(data.seconds(end)), change.reason)
        for change, end in zip(data.phases, ends, strict=True)
    ]


def missing(data: MissionData) -> list[str]:
    """What the pictures and the table lack, one sentence each."""
    lacks = []
    mus = range(1, data.mu_count + 1)

    def without(what: str) -> list[int]:
        return [mu for mu in mus if mu not in data.mus or not len(getattr(data.mus[mu], what))]

    for what, topic, cost in (
        ("measured", "odom", "no path"),
        ("thrust", "thrust", "no thrust"),
        ("plan", "status", "no tracking error and no fuel"),
    ):
        numbers = without(what)
        if numbers:
            who = "any MU" if len(numbers) == len(mus) else "MU " + ", ".join(map(str, numbers))
            lacks.append(f"no /muN/{topic} of {who}: {cost}")
    for series, topic, cost in (
        (data.net, "/net/state", "the net is not drawn"),
        (data.debris, "/debris/odom", "the debris is not drawn"),
        (data.chaser, "/chaser/odom", "the chaser is not drawn"),
        (data.assessments, "/capture/assessment", "no capture quality and no verdict"),
        (data.states, "/mission/state", "no phases, times count from the first message"),
    ):
        if not len(series):
            lacks.append(f"no {topic}: {cost}")
    unused = [name for name in _NOT_NEEDED if name not in data.topics]
    if unused:
        lacks.append(f"no {', '.join(unused)}: nothing here needs {'it' if len(unused) == 1 else 'them'}")
    if not any(name in data.facts for name in IDENTIFYING):
        taken = f"the system is taken to be {data.system.name}" if data.system else "the system is not known"
        lacks.append(f"no facts about the run (policy, seed, parameters): {taken}")
    for name, topic, cost in (
        ("load_share", "/net/state", "no loads"),
        ("enclosed", "/capture/assessment", "no MCQI, not known whether the debris is enclosed or held"),
    ):
        if name in data.lacks:
            lacks.append(f"{topic} is of a version without {name}: {cost}")
    return lacks


def nonfinite(data: MissionData) -> list[str]:
    """Where NaN or infinite numbers were left out, one sentence each."""
    named: list[tuple[str, Any]] = [("/net/state", data.net), ("/debris/odom", data.debris)]
    for mu, series in sorted(data.mus.items()):
        named += [
            (f"/mu{mu}/odom", series.measured),
            (f"/mu{mu}/thrust", series.thrust),
            (f"/mu{mu}/status", series.plan),
        ]
    return [
        f"{name}: {series.nonfinite} messages with NaN or infinite numbers left out"
        for name, series in named
        if series.nonfinite
    ]
