"""Aiming offsets for data sets: from the nominal points to what misses the debris, so that a surrogate sees both."""

from __future__ import annotations

import numpy as np

from tethernet_core.layout import design
from tethernet_planner.inference.task import OFFSET_LIMIT_M, on_grid

SHARES = {4: {"narrow": 0.4, "beside": 0.45, "torn": 0.15}, 8: {"narrow": 0.3, "beside": 0.5, "torn": 0.2}}
"""Of all scenarios, by number of MUs and kind. narrow: where a policy that saves fuel will aim; captures that succeed,
told apart by their fuel. beside: all MUs aim beside the debris together; most of what fails, because the net's centre
of mass must come within 2.5 m of the debris' or closing never begins. torn: a mouth out of shape, the MUs' own offsets
as large as actions may be."""

_NARROW = {4: (0.0, 0.45), 8: (-0.05, 0.25)}
"""Narrow: least and largest part of the way from the nominal points to the middle, by number of MUs. With 4 MUs fuel is
least at 0.3; with 8, whose closing wants a flat net, at the nominal points."""

_NARROW_OWN_M = 2.0
"""Narrow: largest offset of an MU of its own [m]."""

_BESIDE_M = 5.0
"""Beside: largest common offset [m]; from about 2.5 m on closing does not begin."""

_BESIDE_OWN_M = 3.5
"""Beside: largest offset of an MU from the common one [m]."""

_TORN_M = 4.0
"""Torn: the MUs' own offsets go at least so far, at most to the limit [m]."""


def random_offsets(random: np.random.Generator, mus: int) -> np.ndarray:
    """Offsets of the aiming points, of a kind drawn by SHARES.

    Args:
        random: source of randomness.
        mus: number of MUs.

    Returns:
        On the grid, within 5 m [m], shape (M, 2).
    """
    shares = SHARES[mus]
    kind = random.choice(list(shares), p=list(shares.values()))
    if kind == "narrow":
        common = -random.uniform(*_NARROW[mus]) * np.array(design(mus).nominal_offsets)
        own_limit = random.uniform(0.0, _NARROW_OWN_M)
    elif kind == "beside":
        angle = random.uniform(0.0, 2.0 * np.pi)
        common = random.uniform(0.0, _BESIDE_M) * np.array([np.cos(angle), np.sin(angle)])
        own_limit = random.uniform(0.0, _BESIDE_OWN_M)
    else:
        common, own_limit = np.zeros(2), random.uniform(_TORN_M, OFFSET_LIMIT_M)
    own = random.uniform(-own_limit, own_limit, (mus, 2))
    return on_grid(np.clip(common + own, -OFFSET_LIMIT_M, OFFSET_LIMIT_M))
