"""What is learned: where the debris may be, which offsets may be chosen, and how both are scaled (paper, Table I)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tethernet_core.mission import as_point
from tethernet_core.parameters import defaults
from tethernet_core.settings import MissionParameters
from tethernet_planner.inference import symmetry

_RULES = defaults(MissionParameters)
_XY_M, _NEAR_M, _FAR_M = (_RULES[name] for name in ("debris_bound_xy_m", "debris_near_m", "debris_far_m"))

DEBRIS_LOW_M = (-_XY_M, -_XY_M, -_FAR_M)
"""Lowest x, y, z of the debris at launch [m]."""

DEBRIS_HIGH_M = (_XY_M, _XY_M, -_NEAR_M)
"""Highest x, y, z of the debris at launch [m]: the mission's own bounds (mission.yaml)."""

OFFSET_LIMIT_M = 5.0
"""Largest offset of an aiming point from the nominal one, in x and in y [m]."""

STEP_M = 0.1
"""Debris positions and offsets are multiples of this [m]."""

SYMMETRIES = ("none", "diagonal")
"""none: the policy sees every debris position as it is [P]; diagonal: it sees the image in one quarter of the plane,
see :mod:`.symmetry`."""


def on_grid(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Values [m] rounded to the grid, any shape."""
    return np.round(np.round(np.asarray(values, float) / STEP_M) * STEP_M, 6) + 0.0  # no negative zeros


def inside(debris_position: npt.ArrayLike) -> bool:
    """Whether the debris is where policies are trained; rounding to the grid is forgiven."""
    position = np.asarray(debris_position, float)
    margin = STEP_M / 2
    return bool(
        (position >= np.subtract(DEBRIS_LOW_M, margin)).all() and (position <= np.add(DEBRIS_HIGH_M, margin)).all()
    )


def scale_observation(
    debris_position: npt.ArrayLike, symmetric: str = "none"
) -> tuple[npt.NDArray[np.float32], symmetry.Symmetry]:
    """What a policy sees.

    Args:
        debris_position: at launch [m].
        symmetric: one of SYMMETRIES.

    Returns:
        The position scaled to [-1, 1], float32, shape (3,), and the symmetry by which its answer is to be mapped back.
    """
    position, image = np.asarray(debris_position, float), symmetry.IDENTITY
    if symmetric == "diagonal":
        position, image = symmetry.canonical(position)
    low, high = np.array(DEBRIS_LOW_M), np.array(DEBRIS_HIGH_M)
    return np.clip(2.0 * (position - low) / (high - low) - 1.0, -1.0, 1.0).astype(np.float32), image


def offsets_from_action(action: npt.ArrayLike, image: symmetry.Symmetry = symmetry.IDENTITY) -> npt.NDArray[np.float64]:
    """The offsets that a policy's answer stands for.

    Args:
        action: (dx, dy) of each MU scaled to [-1, 1], shape (2 M,), clipped here.
        image: as :func:`scale_observation` gave it.

    Returns:
        Offsets on the grid [m], shape (M, 2).
    """
    offsets = OFFSET_LIMIT_M * np.clip(np.asarray(action, float), -1.0, 1.0).reshape(-1, 2)
    return on_grid(symmetry.image_of_offsets(image, offsets))


def random_debris_position(random: np.random.Generator) -> tuple[float, float, float]:
    """Uniform within the bounds, on the grid [m]."""
    return as_point(on_grid(random.uniform(DEBRIS_LOW_M, DEBRIS_HIGH_M)).tolist())
