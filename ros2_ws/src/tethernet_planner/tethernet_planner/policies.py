"""Policies by name: where the MUs shall aim, given where the debris is."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tethernet_core.aiming import FALLBACK, nominal_aiming_points
from tethernet_core.errors import InputError
from tethernet_core.mission import Point, as_point
from tethernet_core.parameters import defaults
from tethernet_core.shown import SHORT, shown
from tethernet_core.system import System
from tethernet_planner.inference import shipped_models
from tethernet_planner.inference.model_file import ModelFileError, file_fingerprint
from tethernet_planner.inference.policy_file import AimingPolicy, OutsideTrainingError
from tethernet_planner.settings import PlannerParameters

Policy = Callable[[System, Point], list[Point]]
"""System and the debris' centre of mass [m] in; one aiming point [m] per unit out, unit 1 first."""

NOMINAL = "nominal"
"""The paper's Table II."""

RL = "rl"
"""The trained policy that is shipped for the system."""

HELP = (
    "nominal, rl (the trained one that is shipped), or the path of a policy.safetensors; default rl where one is "
    "shipped for the system, else nominal"
)
"""For command lines."""


class PolicyError(InputError):
    """A policy is unknown, cannot be loaded, or gives no usable aiming points."""


@dataclass(frozen=True)
class Plan:
    """Aiming points, and who made them."""

    points: list[Point]
    """[m], MU 1 first."""
    policy: str
    """The policy that was asked, or FALLBACK."""
    message: str = ""
    """Why it was not the policy that was asked; empty when it was."""


_FACTORIES: dict[str, Callable[[], Policy]] = {NOMINAL: lambda: nominal_aiming_points}


def register(name: str, factory: Callable[[], Policy]) -> None:
    """Make a policy known by its name.

    Args:
        name: what users write after ``--policy``.
        factory: makes the policy; called when the policy is first used, so that what it needs (a model, torch) is
            loaded only then.

    Raises:
        PolicyError: when the name is taken.
    """
    if name in names():
        raise PolicyError(f"there is already a policy named {name!r}")
    _FACTORIES[name] = factory


def names() -> list[str]:
    """The names of all policies; besides them, every path of a policy's file is one."""
    return sorted([*_FACTORIES, RL])


def default() -> str:
    """The policy that is taken where none is named: the one of the planner's parameter file."""
    return str(defaults(PlannerParameters)["policy"])


def chosen(name: str | None, system: System) -> str:
    """The policy of a system: the one that is named; where none is, the default one, and the nominal points where that
    is a shipped one and none is shipped for the system.

    Args:
        name: of a policy; None where none was named.
        system: that is flown.
    """
    if name is not None:
        return name
    word = default()
    return NOMINAL if word == RL and not shipped_models.place(shipped_models.POLICY, system.name).is_file() else word


def check(name: str, system: System) -> None:
    """Make sure that a policy can be used: that there is one, and a trained one can be loaded and fits.

    Args:
        name: a name, or the path of a policy's file.
        system: that it is for.

    Raises:
        PolicyError: saying what is wrong and what is allowed.
    """
    if _trained(name):
        _model(name, system)
    elif name not in _FACTORIES:
        raise PolicyError(
            f"no policy named {shown(repr(name), SHORT)}; allowed: {', '.join(names())}, "
            f"or the path of a policy{shipped_models.SUFFIX}"
        )


def plan(name: str, system: System, debris_position: Point) -> Plan:
    """Ask a policy where the MUs shall aim. Where a trained one was never trained, the nominal points stand in.

    Args:
        name: of the policy, or the path of its file.
        system: that it is for.
        debris_position: the debris' centre of mass [m], frame launch.

    Raises:
        PolicyError: when the policy is unknown, fails, or gives anything but one finite point for each MU.
    """
    expected = system.unit_count
    check(name, system)
    made_by, message = name, ""
    points: Sequence[tuple[float, ...]]
    try:
        points = _points(name, system, debris_position)
    except OutsideTrainingError as error:
        made_by, message = FALLBACK, f"policy {name} was not trained for it ({error}): the nominal aiming points"
        points = list(nominal_aiming_points(system, debris_position))
    except Exception as error:
        raise PolicyError(f"policy {name!r} failed: {type(error).__name__}: {error}") from error
    if len(points) != expected or not all(len(point) == 3 and math.isfinite(sum(point)) for point in points):
        raise PolicyError(f"policy {name!r} gave {points}; allowed: one finite x y z for each of {expected} MUs")
    return Plan([as_point(point) for point in points], made_by, message)


def aiming_points(name: str, system: System, debris_position: Point) -> list[Point]:
    """The points of :func:`plan`."""
    return plan(name, system, debris_position).points


def fingerprint(name: str, system: System) -> str | None:
    """Short hash of a trained policy's file; None for a policy without one.

    Raises:
        PolicyError: when there is no such file.
    """
    return file_fingerprint(_file(name, system)) if _trained(name) else None


def _trained(name: str) -> bool:
    return name == RL or (name not in _FACTORIES and shipped_models.means_file(name))


def _points(name: str, system: System, debris_position: Point) -> list[tuple[float, ...]]:
    if _trained(name):
        points = _model(name, system).aiming_points(system, debris_position)
    else:
        points = _loaded(name)(system, debris_position)
    return [tuple(float(value) for value in point) for point in points]


def _file(name: str, system: System) -> Path:
    try:
        return shipped_models.find(shipped_models.POLICY, name, RL, system.name)
    except FileNotFoundError as error:
        raise PolicyError(f"policy {shown(name, SHORT)}: {error}; {NOMINAL} needs none") from error


@functools.cache
def _model(name: str, system: System) -> AimingPolicy:
    file = _file(name, system)
    try:
        policy = AimingPolicy.load(file)
        policy.check_system(system)
    except ModelFileError as error:
        raise PolicyError(f"policy {shown(name, SHORT)}: {error}") from error
    return policy


@functools.cache
def _loaded(name: str) -> Policy:
    return _FACTORIES[name]()
