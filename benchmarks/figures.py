"""What all benchmarks share: the machine in words, rounding, the last line."""

from __future__ import annotations

import json
import math
import os
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

_DIGITS = 4


def machine() -> str:
    """Processor, usable cores and versions, in one line."""
    import numba
    import numpy as np

    return (
        f"{_processor()}, {cores()} cores; Python {platform.python_version()}, numpy {np.__version__}, "
        f"numba {numba.__version__}"
    )


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def conclude(benchmark: str, figures: Mapping[str, Any]) -> None:
    """Print the result, one line of JSON, which ends every benchmark.

    Args:
        benchmark: its name.
        figures: numbers by name, units in the names; null stands for what was not measured.
    """
    print(json.dumps({"benchmark": benchmark} | {name: _rounded(value) for name, value in figures.items()}), flush=True)


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None
    return value


def _processor() -> str:
    try:
        with Path("/proc/cpuinfo").open(encoding="utf-8") as file:
            return next(line.split(":", 1)[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.machine()
