"""A scenario in, an outcome out: the two ends of the in-process mission."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, overload

import numpy as np

from tethernet_core.mission import Point
from tethernet_core.parameters import build, defaults
from tethernet_core.system import System, load_system
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


class _DescribedSystem:
    """The field ``system`` of a scenario: given as a system, the name of a shipped one or a path, read as a system."""

    @overload
    def __get__(self, instance: None, owner: type) -> str: ...
    @overload
    def __get__(self, instance: Scenario, owner: type) -> System: ...
    def __get__(self, instance: Scenario | None, owner: type) -> System | str:
        return default_system() if instance is None else instance.__dict__["_system"]

    def __set__(self, instance: Scenario, value: System | str | Path) -> None:
        instance.__dict__["_system"] = described(value)


def default_system() -> str:
    """Name of the system that is flown where none is named: that of the default scenario."""
    return defaults(ScenarioParameters)["system"]


def described(system: System | str | Path) -> System:
    """The system itself, or that of a name or a path.

    Raises:
        DescriptionError: where there is none, or its description is wrong.
    """
    return system if isinstance(system, System) else load_system(system)


@dataclass(frozen=True)
class Scenario:
    """One mission to fly. Whatever is not given comes from the system's own parameters, and what those do not hold from
    the default scenario (config/scenario.yaml).
    """

    system: _DescribedSystem = _DescribedSystem()
    """What is flown: a system; also its name, if it is shipped, or the path of its description."""
    debris_position: Point = None  # type: ignore[assignment]  # __post_init__ gives it a value
    """The debris' centre of mass at launch [m], frame launch."""
    debris_attitude: tuple[float, float, float, float] = None  # type: ignore[assignment]  # __post_init__ gives it a value
    """Unit quaternion x y z w, debris body to launch."""
    debris_rate: Point = None  # type: ignore[assignment]  # __post_init__ gives it a value
    """The debris' angular rate in its body frame [rad/s]."""
    seed: int = None  # type: ignore[assignment]  # __post_init__ gives it a value
    """Seed of the sensor noise."""
    aiming_offsets: tuple[tuple[float, float], ...] | None = None
    """(dx, dy) of each unit's aiming point from the nominal one [m]; None for the nominal points."""
    failure: Failure | None = None
    """One unit that is lost in flight; None for a healthy swarm."""

    def __post_init__(self) -> None:
        """Raises:
        ValueError: naming the value and what is allowed.
        """
        own = {**defaults(ScenarioParameters), **self.system.parameters.get("scenario", {})}
        for name in ("debris_position", "debris_attitude", "debris_rate", "seed"):
            if getattr(self, name) is None:
                value = own[name]
                object.__setattr__(self, name, tuple(value) if isinstance(value, list) else value)
        build(
            ScenarioParameters,
            {
                **own,
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

    @property
    def mus(self) -> int:
        """Number of units."""
        return self.system.unit_count

    def record(self) -> dict[str, Any]:
        """All of it as JSON holds it, the system by name and digest."""
        failure = None if self.failure is None else asdict(self.failure)
        return {
            "system": self.system.name,
            "system_digest": self.system.digest,
            "mus": self.mus,
            "debris_position": self.debris_position,
            "debris_attitude": self.debris_attitude,
            "debris_rate": self.debris_rate,
            "seed": self.seed,
            "aiming_offsets": self.aiming_offsets,
            "failure": failure,
        }

    def aiming_points(self) -> np.ndarray:
        """Aiming points of all units [m], shape (M, 3)."""
        points = np.empty((self.mus, 3))
        points[:] = self.debris_position
        points[:, :2] += self.system.aiming.offsets
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
    """At the start of closing [m^2]; None where there was none, or where nothing spans the mouth."""
    net_debris_distance_m: float
    """Between the centres of mass at the end [m]."""
    max_tracking_error_m: float
    """Largest distance of any MU's estimated position, as its controller has it, from its desired one [m]; NaN
    without units.
    """
    seed: int
    mus: int
    """Number of units."""
    system: str = field(default="", kw_only=True)
    """Name of the system."""
    mcqi: float = field(default=math.nan, kw_only=True)
    """Modified Capture Quality Index at the verdict, see :mod:`tethernet_core.modified_quality`."""
    enclosed: bool | None = field(default=None, kw_only=True)
    """Whether the closed net goes round the whole debris at the verdict; None where the flight ended before."""
    held: bool | None = field(default=None, kw_only=True)
    """Whether it held, see :func:`tethernet_core.hold.held`; None without a hold test. False where the mission
    did not get as far.
    """
    hold_verdict: str | None = field(default=None, kw_only=True)
    """One sentence on that; None without a hold test."""
    hold_s: float = field(default=0.0, kw_only=True)
    """Length of the hold test [s]; 0 without one."""
    tow_n: float = field(default=0.0, kw_only=True)
    """Steady tension that the chaser towed with meanwhile [N]; 0: it coasted."""
    max_load_share: float = field(default=math.nan, kw_only=True)
    """Largest tension of a thread of net, units or main tether over its strength, launch to end, the hold test
    included [-]; looked at at every control tick, see :class:`tethernet_sim.loads.Loads`. NaN where no strength is
    known.
    """
    max_contact_force_n: float = field(default=math.nan, kw_only=True)
    """Largest contact force on the debris, mean over a control period [N]."""
    error: str = ""
    """Why the simulation itself failed, if it did."""
    stopped_at_trigger: bool = False
    """Flown to the start of closing only: what the capture would have come to is not known."""
