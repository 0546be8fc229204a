"""What a driver of an MU must keep, as checks on what was seen of it; without ROS. The text: the package README."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from tethernet_core.rotation import NORM_TOLERANCE, turned, unit
from tethernet_core.settings import ControlParameters

_RATE_TOLERANCE = 0.1  # [-] of the rate
_REACTION_TOLERANCE = 0.25  # [-] of the change of velocity
_LONGEST_NAME, _MOST_NAMES = 80, 5  # of what is shown of frames
_AVERAGED = 10
"""Samples averaged for one velocity, so that sensor noise does not decide."""


@dataclass(frozen=True)
class Sample:
    """One odometry message of the driver."""

    arrival_s: float
    """Wall time of arrival [s]."""
    stamp_ns: int
    frame: str
    child_frame: str
    position: tuple[float, float, float]
    """[m]."""
    attitude: tuple[float, float, float, float]
    """Quaternion x y z w."""
    velocity: tuple[float, float, float]
    """[m/s], child frame, as it came."""
    pose_variances: tuple[float, float, float]
    """Diagonal of the position's covariance [m^2]."""
    twist_variances: tuple[float, float, float]
    """Diagonal of the velocity's covariance [m^2/s^2]."""
    clock_ns: int | None = None
    """What the mission's clock showed when it arrived [ns]; None where that is not known."""

    @property
    def launch_velocity(self) -> tuple[float, float, float]:
        """[m/s], frame launch: turned by the attitude as controllers turn it; NaN where that is none."""
        try:
            return turned(unit(self.attitude), self.velocity)
        except ValueError:
            return (math.nan,) * 3

    @property
    def age_ns(self) -> int | None:
        """How old it was on the mission's clock when it arrived [ns]; None where that is not known."""
        return None if self.clock_ns is None else self.clock_ns - self.stamp_ns


@dataclass(frozen=True)
class Finding:
    """One line of the table."""

    requirement: str
    passed: bool
    seen: str
    vital: bool = True
    """Whether no mission is launched without it."""


def obstacle(mu: int, samples: Sequence[Sample], frame: str, control: ControlParameters, waiting: bool) -> str:
    """Why an MU with such odometry cannot be launched; empty when it can.

    Args:
        mu: number of the MU.
        samples: the newest, in the order of their arrival, at least one.
        frame: the frame the odometry must be in.
        control: gives the control period.
        waiting: whether the mission's clock waits for the launch, as a simulator's does: then there is no rate, and
            one sample is enough.
    """
    if waiting:
        samples = samples[-1:]
    findings = [*_content(mu, samples, frame), *_agreement(samples, control)]
    if not waiting:
        findings += _rhythm(samples, control)
    return "; ".join(f"{f.requirement}: seen {f.seen}" for f in findings if f.vital and not f.passed)


def check_samples(mu: int, samples: Sequence[Sample], frame: str, control: ControlParameters) -> list[Finding]:
    """Everything that can be said without moving the MU.

    Args:
        mu: number of the MU.
        samples: in the order of their arrival.
        frame: the frame the odometry must be in.
        control: gives control period and watchdog.
    """
    if len(samples) < 2:
        return [Finding(f"odometry arrives on /mu{mu}/odom", False, f"{len(samples)} messages")]
    return [*_rhythm(samples, control), *_agreement(samples, control), *_content(mu, samples, frame)]


def _rhythm(samples: Sequence[Sample], control: ControlParameters) -> list[Finding]:
    """How the samples follow each other."""
    first, last = samples[0], samples[-1]
    wanted_hz = 1.0 / control.control_period_s
    arrived_hz = (len(samples) - 1) / max(last.arrival_s - first.arrival_s, 1e-9)
    steps = [later.stamp_ns - earlier.stamp_ns for earlier, later in pairwise(samples)]
    monotone = min(steps) > 0
    stamped_hz = (len(samples) - 1) * 1e9 / (last.stamp_ns - first.stamp_ns) if monotone else math.nan
    longest_s = max(steps) * 1e-9
    return [
        Finding(
            f"rate on the wall clock {wanted_hz:g} Hz within {_RATE_TOLERANCE:.0%}",
            _near(arrived_hz, wanted_hz, _RATE_TOLERANCE),
            f"{arrived_hz:.2f} Hz",
            vital=False,  # a machine that is busy while a dozen nodes start delays what comes in good order
        ),
        Finding(
            f"rate by the stamps {wanted_hz:g} Hz within {_RATE_TOLERANCE:.0%}",
            _near(stamped_hz, wanted_hz, _RATE_TOLERANCE),
            f"{stamped_hz:.2f} Hz",
        ),
        Finding("stamps grow from message to message", monotone, f"smallest step {min(steps) * 1e-6:.1f} ms"),
        Finding(
            f"no gap of {control.watchdog_periods} periods or more",
            longest_s < control.watchdog_periods * control.control_period_s,
            f"longest step {longest_s * 1e3:.0f} ms",
        ),
    ]


