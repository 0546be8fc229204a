"""Whether a capture holds: the test after the verdict, when the mission has gone on for a while."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Held:
    """What a hold test came to."""

    held: bool | None
    """None where nothing measured the net."""
    verdict: str
    """One sentence: why."""


NOT_MEASURED = "nothing measures the net"
"""Why it may not be known whether the debris is held."""


def held(
    inside: bool | None,
    locked_before: Iterable[bool],
    locked: Iterable[bool],
    load_share: float,
    unknown: str = NOT_MEASURED,
) -> Held:
    """Whether a capture held.

    It did when, at the end of the hold test,

    - the closed net still goes round the whole debris (:func:`~tethernet_core.enclosure.enclosed`), and
    - no pair that was locked at the verdict has come undone.

    That the debris follows needs no number of its own: who is inside a net that has drifted or was towed for a minute
    has gone where the net went. Nothing here is tuned. Whether it was captured, as the verdict means it, is another
    question.

    Args:
        inside: whether the closed net goes round the whole debris at the end; None where that is not known.
        locked_before: which closing pairs were locked at the verdict.
        locked: which are now.
        load_share: largest tension so far of any thread over its strength; NaN where it is not known.
        unknown: why ``inside`` is not known, where it is not.
    """
    if inside is None:
        return Held(None, f"undecided whether it is held: {unknown}")
    lost = sum(was and not now for was, now in zip(locked_before, locked, strict=True))
    reasons = [] if inside else ["the closed net does not go round the whole debris"]
    if lost:
        reasons.append(f"{lost} pair{'s' if lost > 1 else ''} came undone")
    text = f"not held: {', '.join(reasons)}" if reasons else "held: the closed net goes round the whole debris"
    return Held(not reasons, text + overload(load_share))


def never_held(verdict: str) -> Held:
    """What a hold test came to that a mission never got to: it was missed, or failed.

    Args:
        verdict: of the mission.
    """
    return Held(False, f"not held: {verdict}")


def conditions(hold_s: float, tow_n: float) -> str:
    """How the hold was tested, in words.

    Args:
        hold_s: length of the test [s].
        tow_n: steady tension that the chaser towed with [N]; 0: it coasted.
    """
    return f"{hold_s:g} s after the verdict" + (f", towed with {tow_n:g} N" if tow_n else "")


def overload(load_share: float) -> str:
    """A warning to add to a verdict where a thread bore more than it can; empty otherwise.

    Args:
        load_share: largest tension of any thread over its strength [-]; NaN where it is not known.
    """
    if not load_share > 1.0:
        return ""
    return f"; warning: a thread bore {load_share:.2f} times what it can, a real one would have broken"
