"""The distance functions of all shapes, compiled: ``tethernet_core.shapes`` writes them down."""

from __future__ import annotations

import math
from typing import Any

from numba.extending import overload

from tethernet_core.shapes import arithmetic, surface_functions
from tethernet_sim.kernels.options import INLINED, inlined

KINDS: dict[str, int] = {kind: number for number, kind in enumerate(surface_functions())}
"""The number that stands for a shape in a table."""


# What the formulae are written with, for single numbers and without branches, so that loops vectorise.
@overload(arithmetic.select, jit_options=INLINED)
def _select(condition, yes, no):
    def serve(condition, yes, no):
        return yes if condition else no

    return serve


@overload(arithmetic.larger, jit_options=INLINED)
def _larger(a, b):
    def serve(a, b):
        return max(a, b)

    return serve


@overload(arithmetic.smaller, jit_options=INLINED)
def _smaller(a, b):
    def serve(a, b):
        return min(a, b)

    return serve


@overload(arithmetic.magnitude, jit_options=INLINED)
def _magnitude(a):
    def serve(a):
        return abs(a)

    return serve


@overload(arithmetic.root, jit_options=INLINED)
def _root(a):
    def serve(a):
        return math.sqrt(a)

    return serve


@overload(arithmetic.whole, jit_options=INLINED)
def _whole(a):
    def serve(a):
        return math.floor(a)

    return serve


COMPILED = {kind: inlined(function) for kind, function in surface_functions().items()}
"""``surface`` of each kind."""


def surface_of_kind(kind: int, p: Any, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Signed distance and normal of the shape that ``kind`` stands for in KINDS; compiled code only.

    Args:
        kind: of the shape.
        p: its numbers.
        x: of the point in the shape's frame [m].
        y: of the point [m].
        z: of the point [m].
    """
    raise NotImplementedError


@overload(surface_of_kind, jit_options=INLINED)
def _surface_of_kind(kind, p, x, y, z):
    # One branch for each shape file there is: numba wants them spelled out.
    lines = ["def serve(kind, p, x, y, z):"]
    lines += [f"    if kind == {KINDS[name]}:\n        return {name}(p, x, y, z)" for name in KINDS]
    lines += ["    return 1e3, 0.0, 0.0, 1.0"]
    namespace: dict[str, Any] = dict(COMPILED)
    exec("\n".join(lines), namespace)
    return namespace["serve"]
