"""What is known of units and debris when closing is planned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tethernet_core import rotation
from tethernet_core.free_rotation import attitude_after
from tethernet_core.settings import MissionParameters
from tethernet_core.system import System
from tethernet_planner.mouth import project_to_reachable


@dataclass(frozen=True)
class ClosingSituation:
    """What is known of units and debris at one moment; frame launch."""

    mu_positions: np.ndarray
    """[m], shape (M, 3), unit 1 first."""
    mu_velocities: np.ndarray
    """[m/s], shape (M, 3)."""
    debris_position: np.ndarray
    """Centre of mass [m], shape (3,)."""
    debris_velocity: np.ndarray
    """[m/s], shape (3,)."""
    debris_attitude: np.ndarray
    """Rotation matrix, body to launch, shape (3, 3)."""
    debris_rate: np.ndarray
    """Angular rate [rad/s], shape (3,)."""
    lost: tuple[bool, ...] = ()
    """Units that cannot be counted on, unit 1 first; empty: none."""


def closing_situation(
    mu_positions: Sequence[Sequence[float]] | np.ndarray,
    mu_velocities: Sequence[Sequence[float]] | np.ndarray,
    debris_position: Sequence[float],
    debris_attitude: Sequence[float],
    debris_linear: Sequence[float],
    debris_angular: Sequence[float],
    lost: Sequence[bool] = (),
) -> ClosingSituation:
    """What is known, from odometry as messages carry it; the one way to the numbers, so that all get the same bits.

    Args:
        mu_positions: [m], shape (M, 3), frame launch.
        mu_velocities: [m/s], shape (M, 3), frame launch.
        debris_position: [m], frame launch.
        debris_attitude: unit quaternion x y z w, body to launch.
        debris_linear: velocity in the body frame [m/s], as nav_msgs/Odometry has it.
        debris_angular: angular rate in the body frame [rad/s], likewise.
        lost: units that cannot be counted on; empty: none.
    """
    matrix = rotation.matrix(debris_attitude)
    return ClosingSituation(
        np.asarray(mu_positions, float),
        np.asarray(mu_velocities, float),
        np.asarray(debris_position, float),
        matrix @ np.asarray(debris_linear, float),
        matrix,
        matrix @ np.asarray(debris_angular, float),
        tuple(bool(value) for value in lost),
    )


def foreseen(seen: ClosingSituation, duration: float, system: System) -> ClosingSituation:
    """What will be seen after ``duration`` [s]: units and debris fly on as they do, the debris tumbles freely.

    Args:
        seen: what is known now.
        duration: [s].
        system: mass properties of the debris.
    """
    debris = system.debris
    attitude, rate = attitude_after(seen.debris_attitude, seen.debris_rate, debris.inertia, debris.mass_kg, duration)
    return replace(
        seen,
        mu_positions=seen.mu_positions + duration * seen.mu_velocities,
        debris_position=seen.debris_position + duration * seen.debris_velocity,
        debris_attitude=attitude,
        debris_rate=rate,
    )


def off_course(
    mu_positions: np.ndarray, aiming_points: np.ndarray, system: System, rules: MissionParameters
) -> tuple[bool, ...]:
    """Which units are lost, as far as their places at the trigger tell: far beside their aiming points, or far before
    or behind the others. None is lost that is only held back by a net too short for the points it was given.

    Args:
        mu_positions: [m], shape (M, 3).
        aiming_points: [m], shape (M, 3).
        system: gives the net's length.
        rules: gives the limit.
    """
    miss = np.asarray(mu_positions, float) - project_to_reachable(aiming_points, system)
    miss[:, 2] -= np.median(miss[:, 2])
    return tuple(bool(far) for far in np.linalg.norm(miss, axis=1) > rules.off_course_m)
