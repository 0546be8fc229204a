"""The parameters of control and of the mission's rules."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from tethernet_core.parameters import ParameterError, Shipped, field_types, load, parameter, read_yaml

_CONFIG = Path(__file__).parent / "config"
NANOSECOND_S = 1e-9
LONGEST_HOLD_S = 1000.0
"""Of a hold test [s]."""
HARDEST_TOW_N = 1000.0
"""Of the main tether's tension while it is towed with [N]."""


@dataclass(frozen=True)
class ControlParameters:
    """One MU's controller (paper, section II.C)."""

    FILE: ClassVar[Path] = _CONFIG / "control.yaml"

    control_period_s: float = parameter(
        "Period of sensing and command, 20 Hz in the paper", unit="s", low=0.01, high=1.0
    )
    deployment_time_s: float = parameter(
        "t_final of the straight line to the aiming point", unit="s", low=1.0, high=1000.0
    )
    kp: float = parameter("Proportional gain", unit="N/m", low=0.0, high=1e4)
    ki: float = parameter("Integral gain", unit="N/(m s)", low=0.0, high=1e4)
    kd: float = parameter("Derivative gain", unit="N s/m", low=0.0, high=1e4)
    standard_gravity_m_s2: float = parameter(
        "g0 of the fuel equation, as in the paper", unit="m/s^2", low=9.0, high=10.0
    )
    watchdog_periods: int = parameter(
        "Control periods after which odometry or a command is too old to act on", low=1, high=1000
    )
    longest_gap_s: float = parameter(
        "Stamps of one source are believed when they grow by no more than this; longer gaps and jumps only when "
        "clock_recovery_samples in succession agree. Longer than any dropout worth bridging, short beside a mission",
        unit="s",
        low=1.0,
        high=600.0,
    )
    clock_recovery_samples: int = parameter(
        "Successive stamps that agree among each other after which a clock counts as set anew; as many as the watchdog "
        "has patience for, so that one late burst is not enough", low=2, high=1000,
    )  # fmt: skip
    planner_timeout_s: float = parameter(
        "Mission time without heartbeat or news of the planner after which an MU in flight stops its thrust, until it "
        "is back; short beside a mission, long beside any halt of a busy chaser's computer",
        unit="s",
        low=0.5,
        high=600.0,
    )
    longest_flight_s: float = parameter(
        "Mission time since launch after which thrust is off for good, whatever the planner says; must be longer than "
        "give_up_s and capture_duration_s together", unit="s", low=2.0, high=3000.0,
    )  # fmt: skip
    position_sigma_m: float = parameter(
        "Standard deviation of a measured position per axis", unit="m", low=0.0, high=10.0
    )
    velocity_sigma_m_s: float = parameter(
        "Standard deviation of a measured velocity per axis", unit="m/s", low=0.0, high=10.0
    )
    plan_timeout_s: float = parameter(
        "Wall time to wait for the planner's service before the nominal points are taken", unit="s", low=0.0, high=600.0
    )
    estimator: str = parameter(
        "kalman: a Kalman filter on odometry, thrust as known input, the thread's pull as disturbance; "
        "raw: the samples as they come, the paper's baseline",
        choices=("kalman", "raw"),
    )
    velocity_noise: float = parameter(
        "Filter: unknown impulses on the velocity, threads that snap taut", unit="m/s/sqrt(s)", low=0.0, high=10.0
    )
    disturbance_noise: float = parameter(
        "Filter: how fast the thread's pull changes", unit="m/s^2/sqrt(s)", low=0.0, high=100.0
    )
    innovation_gate: float = parameter(
        "Filter: samples whose normalised innovation squared (chi-square, 6 degrees of freedom) is beyond are outliers",
        low=6.0, high=1e6,
    )  # fmt: skip
    ramp_time_s: float = parameter(
        "The reference gets up to speed over this time; 0: at once, as the paper's line does",
        unit="s",
        low=0.0,
        high=20.0,
    )
    follow_through_m: float = parameter(
        "How far beyond its aiming point an MU's reference goes on at its speed while closing has not begun; "
        "0: it stops there at deployment_time_s",
        unit="m",
        low=0.0,
        high=50.0,
    )
    feed_forward: bool = parameter("The derivative acts on the velocity's error; the paper's acts on the velocity")
    anti_windup: bool = parameter("The integral stands still while its axis is beyond the thrust limit")
    dead_band_n: float = parameter("Thrust below this per axis is not fired", unit="N", low=0.0, high=10.0)
    minimum_impulse_n_s: float = parameter(
        "Smallest impulse the thrusters can give in one control period; less is saved up", unit="N s", low=0.0, high=1.0
    )
    closing_law: str = parameter(
        "8 MUs: intercept: fly freely to where the MUs meet, corrected when it pays; "
        "track: the PID along a straight line to the closing point",
        choices=("intercept", "track"),
    )
    closing_coast_s: float = parameter(
        "intercept: thrusters off at first, while the net's own pull turns the MUs inwards",
        unit="s",
        low=0.0,
        high=10.0,
    )
    closing_turn_s: float = parameter(
        "intercept: thrusters off until so long after deployment_time_s too: before the mouth is as wide as it was "
        "aimed the MUs fly outwards, and the net turns them round for nothing",
        unit="s",
        low=0.0,
        high=10.0,
    )
    closing_dead_band_m_s: float = parameter(
        "intercept: velocity that may be missing before thrust is spent", unit="m/s", low=0.0, high=10.0
    )
    closing_response_s: float = parameter(
        "intercept: what is missing is gained over this time", unit="s", low=0.05, high=10.0
    )
    closing_shortest_s: float = parameter(
        "intercept: the time to go never counts as less", unit="s", low=0.1, high=10.0
    )
    closing_hold_kp: float = parameter(
        "intercept: spring to the meeting place once the MUs should have met", unit="N/m", low=0.0, high=1e4
    )
    closing_hold_kd: float = parameter("intercept: damper likewise", unit="N s/m", low=0.0, high=1e4)
    status_every: int = parameter("Control periods between two status messages when nothing changes", low=1, high=1000)

    @property
    def period_ns(self) -> int:
        """Control period [ns]: stamps of control ticks are exact multiples of it."""
        return round(self.control_period_s / NANOSECOND_S)

    @property
    def held_ns(self) -> int:
        """How long a command acts when none follows [ns]: it is zeroed at the first control tick at which it is older
        than the watchdog's patience.
        """
        return (self.watchdog_periods + 1) * self.period_ns


