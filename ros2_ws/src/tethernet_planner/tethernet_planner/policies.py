"""Policies by name: where the MUs shall aim, given where the debris is."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

from tethernet_control.layout import design, nominal_aiming_points

Point = tuple[float, float, float]
Policy = Callable[[int, Point], list[Point]]
"""Number of MUs (4 or 8) and the debris' centre of mass [m] in; one aiming point [m] per MU out, MU 1 first."""

NOMINAL = "nominal"


class PolicyError(ValueError):
    """A policy is unknown, cannot be loaded, or gives no usable aiming points."""


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
    if name in _FACTORIES:
        raise PolicyError(f"there is already a policy named {name!r}")
    _FACTORIES[name] = factory


def names() -> list[str]:
    """The names of all policies."""
    return sorted(_FACTORIES)


def check(name: str) -> None:
    """Make sure that there is a policy with this name, without loading it.

    Raises:
        PolicyError: naming the allowed ones.
    """
    if name not in _FACTORIES:
        raise PolicyError(f"no policy named {name!r}; allowed: {', '.join(names())}")


def aiming_points(name: str, mu_count: int, debris_position: Point) -> list[Point]:
    """Ask a policy where the MUs shall aim.

    Args:
        name: of the policy.
        mu_count: 4 or 8.
        debris_position: the debris' centre of mass [m], frame launch.

    Returns:
        One point [m] per MU, MU 1 first.

    Raises:
        PolicyError: when the policy is unknown, fails, or gives anything but one finite point for each MU.
        ValueError: for an unknown design.
    """
    check(name)
    expected = design(mu_count).mu_count
    try:
        points = [tuple(float(value) for value in point) for point in _loaded(name)(mu_count, debris_position)]
    except Exception as error:
        raise PolicyError(f"policy {name!r} failed: {type(error).__name__}: {error}") from error
    if len(points) != expected or not all(len(point) == 3 and math.isfinite(sum(point)) for point in points):
        raise PolicyError(f"policy {name!r} gave {points}; allowed: one finite x y z for each of {expected} MUs")
    return points


@functools.cache
def _loaded(name: str) -> Policy:
    return _FACTORIES[name]()
