"""The parameters of the viewer's node."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from tethernet_core.parameters import parameter


@dataclass(frozen=True)
class ViewerParameters:
    """What is shown, where, how often, and how much memory it may take."""

    FILE: ClassVar[Path] = Path(__file__).parent / "config" / "viewer.yaml"

    output: str = parameter(
        "Where it is shown: address of a Rerun server (rerun+http://...), or path of an .rrd file; set by --view"
    )
    system: str = parameter("What is flown: name of a shipped system, or path of a description")
    rate_hz: float = parameter(
        "Most pictures a second of wall time; in lock-step, faster than real time, so some ticks are left out",
        unit="Hz", low=1.0, high=20.0,
    )  # fmt: skip
    memory_mb: int = parameter(
        "Most memory of the pictures kept by Rerun's window, or by its server for browsers: the oldest go first",
        unit="MB", low=100, high=100_000,
    )  # fmt: skip
