"""What a mission consists of: its processes, and how patient it is with them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tethernet_bringup.mission.supervisor import NodeProcess
from tethernet_bringup.mission.supervisor_settings import SupervisorParameters
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters
from tethernet_core.system import System

if TYPE_CHECKING:
    from tethernet_bringup.pulse import Answer


@dataclass(frozen=True)
class FlightPlan:
    """What is flown, and how."""

    processes: tuple[NodeProcess, ...]
    system: System
    external: tuple[int, ...]
    simulated: bool
    domain_id: int
    external_timeout_s: float
    parameters: SupervisorParameters
    control: ControlParameters = field(default_factory=lambda: load(ControlParameters))
    """The rhythm of control."""
    longest_s: float = math.inf
    """From launch to the end of the longest mission that the rules allow [s]."""
    protected: bool = True
    """Whether the middleware keeps what others publish from the nodes, see
    :mod:`tethernet_bringup.mission.dds_profile`.
    """
    ask_recorder: Callable[[], Answer | None] | None = None
    """Asks the recorder, which answers no services while it writes, for a sign of life."""
