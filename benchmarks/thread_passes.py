"""Passes of threads of the net through each other, counted from outside of the simulation.

Between two looks all knots are taken to go straight on. A thread has passed through another where their four ends come
to lie in one plane, a root of a cubic, while the threads cross within their lengths. That knows nothing of the
contact's lists and memory. A thread that is pushed back to its side counts a second time.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from tethernet_sim.engine import Commands
from tethernet_sim.world import World

LOOK_S = 0.001
"""Time between two looks: so many steps are flown at once."""
NOISE_M = 1e-6
"""Threads that are nearer to each other than that, before or after, lie in one plane, as all do at launch: which side
they are on is rounding."""
_PARTS = 8
"""Parts of the time between two looks in which a root is sought by its change of sign."""
_BISECTIONS = 40


class PassCounter:
    """Counts the passes of one scenario; an observer of :func:`~tethernet_sim.fly.fly`."""

    def __init__(self) -> None:
        self.deployment = 0
        """Passes before closing begins."""
        self.capture = 0
        """Passes from then on."""
        self._world: World | None = None

    def __call__(self, _stamp_ns: int, world: World, _flying: np.ndarray) -> None:
        """Take the world's periods over, at the first control tick."""
        if self._world is None:
            self._world = world
            world.advance = self._advance  # type: ignore[method-assign]  # this one world, while it is watched

    def _advance(self, thrust: np.ndarray, chosen: np.ndarray | None = None) -> None:
        world = self._world
        assert world is not None
        state, threads = world.state, world.model.arrays.threads
        for _ in range(round(world.steps * world.model.numbers.time_step / LOOK_S)):
            before = state.knot_pos[0].copy()
            commands = Commands(thrust, world.external, world.target_pos, world.target_vel, world.chaser_force)
            world.engine.advance(state, commands, LOOK_S, chosen)
            passed = count_passes(before, state.knot_pos[0], threads)
            if state.closing[0]:
                self.capture += passed
            else:
                self.deployment += passed


@numba.njit(cache=True)
def count_passes(before: np.ndarray, after: np.ndarray, threads: np.ndarray) -> int:
    """How often a thread passes through another.

    Args:
        before: places of the knots [m], (3, N).
        after: places a moment later, likewise.
        threads: knots at their ends, (T, 2).
    """
    count = len(threads)
    low, high = np.empty((3, count)), np.empty((3, count))
    for t in range(count):
        i, j = threads[t]
        for axis in range(3):
            low[axis, t] = min(before[axis, i], before[axis, j], after[axis, i], after[axis, j])
            high[axis, t] = max(before[axis, i], before[axis, j], after[axis, i], after[axis, j])
    order = np.argsort(low[0])
    passes = 0
    for first in range(count):
        a = order[first]
        for second in range(first + 1, count):
            b = order[second]
            if low[0, b] > high[0, a]:
                break
            if low[1, b] > high[1, a] or low[1, a] > high[1, b] or low[2, b] > high[2, a] or low[2, a] > high[2, b]:
                continue
            i, j, k, m = threads[a, 0], threads[a, 1], threads[b, 0], threads[b, 1]
            if i not in (k, m) and j not in (k, m):
                passes += _passes_of_pair(before, after, i, j, k, m)
    return passes


@numba.njit(cache=True)
def _passes_of_pair(before, after, i, j, k, m):  # type: ignore[no-untyped-def]  # compiled by numba
    passes, last = 0, _mixed(before, after, i, j, k, m, 0.0)
    if min(_apart(before, after, i, j, k, m, 0.0), _apart(before, after, i, j, k, m, 1.0)) < NOISE_M:
        return 0
    for part in range(_PARTS):
        early, late = part / _PARTS, (part + 1) / _PARTS
        now = _mixed(before, after, i, j, k, m, late)
        if (last > 0.0) != (now > 0.0):
            for _ in range(_BISECTIONS):
                middle = 0.5 * (early + late)
                if (_mixed(before, after, i, j, k, m, middle) > 0.0) == (last > 0.0):
                    early = middle
                else:
                    late = middle
            passes += _crossed(before, after, i, j, k, m, 0.5 * (early + late))
        last = now
    return passes


@numba.njit(cache=True)
def _sides(before, after, i, j, k, m, share):  # type: ignore[no-untyped-def]  # compiled by numba
    """Both threads, and from the first knot of the first to that of the second, after a share of the time."""
    u, v, w = np.empty(3), np.empty(3), np.empty(3)
    for axis in range(3):
        row, later = before[axis], after[axis]
        u[axis] = (1.0 - share) * (row[j] - row[i]) + share * (later[j] - later[i])
        v[axis] = (1.0 - share) * (row[m] - row[k]) + share * (later[m] - later[k])
        w[axis] = (1.0 - share) * (row[k] - row[i]) + share * (later[k] - later[i])
    return u, v, w


@numba.njit(cache=True)
def _mixed(before, after, i, j, k, m, share):  # type: ignore[no-untyped-def]  # compiled by numba
    """Six times the volume that the four ends span, with its sign."""
    u, v, w = _sides(before, after, i, j, k, m, share)
    return np.dot(np.cross(u, v), w)


@numba.njit(cache=True)
def _apart(before, after, i, j, k, m, share):  # type: ignore[no-untyped-def]  # compiled by numba
    """Distance of the lines along both threads [m]; 0 where they are parallel."""
    u, v, w = _sides(before, after, i, j, k, m, share)
    across = np.cross(u, v)
    area = math.sqrt(np.dot(across, across))
    return abs(np.dot(across, w)) / area if area > 0.0 else 0.0


@numba.njit(cache=True)
def _crossed(before, after, i, j, k, m, share):  # type: ignore[no-untyped-def]  # compiled by numba
    """Whether two threads in one plane cross within their lengths."""
    u, v, w = _sides(before, after, i, j, k, m, share)
    across = np.cross(u, v)
    area = np.dot(across, across)
    if area == 0.0:
        return False
    s, t = np.dot(np.cross(w, v), across) / area, np.dot(np.cross(w, u), across) / area
    return 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0