def _agreement(samples: Sequence[Sample], control: ControlParameters) -> list[Finding]:
    """Whether the driver's clock is the mission's; judged by the sample that was held up least on its way."""
    ages = [sample.age_ns for sample in samples if sample.age_ns is not None]
    if not ages:
        return []
    age_s = min(ages) * 1e-9
    limit_s = control.control_period_s
    return [
        Finding(
            f"stamps agree with the mission's clock within {limit_s * 1e3:g} ms",
            abs(age_s) <= limit_s,
            f"{abs(age_s):.3f} s {'behind' if age_s > 0.0 else 'ahead'}",
        )
    ]


def _content(mu: int, samples: Sequence[Sample], frame: str) -> list[Finding]:
    """What each sample says."""
    broken = [s for s in samples if not all(map(math.isfinite, (*s.position, *s.velocity, *s.attitude)))]
    norms = [math.sqrt(sum(q * q for q in s.attitude)) for s in samples]
    worst_norm = max(norms, key=lambda norm: abs(norm - 1.0) if math.isfinite(norm) else math.inf)
    variances = [v for s in samples for v in (*s.pose_variances, *s.twist_variances)]
    frames, children = {s.frame for s in samples}, {s.child_frame for s in samples}
    return [
        Finding(f"header.frame_id is {frame!r}", frames == {frame}, _listed(frames)),
        Finding(f"child_frame_id is 'mu{mu}'", children == {f"mu{mu}"}, _listed(children)),
        Finding("all numbers finite", not broken, f"{len(broken)} of {len(samples)} messages are not"),
        Finding("attitude is a unit quaternion", abs(worst_norm - 1.0) <= NORM_TOLERANCE, f"norm {worst_norm:.6g}"),
        Finding(
            "variances of position and velocity filled",
            all(math.isfinite(v) and v > 0.0 for v in variances),
            f"{min(variances):.3g} to {max(variances):.3g}",
            vital=False,  # controllers do not look at them
        ),
    ]


def _listed(names: Iterable[str]) -> str:
    return ", ".join(repr(name[:_LONGEST_NAME]) for name in sorted(names)[:_MOST_NAMES])


@dataclass(frozen=True)
class Reaction:
    """The test of one axis: push, push back while saying nonsense, let go."""

    axis: int
    """0, 1, 2 for x, y, z."""
    thrust_n: float
    """Commanded [N]."""
    before: Sequence[Sample]
    """Before the push."""
    pushed: Sequence[Sample]
    """While the thrust was commanded: the first answer to the last."""
    silent: Sequence[Sample]
    """After the last command: nothing more was said."""


def check_reaction(reaction: Reaction, mass_kg: float, control: ControlParameters) -> list[Finding]:
    """Whether thrust moves the MU as it should, and stops when nobody commands any more.

    Args:
        reaction: what was seen.
        mass_kg: of the MU.
        control: gives period and watchdog.
    """
    name = "xyz"[reaction.axis]
    if len(reaction.pushed) < 2 or len(reaction.silent) < _AVERAGED or not reaction.before:
        return [Finding(f"thrust along {name} is answered", False, "too few messages to tell")]
    acceleration = reaction.thrust_n / mass_kg
    start = _velocity(reaction.before[-_AVERAGED:], reaction.axis)
    settled = _velocity(reaction.silent[-_AVERAGED:], reaction.axis)
    # The last command acts until the watchdog lets go of it.
    pushed_s = (reaction.pushed[-1].stamp_ns - reaction.pushed[0].stamp_ns) * 1e-9
    held_s = control.watchdog_periods * control.control_period_s
    expected = acceleration * (pushed_s + held_s)
    slack = _REACTION_TOLERANCE * abs(expected) + abs(acceleration) * 2 * control.control_period_s
    half = len(reaction.silent) // 2
    early = _velocity(reaction.silent[half : half + _AVERAGED], reaction.axis)
    noise = 4.0 * max(
        math.sqrt(statistics.fmean(max(s.twist_variances) for s in reaction.silent)) / math.sqrt(_AVERAGED),
        1e-6,
    )
    others = [
        abs(_velocity(reaction.silent[-_AVERAGED:], axis) - _velocity(reaction.before[-_AVERAGED:], axis))
        for axis in range(3)
        if axis != reaction.axis
    ]
    return [
        Finding(
            f"{reaction.thrust_n:g} N along {name} for {pushed_s:.2f} s, then silence: {expected:.2f} m/s faster",
            abs(settled - start - expected) <= slack,
            f"{settled - start:.2f} m/s",
        ),
        Finding(
            f"silence for more than {control.watchdog_periods} periods: thrust along {name} is zero",
            abs(settled - early) <= noise + 0.05 * abs(expected),
            f"velocity still changes by {settled - early:.3f} m/s",
        ),
        Finding(
            f"thrust along {name} moves nothing else",
            max(others) <= noise + 0.1 * abs(expected),
            f"{max(others):.3f} m/s along another axis",
        ),
    ]


def table(findings: Sequence[Finding]) -> str:
    """The findings as text, one line each."""
    width = max(len(finding.requirement) for finding in findings)
    return "\n".join(f"{'pass' if f.passed else 'FAIL'}  {f.requirement:<{width}}  {f.seen}" for f in findings)


def _velocity(samples: Sequence[Sample], axis: int) -> float:
    return statistics.fmean(sample.launch_velocity[axis] for sample in samples)


def _near(value: float, wanted: float, tolerance: float) -> bool:
    return abs(value - wanted) <= tolerance * wanted
