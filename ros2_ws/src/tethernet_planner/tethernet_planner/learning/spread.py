"""Aiming offsets for data sets: from the nominal points to what misses the debris, so that a surrogate sees both."""

from __future__ import annotations

import numpy as np

from .task import OFFSET_LIMIT_M, on_grid

_SHARE_COMMON = {4: 0.35, 8: 0.65}
"""Scenarios in which all MUs aim beside the debris together: what makes captures with 8 MUs fail most. With 4 MUs it is
a mouth out of shape, past which the debris slips."""

_COMMON_M = 3.0
"""Largest common offset [m]: the net's centre of mass must come within 2.5 m of the debris', or closing never begins
and there is nothing to predict."""

_OWN_M = 3.5
"""Largest offset of an MU from the common one [m]."""


def random_offsets(random: np.random.Generator, mus: int) -> np.ndarray:
    """Offsets of the aiming points.

    In 35 % (4 MUs) or 65 % (8) of all scenarios an offset common to all MUs, up to 3 m in any direction, and one of
    each MU's own; in the others only one of each MU's own. How far the MUs' own ones go is drawn for each scenario, up
    to 3.5 m or, more often far than near, 5 m.

    Args:
        random: source of randomness.
        mus: number of MUs.

    Returns:
        On the grid, within 5 m [m], shape (M, 2).
    """
    common, spread = np.zeros(2), OFFSET_LIMIT_M * np.cbrt(random.random())
    if random.random() < _SHARE_COMMON[mus]:
        angle, spread = random.uniform(0.0, 2.0 * np.pi), random.uniform(0.0, _OWN_M)
        common = random.uniform(0.0, _COMMON_M) * np.array([np.cos(angle), np.sin(angle)])
    own = random.uniform(-spread, spread, (mus, 2))
    return on_grid(np.clip(common + own, -OFFSET_LIMIT_M, OFFSET_LIMIT_M))
