"""The two MU designs: who hangs where, where they aim by default, and who docks with whom."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from tethernet_core.system import System, load_system

KNOT_ROWS = 23
"""Knots on a side of the net: 22 m at 1 m mesh (paper: 533 nodes = 529 knots + 4 corner MUs)."""

CORNER_THREAD_M = math.sqrt(2.0)
"""Corner knot to MU 1..4: the nominal corner aiming point lies (12 - 11) sqrt 2 beyond the corner knot [m]."""

SIDE_THREAD_M = 0.71
"""Middle knot of a side to MU 5..8: 11.71 - 11 [m]."""

_CORNER_M = 12.0
_SIDE_M = 11.71
_LAST = KNOT_ROWS - 1
_MIDDLE = KNOT_ROWS // 2

# Signs as in the paper's Table II, with its repeated entries for MU 4, 6 and 8 put right (see the package README).
_OFFSETS = (
    (-_CORNER_M, -_CORNER_M), (_CORNER_M, -_CORNER_M), (-_CORNER_M, _CORNER_M), (_CORNER_M, _CORNER_M),
    (0.0, -_SIDE_M), (_SIDE_M, 0.0), (-_SIDE_M, 0.0), (0.0, _SIDE_M),
)  # fmt: skip
_KNOTS = (
    (0, 0), (0, _LAST), (_LAST, 0), (_LAST, _LAST),
    (0, _MIDDLE), (_MIDDLE, _LAST), (_MIDDLE, 0), (_LAST, _MIDDLE),
)  # fmt: skip
_LENGTHS = (CORNER_THREAD_M,) * 4 + (SIDE_THREAD_M,) * 4


@dataclass(frozen=True)
class MuDesign:
    """One design of the net's actuation."""

    mu_count: int
    """Number of maneuverable units."""
    nominal_offsets: tuple[tuple[float, float], ...]
    """Nominal aiming points relative to the debris' centre of mass, x and y [m], one per MU (paper, Table II)."""
    knots: tuple[tuple[int, int], ...]
    """(row, column) of the knot each MU hangs on; rows run along y, columns along x."""
    thread_lengths: tuple[float, ...]
    """Length of the thread between knot and MU [m]."""
    closing_ring: tuple[int, ...]
    """MUs (from 1) in their order round the mouth; neighbours dock. Empty where winches close the net."""
    max_locked_pairs: int
    """N_L,max of the paper: 12 (4 MUs, closing nodes) or 8 (8 MUs, docked neighbours)."""
    required_locked_pairs: int
    """N_D of the paper: locked pairs that count as captured, 8 or 6."""

    @property
    def closes_by_docking(self) -> bool:
        """True where the MUs themselves close the mouth (8 MUs)."""
        return bool(self.closing_ring)


DESIGNS = {
    4: MuDesign(4, _OFFSETS[:4], _KNOTS[:4], _LENGTHS[:4], (), 12, 8),
    8: MuDesign(8, _OFFSETS, _KNOTS, _LENGTHS, (1, 5, 2, 6, 4, 8, 3, 7), 8, 6),
}
"""The designs by their number of MUs."""


def design(mu_count: int) -> MuDesign:
    """The design with ``mu_count`` MUs.

    Raises:
        ValueError: for any number other than 4 or 8.
    """
    try:
        return DESIGNS[mu_count]
    except KeyError:
        raise ValueError(
            f"no design with {mu_count!r} MUs; allowed: 4 (winches close the net) or 8 (the MUs dock)"
        ) from None


def system_of(mu_count: int) -> System:
    """The shipped system of the design with ``mu_count`` MUs.

    Raises:
        ValueError: for any number other than 4 or 8.
    """
    return load_system(f"zenit_{design(mu_count).mu_count}mu")


def nominal_aiming_points(mu_count: int, debris_position: Iterable[float]) -> list[tuple[float, float, float]]:
    """Nominal aiming points of all MUs.

    Args:
        mu_count: 4 or 8.
        debris_position: the debris' centre of mass, x y z [m], frame launch.

    Returns:
        One (x, y, z) [m] per MU, MU 1 first, in the plane z = z_D (paper, Table II).

    Raises:
        ValueError: for an unknown design.
    """
    x, y, z = (float(value) for value in debris_position)
    return [(x + dx, y + dy, z) for dx, dy in design(mu_count).nominal_offsets]
