"""Numbers that grow from message to message, stamps and sequences: which of them to believe. No ROS."""

from __future__ import annotations

import enum

from tethernet_core.settings import NANOSECOND_S, ControlParameters


class Step(enum.Enum):
    """What a number is to those before it."""

    NEXT = "next"
    """Newer, by no more than one step may be: or the first of all."""
    OLD = "old"
    """Not newer, but no farther back than one step: repeated, or out of order."""
    JUMP = "jump"
    """Farther off than one step may be, either way."""
    ANEW = "anew"
    """Off like those just before it, which agree among each other: the source counts anew, from here on."""

    @property
    def good(self) -> bool:
        """True when the number is the newest now."""
        return self in (Step.NEXT, Step.ANEW)


class StepGuard:
    """Lets numbers of one source pass that grow in bounded steps.

    A single number that is off would otherwise silence its source for good, since all that follow are older than it.
    What is off is dropped and counted; only when enough of them in succession grow in bounded steps among themselves,
    and nothing else has come in between, has the source really been set to another count.
    """

    def __init__(self, longest_step: int, recover_after: int):
        """Args:
        longest_step: largest believable difference of two successive numbers.
        recover_after: successive numbers off the count, but agreeing, that make a new count.
        """
        self.newest: int | None = None
        """The newest number that was believed."""
        self.jumps = 0
        """Numbers that were dropped because they were farther off than one step."""
        self._longest, self._recover_after = longest_step, recover_after
        self._off: int | None = None
        self._agreeing = 0

    def take(self, number: int) -> Step:
        """Judge the next number; when it is good, it is the newest."""
        if self.newest is None or 0 < number - self.newest <= self._longest:
            return self._believe(number, Step.NEXT)
        agrees = self._off is not None and 0 < number - self._off <= self._longest
        self._agreeing = self._agreeing + 1 if agrees else 1
        self._off = number
        if self._agreeing >= self._recover_after:
            return self._believe(number, Step.ANEW)
        if -self._longest <= number - self.newest <= 0:
            return Step.OLD
        self.jumps += 1
        return Step.JUMP

    def _believe(self, number: int, step: Step) -> Step:
        self.newest, self._off, self._agreeing = number, None, 0
        return step


class StampGuard(StepGuard):
    """The stamps of one source [ns]."""

    def __init__(self, control: ControlParameters):
        """Args:
        control: gives the longest believable gap, and how many samples make a new clock.
        """
        super().__init__(round(control.longest_gap_s / NANOSECOND_S), control.clock_recovery_samples)
        self._control = control

    def why(self, stamp_ns: int) -> str:
        """Why a stamp that was just refused was."""
        off_s = (stamp_ns - (self.newest or 0)) * NANOSECOND_S
        if self._longest >= stamp_ns - (self.newest or 0) >= -self._longest:
            return f"its stamp is not newer than the last one but {-off_s:.3g} s older"
        return (
            f"its stamp is {off_s:+.3g} s off the last one; allowed: up to {self._control.longest_gap_s:g} s, "
            f"or {self._control.clock_recovery_samples} in succession that agree"
        )
