"""Whether the controllers acted on the planner's decisions when they should: closing, docked MUs, new meeting places.

What is decided on at one control tick holds from the next on. A controller that takes a decision over only after it has
answered that next tick acts late. All times are stamps of the mission: how busy the recording machine was does not
matter.
"""

from __future__ import annotations

from dataclasses import dataclass

from tethernet_bringup.analysis.mission_data import MissionData, find_number
from tethernet_core.mission import Mode, Phase
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters


@dataclass(frozen=True)
class ClosingStart:
    """When closing began."""

    trigger_s: float
    """The tick at which the net was near enough, since launch [s]."""
    ticks: dict[int, int]
    """Control ticks from there to the first one at which the MU's controller was closing (4 MUs: off), by MU."""

    @property
    def least(self) -> int:
        """Of the first MU [ticks]."""
        return min(self.ticks.values())

    @property
    def most(self) -> int:
        """Of the last MU [ticks]."""
        return max(self.ticks.values())


@dataclass(frozen=True)
class LateDecision:
    """A decision that reached a controller late."""

    sequence: int
    """Of the mission's state."""
    decided_ns: int
    """The tick that was decided on [ns]."""
    mu: int
    ticks: int
    """So many control ticks were answered without it that should not have been."""


def period_ns(data: MissionData) -> int:
    """The control period of the run [ns]: the parameters' own, else the default one."""
    period_s = find_number(data.parameters, "control_period_s")
    return round(period_s * 1e9) if period_s else load(ControlParameters).period_ns


def closing_start(data: MissionData) -> ClosingStart | None:
    """When closing began; None where it did not, or nobody reported it."""
    trigger_ns = next((data.decided_ns[state.sequence] for state in data.states if state.phase == Phase.CLOSING), None)
    if trigger_ns is None:
        return None
    began = {}
    for mu, series in sorted(data.mus.items()):
        first = [stamp for stamp, mode in series.modes if mode in (Mode.CLOSING, Mode.OFF) and stamp > trigger_ns]
        if first:
            began[mu] = round((min(first) - trigger_ns) / period_ns(data))
    return ClosingStart(float(data.seconds(trigger_ns)), began) if began else None


def late_decisions(data: MissionData) -> tuple[int, list[LateDecision]]:
    """What was decided on while closing.

    Returns:
        How many decisions were taken over, counted once for each controller, and those of them that were late.
    """
    count, late = 0, []
    for state in data.states:
        if state.phase != Phase.CLOSING:
            continue
        decided_ns = data.decided_ns[state.sequence]
        for mu, series in sorted(data.mus.items()):
            taken = [stamp for sequence, stamp in series.taken_over_ns.items() if sequence >= state.sequence]
            if not taken:
                continue
            count += 1
            behind = round((min(taken) - decided_ns) / period_ns(data))
            if behind > 0:
                late.append(LateDecision(state.sequence, decided_ns, mu, behind))
    return count, late


def delay_text(start: ClosingStart) -> str:
    """``1 tick``, or ``1 to 4 ticks`` from the first to the last MU."""
    if start.least == start.most:
        return f"{start.most} tick{'s' if start.most != 1 else ''}"
    return f"{start.least} to {start.most} ticks"
