"""The parameters of the planner's and the assessor's nodes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from tethernet_core.mission import Point, as_point
from tethernet_core.parameters import ParameterError, parameter

_CONFIG = Path(__file__).parent / "config"

SYSTEM = "What is flown: name of a shipped system, or path of a description"

_SIMULATED = (
    "A simulator (or a net sensor) publishes the net's state and the debris' odometry. "
    "False: real units alone; the units' odometry stands in for the net's state"
)
_DEBRIS = (
    "Debris' centre of mass, x y z, frame launch, where nothing publishes its odometry; empty: it must be published"
)


def given_debris(position: tuple[float, ...]) -> Point | None:
    """The parameter ``debris_position`` as a point [m]; None where it is empty."""
    return as_point(position) if position else None


def _check_debris(instance: PlannerParameters | AssessorParameters) -> None:
    if len(instance.debris_position) not in (0, 3):
        raise ParameterError(
            f"{type(instance).__name__}.debris_position has {len(instance.debris_position)} numbers; "
            "allowed: 3 (x y z) or none"
        )


@dataclass(frozen=True)
class PlannerParameters:
    """The planner's node."""

    FILE: ClassVar[Path] = _CONFIG / "planner.yaml"

    system: str = parameter(SYSTEM)
    policy: str = parameter("Policy that makes the aiming points: nominal, rl (the shipped model), or a model's path")
    simulated: bool = parameter(_SIMULATED)
    debris_position: tuple[float, ...] = parameter(_DEBRIS, unit="m", low=-1000.0, high=1000.0)
    silence_timeout_s: float = parameter(
        "Wall time without any measurement in flight after which the mission is aborted, so that nothing hangs",
        unit="s",
        low=1.0,
        high=3600.0,
    )
    diagnostics_period_s: float = parameter(
        "Wall time between two messages on /diagnostics", unit="s", low=0.1, high=60.0
    )

    def __post_init__(self) -> None:
        _check_debris(self)


@dataclass(frozen=True)
class AssessorParameters:
    """The assessor's node."""

    FILE: ClassVar[Path] = _CONFIG / "assessor.yaml"

    system: str = parameter(SYSTEM)
    simulated: bool = parameter(_SIMULATED)
    debris_position: tuple[float, ...] = parameter(_DEBRIS, unit="m", low=-1000.0, high=1000.0)
    progress_every: int = parameter(
        "Control ticks between two progress reports; the capture quality costs some milliseconds", low=1, high=10000
    )
    predictor: str = parameter(
        "What predicts the outcome at the trigger: none, surrogate (the shipped model), or a model's path"
    )

    def __post_init__(self) -> None:
        _check_debris(self)