@dataclass(frozen=True)
class MissionParameters:
    """Rules of the mission: trigger, closing, end (paper, sections II.B and II.D)."""

    FILE: ClassVar[Path] = _CONFIG / "mission.yaml"

    trigger_distance_m: float = parameter(
        "Closing starts when the net's centre of mass is this near to the debris' one", unit="m", low=0.1, high=50.0
    )
    give_up_s: float = parameter(
        "Missed when the trigger has not come so long after launch", unit="s", low=1.0, high=1000.0
    )
    capture_duration_s: float = parameter("From the start of closing to the verdict", unit="s", low=1.0, high=1000.0)
    hold_s: float = parameter(
        "Hold test: the mission goes on so long after the verdict, units off, and says whether the debris is held; "
        "0: it ends with the verdict", unit="s", low=0.0, high=LONGEST_HOLD_S,
    )  # fmt: skip
    tow_n: float = parameter(
        "Hold test: the chaser thrusts away from the debris so that the main tether carries this tension once net and "
        "debris follow steadily; 0: it coasts", unit="N", low=0.0, high=HARDEST_TOW_N,
    )  # fmt: skip
    closing_plan: str = parameter(
        "8 MUs: planned: where the MUs meet is chosen from the debris' attitude and the net's reach; "
        "fixed: one place behind the debris' centre, as in the paper",
        choices=("planned", "fixed"),
    )
    plan_ahead_s: float = parameter(
        "planned: the plan is begun so long before the trigger is expected, and made in parts, one each control tick, "
        "10 ticks at most; where the trigger comes before it is whole, all of it is made at the trigger, and in real "
        "time the closing may begin late; 0: always so",
        unit="s", low=0.0, high=10.0,
    )  # fmt: skip
    closing_depth_m: float = parameter(
        "8 MUs, fixed, or nothing known of the debris' attitude: the MUs meet so far behind the debris' centre of mass",
        unit="m", low=0.0, high=50.0,
    )  # fmt: skip
    closing_duration_s: float = parameter(
        "8 MUs: time to fly to one meeting place for all", unit="s", low=1.0, high=100.0
    )
    group_duration_s: float = parameter(
        "8 MUs: time to fly to two meeting places, at most: less round a debris that turns",
        unit="s",
        low=1.0,
        high=100.0,
    )
    closing_slack_m: float = parameter(
        "planned: length of net that must be left at the meeting place, for folds and snags",
        unit="m",
        low=0.0,
        high=10.0,
    )
    tumbling_slack_m: float = parameter(
        "planned: so much more of it where the debris turns: its ends carry the net along", unit="m", low=0.0, high=10.0
    )
    closing_clearance_m: float = parameter(
        "planned: distance of a meeting place from the debris' surface", unit="m", low=0.0, high=10.0
    )
    ring_clearance_m: float = parameter(
        "planned: the same at most, where all meet at one place; farther away is cheap to fly to, but leaves the "
        "units' centre of mass far behind the debris'",
        unit="m", low=0.0, high=100.0,
    )  # fmt: skip
    place_gain: float = parameter(
        "planned: change of velocity that a unit may spend for each metre that one meeting place lies nearer, down to "
        "ring_clearance_m, or that two lie deeper behind the debris: the deeper, the more the net goes round",
        unit="1/s", low=0.0, high=10.0,
    )  # fmt: skip
    way_clearance_m: float = parameter(
        "planned: distance of the straight way there from the debris' surface", unit="m", low=0.0, high=10.0
    )
    regroup_period_s: float = parameter(
        "8 MUs: who has not docked in time flies to the last of its docking group, decided anew so often; 0: never",
        unit="s", low=0.0, high=100.0,
    )  # fmt: skip
    regroup_reach_m: float = parameter(
        "8 MUs: who is farther than this from the middle of its docking group by then is given up",
        unit="m",
        low=0.1,
        high=100.0,
    )
    off_course_m: float = parameter(
        "An MU that is so far from where it should be at the trigger is left out of the closing",
        unit="m",
        low=0.1,
        high=100.0,
    )
    release_docked: bool = parameter("8 MUs: a docking group that has docked switches its thrusters off")
    confirm_timeout_s: float = parameter(
        "Wall time to wait for the controllers to confirm a change of the mission's state", unit="s", low=0.0, high=60.0
    )
    launch_delay_s: float = parameter("From the newest odometry to the launch time", unit="s", low=0.0, high=60.0)
    debris_bound_xy_m: float = parameter(
        "Debris is planned for within this distance in x and in y", unit="m", low=0.0, high=100.0
    )
    debris_near_m: float = parameter(
        "Debris is planned for from this distance on, along -z", unit="m", low=1.0, high=1000.0
    )
    debris_far_m: float = parameter(
        "Debris is planned for up to this distance, along -z", unit="m", low=1.0, high=1000.0
    )

    def __post_init__(self) -> None:
        """Raises:
        ParameterError: for a tow without a hold test.
        """
        if self.tow_n > 0.0 and self.hold_s == 0.0:
            raise ParameterError(
                f"MissionParameters.tow_n = {self.tow_n:g} with hold_s = 0; allowed: hold_s above 0 too (--hold S), "
                "because the chaser tows while the hold is tested"
            )


def paper(cls: type[Shipped]) -> Shipped:
    """The parameters of ``cls`` as the paper prints them: its control is the baseline that ours is measured against."""
    return load(cls, paper_values(cls))


def paper_values(cls: type) -> dict[str, Any]:
    """Those parameters of ``cls`` that the paper prints."""
    printed = next(iter(read_yaml(_CONFIG / "paper.yaml").values()))
    return {name: value for name, value in printed.items() if name in field_types(cls)}
