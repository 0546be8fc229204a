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


def held(inside: bool | None, locked_before: Iterable[bool], locked: Iterable[bool], load_share: float) -> Held:
    """Whether a capture held.

    It did when, at the end of the hold test,

    - the closed net still goes round the whole debris (:func:`~tethernet_core.enclosure.enclosed`), and
    - no pair that was locked at the verdict has come undone.

    That the debris follows needs no number of its own: who is inside a net that has drifted or was towed for a minute
    has gone where the net went. Nothing here is tuned. Whether it was captured, as the verdict means it, is another
    question.

    Args:
        inside: whether the closed net goes round the whole debris at the end; None where nothing measures the net.
        locked_before: which closing pairs were locked at the verdict.
        locked: which are now.
        load_share: largest tension so far of any thread over its strength; NaN where it is not known.
    """
    if inside is None:
        return Held(None, "undecided whether it is held: nothing measures the net")
    lost = sum(was and not now for was, now in zip(locked_before, locked, strict=True))
    reasons = [] if inside else ["the closed net does not go round the whole debris"]
    if lost:
        reasons.append(f"{lost} pair{'s' if lost > 1 else ''} came undone")
    text = f"not held: {', '.join(reasons)}" if reasons else "held: the closed net goes round the whole debris"
    return Held(not reasons, text + overload(load_share))


def overload(load_share: float) -> str:
    """A warning to add to a verdict where a thread bore more than it can; empty otherwise.

    Args:
        load_share: largest tension of any thread over its strength [-]; NaN where it is not known.
    """
    if not load_share > 1.0:
        return ""
    return f"; warning: a thread bore {load_share:.2f} times what it can, a real one would have broken"
