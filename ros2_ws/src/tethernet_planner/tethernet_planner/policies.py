"""Policies by name: where the MUs shall aim, given where the debris is."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tethernet_core.errors import InputError
from tethernet_core.layout import FALLBACK, design, nominal_aiming_points
from tethernet_core.mission import Point, as_point
from tethernet_core.parameters import defaults
from tethernet_core.shown import SHORT, shown
from tethernet_planner.inference import shipped_models
from tethernet_planner.inference.model_file import ModelFileError, file_fingerprint
from tethernet_planner.inference.policy_file import AimingPolicy, OutsideTrainingError
from tethernet_planner.settings import PlannerParameters

Policy = Callable[[int, Point], list[Point]]
"""Number of MUs (4 or 8) and the debris' centre of mass [m] in; one aiming point [m] per MU out, MU 1 first."""

NOMINAL = "nominal"
"""The paper's Table II."""

RL = "rl"
"""The trained policy that is shipped for the number of MUs."""

HELP = "nominal, rl (the trained one that is shipped), or the path of a policy.safetensors; default %(default)s"
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


def check(name: str, mu_count: int) -> None:
    """Make sure that a policy can be used: that there is one, and a trained one can be loaded and fits.

    Args:
        name: a name, or the path of a policy's file.
        mu_count: 4 or 8.

    Raises:
        PolicyError: saying what is wrong and what is allowed.
    """
    if _trained(name):
        _model(name, mu_count)
    elif name not in _FACTORIES:
        raise PolicyError(
            f"no policy named {shown(repr(name), SHORT)}; allowed: {', '.join(names())}, "
            f"or the path of a policy{shipped_models.SUFFIX}"
        )


def plan(name: str, mu_count: int, debris_position: Point) -> Plan:
    """Ask a policy where the MUs shall aim. Where a trained one was never trained, the nominal points stand in.

    Args:
        name: of the policy, or the path of its file.
        mu_count: 4 or 8.
        debris_position: the debris' centre of mass [m], frame launch.

    Raises:
        PolicyError: when the policy is unknown, fails, or gives anything but one finite point for each MU.
        ValueError: for an unknown design.
    """
    expected = design(mu_count).mu_count
    check(name, mu_count)
    made_by, message = name, ""
    points: Sequence[tuple[float, ...]]
    try:
        points = _points(name, mu_count, debris_position)
    except OutsideTrainingError as error:
        made_by, message = FALLBACK, f"policy {name} was not trained for it ({error}): the nominal aiming points"
        points = nominal_aiming_points(mu_count, debris_position)
    except Exception as error:
        raise PolicyError(f"policy {name!r} failed: {type(error).__name__}: {error}") from error
    if len(points) != expected or not all(len(point) == 3 and math.isfinite(sum(point)) for point in points):
        raise PolicyError(f"policy {name!r} gave {points}; allowed: one finite x y z for each of {expected} MUs")
    return Plan([as_point(point) for point in points], made_by, message)


def aiming_points(name: str, mu_count: int, debris_position: Point) -> list[Point]:
    """The points of :func:`plan`."""
    return plan(name, mu_count, debris_position).points


def fingerprint(name: str, mu_count: int) -> str | None:
    """Short hash of a trained policy's file; None for a policy without one.

    Raises:
        PolicyError: when there is no such file.
    """
    return file_fingerprint(_file(name, mu_count)) if _trained(name) else None


def _trained(name: str) -> bool:
    return name == RL or (name not in _FACTORIES and shipped_models.means_file(name))


def _points(name: str, mu_count: int, debris_position: Point) -> list[tuple[float, ...]]:
    policy = _model(name, mu_count).aiming_points if _trained(name) else _loaded(name)
    return [tuple(float(value) for value in point) for point in policy(mu_count, debris_position)]


def _file(name: str, mu_count: int) -> Path:
    try:
        return shipped_models.find(shipped_models.POLICY, name, RL, mu_count)
    except FileNotFoundError as error:
        raise PolicyError(f"policy {shown(name, SHORT)}: {error}; {NOMINAL} needs none") from error


@functools.cache
def _model(name: str, mu_count: int) -> AimingPolicy:
    file = _file(name, mu_count)
    try:
        policy = AimingPolicy.load(file)
        policy.check_design(mu_count)
    except ModelFileError as error:
        raise PolicyError(f"policy {shown(name, SHORT)}: {error}") from error
    return policy


@functools.cache
def _loaded(name: str) -> Policy:
    return _FACTORIES[name]()
