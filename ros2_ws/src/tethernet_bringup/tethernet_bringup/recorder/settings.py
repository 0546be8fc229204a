"""The parameters of the recorder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from tethernet_core.parameters import parameter


@dataclass(frozen=True)
class RecorderParameters:
    """What is recorded, where, and how much of it a kill may cost."""

    FILE: ClassVar[Path] = Path(__file__).parent / "config" / "recorder.yaml"

    output: str = parameter("Folder of the bag; made by the recorder, nothing is ever written over")
    system: str = parameter(
        "What is flown: name of a shipped system, or path of a description; the topics of its units are recorded"
    )
    run_info: str = parameter(
        "JSON file with facts about the run (seed, commit, parameters, model hashes) for the bag. Empty for none"
    )
    extra_topics: str = parameter("More topics: '/NAME PACKAGE/msg/TYPE [latched]', several with commas between them")
    take_period_s: float = parameter(
        "Wall time between two looks at the queues, which hold some seconds of messages: longer costs less CPU time",
        unit="s", low=0.001, high=0.5,
    )  # fmt: skip
    flush_period_s: float = parameter("Wall time of messages that kill -9 may cost", unit="s", low=0.05, high=60.0)
    chunk_bytes: int = parameter(
        "A chunk is written when it holds so much: bounds the memory, and what a damaged byte of the file costs",
        unit="B",
        low=1 << 10,
        high=1 << 24,
    )
    zstd_level: int = parameter(
        "Compression; above 1 it costs time and gains little on floating-point numbers", low=1, high=19
    )
    idle_s: float = parameter(
        "Asked to stop, it does so when nothing has come for so long", unit="s", low=0.0, high=10.0
    )
    drain_s: float = parameter(
        "Asked to stop, it does so after this time even under traffic", unit="s", low=0.0, high=10.0
    )
