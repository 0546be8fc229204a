"""A time step that is stable for a system and physical parameters, as near to the wanted one as the control allows."""

from __future__ import annotations

import math

from tethernet_core.settings import ControlParameters
from tethernet_core.system import System
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.stability import largest_step_of

_LARGEST_SHARE = 0.999
"""Of the largest stable step: the control period is a whole number of steps anyway."""


def stable_step_s(
    system: System, physics: PhysicsParameters, control: ControlParameters, wanted_s: float | None = None
) -> float:
    """The wanted step where it is stable; else the largest stable one that divides the control period [s].

    Args:
        system: that is flown.
        physics: its step is the wanted one if no other is given.
        control: gives the control period.
        wanted_s: the step to take if it is stable [s].
    """
    step_s = physics.time_step_s if wanted_s is None else wanted_s
    largest = _LARGEST_SHARE * largest_step_of(system, physics)
    if step_s > largest:
        step_s = control.control_period_s / math.ceil(control.control_period_s / largest)
    return step_s
