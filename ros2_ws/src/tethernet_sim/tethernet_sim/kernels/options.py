"""How the kernels are compiled and where the result is kept: one place."""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path

import numba
from numba.core import config

import tethernet_control
import tethernet_core

FAST = {"contract", "nsz", "arcp", "reassoc"}
"""Relaxed arithmetic that keeps NaN and infinity visible: a diverging run must be seen, not optimised away."""


def _sources() -> list[Path]:
    """Every file whose text ends up in compiled code."""
    kernels = Path(__file__).parent
    control, core = Path(tethernet_control.__file__).parent, Path(tethernet_core.__file__).parent
    return [
        *sorted(kernels.glob("*.py")),
        kernels.parent / "model.py",
        *(control / n for n in ("law.py", "estimator.py")),
        core / "rotation.py",
    ]


def _cache_folder() -> Path:
    """A folder of its own for each version of the sources.

    numba notices a change of the file that a compiled function is in, but not of the functions that were compiled
    into it from other files: it would go on with old physics.
    """
    version = hashlib.sha256()
    for source in _sources():
        version.update(source.read_bytes())
    version.update(f"{numba.__version__} {config.BOUNDSCHECK}".encode())
    in_environment = sys.prefix != sys.base_prefix and os.access(sys.prefix, os.W_OK)
    base = Path(sys.prefix) / "share" if in_environment else Path.home() / ".cache"
    return base / "tethernet" / "numba" / version.hexdigest()[:16]


if not os.environ.get("NUMBA_CACHE_DIR"):
    config.CACHE_DIR = str(_cache_folder())


KERNEL = {"fastmath": FAST, "error_model": "numpy", "nogil": True, "forceinline": True}
"""How a physics kernel is compiled.

It becomes part of each caller. Otherwise a caller has the choice between the function and a copy that was optimised
again, other in the last digit, and takes the one when it was just compiled and the other when it was loaded.
"""
INLINED = KERNEL | {"_nrt": False}
"""How a kernel is compiled that allocates nothing: without counting references to its arrays.

numba counts the references of every array at every call; with some forty arrays in the calls of a step that costs as
much as the physics. Being part of the caller saves a tenth of a mission beside.
"""


def kernel(function):
    """Compile a physics kernel, see KERNEL; cached on disk, because compiling takes longer than a mission."""
    return numba.njit(cache=True, **KERNEL)(function)


def inlined(function):
    """Compile a kernel that allocates nothing, see INLINED."""
    return numba.njit(cache=True, **INLINED)(function)


def inlined_once(function):
    """Make a function part of its one caller before anything is compiled: for the largest, compiled once that way."""
    return numba.njit(inline="always", fastmath=FAST, error_model="numpy")(function)


def entry_point(function):
    """Compile a kernel that only Python calls."""
    return numba.njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)(function)


def ieee(function):
    """Compile with IEEE arithmetic: the same bits as the plain Python function."""
    return numba.njit(cache=True, error_model="numpy", nogil=True)(function)
