"""The parameters of the supervisor: how long it waits, for what."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from tethernet_core.parameters import parameter


@dataclass(frozen=True)
class SupervisorParameters:
    """How the processes of a mission are started, watched and stopped. All times are wall time."""

    FILE: ClassVar[Path] = Path(__file__).parent / "config" / "supervisor.yaml"

    probe_s: float = parameter(
        "Look so long for another mission in the DDS domain before any node is started", unit="s", low=0.0, high=60.0
    )
    graph_timeout_s: float = parameter("Wait so long for all nodes to find each other", unit="s", low=1.0, high=600.0)
    compile_timeout_s: float = parameter(
        "Wait so long on top of that while the simulator says that it compiles its kernels, as it does once after an "
        "installation or a change", unit="s", low=0.0, high=3600.0,
    )  # fmt: skip
    launch_timeout_s: float = parameter(
        "Wait so long for the launch once the planner was told to start, besides its own waiting for the controllers",
        unit="s",
        low=1.0,
        high=600.0,
    )
    silence_timeout_s: float = parameter(
        "A mission of which nothing new is heard for so long has failed; waiting for a lost controller is not counted",
        unit="s", low=1.0, high=600.0,
    )  # fmt: skip
    verdict_timeout_s: float = parameter(
        "Wait so long for the verdict once the mission is over", unit="s", low=0.1, high=600.0
    )
    abort_timeout_s: float = parameter(
        "On Ctrl-C, wait so long for the planner to put the abort on record", unit="s", low=0.0, high=10.0
    )
    interrupt_patience_s: float = parameter(
        "From SIGINT to SIGTERM for every node but the recorder", unit="s", low=0.1, high=10.0
    )
    terminate_patience_s: float = parameter("From SIGTERM to SIGKILL", unit="s", low=0.1, high=10.0)
    recorder_patience_s: float = parameter(
        "From SIGINT to SIGTERM for the recorder, which has a bag to close; all patience together stays below the 6 s "
        "in which Ctrl-C ends a mission",
        unit="s", low=0.1, high=10.0,
    )  # fmt: skip
    hang_timeout_s: float = parameter(
        "A node that has answered nothing for so long hangs: the mission ends, or goes on without that controller; "
        "longer than any answer takes, a closing plan (0.1 s) on a machine that stalls for seconds included",
        unit="s", low=1.0, high=600.0,
    )  # fmt: skip
    driver_patience_s: float = parameter(
        "An external MU's driver has so long to put right before launch what breaks the driver contract",
        unit="s", low=1.0, high=600.0,
    )  # fmt: skip
    report_period_s: float = parameter(
        "Mission time between two lines of progress where no terminal shows them", unit="s", low=0.1, high=60.0
    )
