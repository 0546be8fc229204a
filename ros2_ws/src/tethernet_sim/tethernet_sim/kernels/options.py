"""How the kernels are compiled and where the result is kept: one place."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import config

import tethernet_control
import tethernet_core

FAST = {"contract", "nsz", "arcp", "reassoc"}
"""Relaxed arithmetic that keeps NaN and infinity visible: a diverging run must be seen, not optimised away."""


def _sources() -> list[Path]:
    """Every file whose text ends up in compiled code."""
    kernels = Path(__file__).parent
    control, core = Path(tethernet_control.__path__[0]), Path(tethernet_core.__path__[0])
    return [
        *sorted(kernels.glob("*.py")),
        kernels.parent / "model.py",
        *(control / n for n in ("law.py", "law_numbers.py", "estimator.py")),
        *(core / n for n in ("rotation.py", "free_rotation.py")),
        *sorted((core / "shapes").glob("*.py")),
    ]


def _cache_folder() -> Path:
    """A folder of its own for each version of the sources.

    numba notices a change of the file that a compiled function is in, but not of the functions that were compiled
    into it from other files: it would go on with old physics.
    """
    version = hashlib.sha256()
    for source in _sources():
        version.update(source.read_bytes())
    version.update(f"{numba.__version__} {vars(config)['BOUNDSCHECK']}".encode())
    in_environment = sys.prefix != sys.base_prefix and os.access(sys.prefix, os.W_OK)
    base = Path(sys.prefix) / "share" if in_environment else Path.home() / ".cache"
    return base / "tethernet" / "numba" / version.hexdigest()[:16]


if not os.environ.get("NUMBA_CACHE_DIR"):
    config.CACHE_DIR = str(_cache_folder())  # type: ignore[attr-defined]  # numba reads it at each compilation


Function = TypeVar("Function", bound=Callable[..., Any])
"""A kernel is called as the function that it was compiled from."""

KERNEL: Any = {"fastmath": FAST, "error_model": "numpy", "nogil": True, "forceinline": True}
"""How a physics kernel is compiled.

It becomes part of each caller. Otherwise a caller has the choice between the function and a copy that was optimised
again, other in the last digit, and takes the one when it was just compiled and the other when it was loaded.
"""
INLINED: Any = KERNEL | {"_nrt": False}
"""How a kernel is compiled that allocates nothing: without counting references to its arrays.

numba counts the references of every array at every call; with some forty arrays in the calls of a step that costs as
much as the physics. Being part of the caller saves a tenth of a mission beside.
"""


def _compiled(function: Function, **options: Any) -> Function:
    dispatcher: Any = numba.njit(**options)(function)
    return dispatcher


def kernel(function: Function) -> Function:
    """Compile a physics kernel, see KERNEL; cached on disk, because compiling takes longer than a mission."""
    return _compiled(function, cache=True, **KERNEL)


def inlined(function: Function) -> Function:
    """Compile a kernel that allocates nothing, see INLINED."""
    return _compiled(function, cache=True, **INLINED)


def inlined_once(function: Function) -> Function:
    """Make a function part of its one caller before anything is compiled: for the largest, compiled once that way."""
    return _compiled(function, inline="always", fastmath=FAST, error_model="numpy")


def entry_point(function: Function) -> Function:
    """Compile a kernel that only Python calls."""
    return _compiled(function, cache=True, fastmath=FAST, error_model="numpy", nogil=True)


def ieee(function: Function) -> Function:
    """Compile with IEEE arithmetic: the same bits as the plain Python function."""
    return _compiled(function, cache=True, error_model="numpy", nogil=True)
