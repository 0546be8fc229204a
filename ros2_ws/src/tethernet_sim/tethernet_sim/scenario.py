"""A scenario in, an outcome out: the two ends of the in-process mission."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from tethernet_core.layout import design
from tethernet_core.mission import Point
from tethernet_core.parameters import build, defaults
from tethernet_sim.settings import ScenarioParameters

FAILURES = ("no_thrust", "stuck_thrust", "no_odometry")
"""What may happen to an MU: its thrusters are dead; its thrusters go on with what they were told last, whatever is
commanded; its odometry is gone."""


@dataclass(frozen=True)
class Failure:
    """The loss of one MU in flight."""

    mu: int
    """Its number, from 1."""
    kind: str
    """One of FAILURES."""
    time_s: float
    """After launch [s]; takes effect at the next control tick."""


@dataclass(frozen=True)
class Scenario:
    """One mission to fly. Whatever is not given comes from the default scenario (config/scenario.yaml)."""

    mus: int = field(default_factory=lambda: defaults(ScenarioParameters)["mu_count"])
    """4 or 8 MUs."""
    debris_position: Point = field(default_factory=lambda: tuple(defaults(ScenarioParameters)["debris_position"]))
    """The debris' centre of mass at launch [m], frame launch."""
    debris_attitude: tuple[float, float, float, float] = field(
        default_factory=lambda: tuple(defaults(ScenarioParameters)["debris_attitude"])
    )
    """Unit quaternion x y z w, debris body (long axis z) to launch."""
    debris_rate: Point = field(default_factory=lambda: tuple(defaults(ScenarioParameters)["debris_rate"]))
    """The debris' angular rate in its body frame [rad/s]."""
    seed: int = field(default_factory=lambda: defaults(ScenarioParameters)["seed"])
    """Seed of the sensor noise."""
    aiming_offsets: tuple[tuple[float, float], ...] | None = None
    """(dx, dy) of each MU's aiming point from the nominal one [m]; None for the nominal points."""
    failure: Failure | None = None
    """One MU that is lost in flight; None for a healthy swarm."""

    def __post_init__(self) -> None:
        """Raises:
        ValueError: naming the value and what is allowed.
        """
        build(
            ScenarioParameters,
            {
                **defaults(ScenarioParameters),
                "mu_count": self.mus,
                "debris_position": [float(x) for x in self.debris_position],
                "debris_attitude": [float(x) for x in self.debris_attitude],
                "debris_rate": [float(x) for x in self.debris_rate],
                "seed": int(self.seed),
            },
        )
        if self.aiming_offsets is not None:
            offsets = np.asarray(self.aiming_offsets, float)
            if offsets.shape != (self.mus, 2) or not np.isfinite(offsets).all():
                raise ValueError(f"aiming_offsets has shape {offsets.shape}; allowed: ({self.mus}, 2), finite, metres")

        lost = self.failure
        if lost is not None and (
            lost.mu not in range(1, self.mus + 1) or lost.kind not in FAILURES or not 0.0 <= lost.time_s < math.inf
        ):
            raise ValueError(
                f"failure = {lost}; allowed: mu from 1 to {self.mus}, kind one of {', '.join(FAILURES)}, "
                "time_s not negative"
            )

    def aiming_points(self) -> np.ndarray:
        """Aiming points of all MUs [m], shape (M, 3)."""
        points = np.empty((self.mus, 3))
        points[:] = self.debris_position
        points[:, :2] += design(self.mus).nominal_offsets
        if self.aiming_offsets is not None:
            points[:, :2] += self.aiming_offsets
        return points


@dataclass(frozen=True)
class Outcome:
    """What a mission came to; the names are those of outcome.json."""

    captured: bool
    verdict: str
    """One sentence."""
    cqi: float
    """Settled Capture Quality Index, the net's centre of mass that of its knots."""
    cqi_all: float = field(default=math.nan, kw_only=True)
    """The same with the MUs counted in the net's centre of mass."""
    locked_pairs: int
    trigger_time_s: float | None
    """Start of closing after launch [s]; None when the trigger never came."""
    end_time_s: float
    """When the capture was judged, after launch [s]."""
    fuel_kg: tuple[float, ...]
    """Per MU, launch to end [kg]."""
    fuel_at_trigger_kg: tuple[float, ...]
    """Per MU, launch to the start of closing [kg]."""
    mouth_area_m2: float | None
    """At the start of closing [m^2]."""
    net_debris_distance_m: float
    """Between the centres of mass at the end [m]."""
    max_tracking_error_m: float
    """Largest distance of any MU's estimated position, as its controller has it, from its desired one [m]."""
    seed: int
    mus: int
    error: str = ""
    """Why the simulation itself failed, if it did."""
    stopped_at_trigger: bool = False
    """Flown to the start of closing only: what the capture would have come to is not known."""
