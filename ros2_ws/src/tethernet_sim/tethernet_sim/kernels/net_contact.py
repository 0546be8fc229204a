"""Contact of net with net, or none: which it is is settled when a step is compiled, so that a flight without it has
nothing to compile for it.

The law is in :mod:`~tethernet_sim.kernels.crossing_law`, what it looks at in :mod:`~tethernet_sim.kernels.crossings`.
"""

from __future__ import annotations

from typing import Any

from tethernet_sim.kernels import crossing_law, crossing_work, crossings, dispatch
from tethernet_sim.kernels.crossing_kinds import Crossings, CrossingThreads, NoCrossings
from tethernet_sim.kernels.options import INLINED, KERNEL


def begin(threads: Crossings, width: int, crossed: Any, count: Any) -> Any:
    """Work space of one scenario; compiled code only, like all of these.

    Args:
        threads: those that touch.
        width: room of a row of coordinates.
        crossed: what touched at the end of the steps before, see State.
        count: how many (1,).
    """
    raise NotImplementedError


def look(threads: Crossings, work: Any, numbers: Any, knots: int, pos: Any, vel: Any) -> int:
    """Make the lists of what is near anew where it is time to. Returns pairs that there must be room for, 0: there
    is; where there is not, the same look must follow with the work space of :func:`with_room`.
    """
    raise NotImplementedError


def with_room(threads: Crossings, work: Any, pairs: int) -> Any:
    """Work space with room for so many pairs, and what touches."""
    raise NotImplementedError


def push(threads: Crossings, work: Any, numbers: Any, mass: Any, kick: Any, pos: Any, vel: Any) -> None:
    """Find what touches and what it does to the velocities [m/s], ``vel`` (3, width) as it is."""
    raise NotImplementedError


def react(threads: Crossings, work: Any, vel: Any) -> None:
    """Change the velocities by what :func:`push` found."""
    raise NotImplementedError


def end(threads: Crossings, work: Any, crossed: Any, count: Any) -> None:
    """Write down what touches, as much as there is room for, and how much it is."""
    raise NotImplementedError


def _begin(threads, width, crossed, count):
    work = crossing_work.workspace(len(threads.ends), width, crossing_work.room(len(threads.ends), count[0]))
    work.counts[crossing_work.RECORDS] = count[0]
    work.records[: count[0]] = crossed[: count[0]]
    return work


def _look(threads, work, numbers, knots, pos, vel):
    counts = work.counts
    if counts[crossing_work.LOOK_IN] > 0:
        counts[crossing_work.LOOK_IN] -= 1
        return 0
    needed = crossings.look(work, threads.ends, numbers, knots, pos, vel)
    if needed == 0:
        counts[crossing_work.LOOK_IN] = crossings.LOOK_STEPS - 1
    return needed


def _with_room(threads, work, pairs):
    return crossing_work.with_room(work, pairs)


def _push(threads, work, numbers, mass, kick, pos, vel):
    found = crossing_law.find(work, numbers, pos)
    work.counts[crossing_work.TOUCHING] = crossing_law.push(work, numbers, mass, kick, pos, vel, found)


def _react(threads, work, vel):
    crossing_law.react(work, work.counts[crossing_work.TOUCHING], vel)


def _end(threads, work, crossed, count):
    count[0] = crossing_work.store(work, crossed)


def _serve(function: Any, kernel: Any, nothing: str, options: Any) -> None:
    """Serve a function by a kernel where threads touch, by the value of an expression where none do."""
    kernels = {CrossingThreads: kernel, NoCrossings: dispatch.constant(function, nothing)}
    dispatch.serve(function, kernels.get, options)  # type: ignore[arg-type]  # mypy takes the default's overload


for _function, _kernel, _nothing, _options in (
    (begin, _begin, "0", KERNEL), (look, _look, "0", INLINED), (with_room, _with_room, "work", KERNEL),
    (push, _push, "None", INLINED), (react, _react, "None", INLINED), (end, _end, "None", INLINED),
):  # fmt: skip
    _serve(_function, _kernel, _nothing, _options)
