"""The physics behind one interface: what advances the state of a batch by a period.

Two engines share all but the net's threads: :class:`GridEngine` for rectangular nets whose threads are all alike,
:class:`EdgeListEngine` for any net. Which one serves a model best says :func:`engine_for`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from tethernet_sim import cores
from tethernet_sim.kernels import step
from tethernet_sim.kernels.edge_list import EdgeList
from tethernet_sim.kernels.grid import Grid
from tethernet_sim.model import Model, grid_threads
from tethernet_sim.state import CHASER, State
from tethernet_sim.thread_blocks import edge_list

_DENSE_SHARE = 224 / 1012
"""Share of taut threads from which evaluating all of them, vectorised, is faster (measured)."""


@dataclass(frozen=True)
class Commands:
    """What the MUs of B scenarios do in one period, frame launch."""

    thrust: np.ndarray  # (B, M, 3)
    """Constant thrust [N]."""
    external: np.ndarray  # (B, M) bool
    """MUs whose stand-ins follow a target instead of flying on thrust."""
    target_pos: np.ndarray  # (B, M, 3)
    """The targets at the beginning of the period [m]."""
    target_vel: np.ndarray  # (B, M, 3)
    """Their velocities [m/s]."""
    chaser_force: np.ndarray  # (B, 3)
    """Constant thrust on the chaser's centre of mass [N]; felt once closing has begun."""

    @classmethod
    def of_thrust(cls, thrust: np.ndarray) -> Commands:
        """Thrust [N], (B, M, 3), no external MU, and a chaser that coasts."""
        nothing = np.zeros(thrust.shape)
        return cls(thrust, np.zeros(thrust.shape[:2], bool), nothing, nothing, np.zeros((len(thrust), 3)))


class Engine(Protocol):
    """Advances the states of one model."""

    model: Model
    threads: Any
    """The net's threads as the kernels take them."""

    def advance(self, state: State, commands: Commands, period: float, chosen: np.ndarray | None = None) -> None:
        """Fly on for one period.

        Args:
            state: of B scenarios; updated.
            commands: for the period.
            period: a whole number of time steps [s].
            chosen: indices of the scenarios to fly; None for all.

        Raises:
            ValueError: for a period that is no whole number of time steps.
        """

    def begin_closing(self, state: State, index: int) -> None:
        """Lock the main tether, start the winches, enable docking in one scenario."""


class _KernelEngine:
    """What both engines share."""

    def __init__(self, model: Model, threads: Grid | EdgeList):
        self.model = model
        self.threads = threads

    def advance(self, state: State, commands: Commands, period: float, chosen: np.ndarray | None = None) -> None:
        """See :meth:`Engine.advance`."""
        steps = self._steps(period)
        s, c = state, commands
        flying = np.arange(s.batch) if chosen is None else chosen

        def fly(part: np.ndarray) -> None:
            step.advance(
                self.model.numbers, self.model.arrays, self.threads, self.model.debris, steps, part, c.thrust,
                c.external, c.target_pos, c.target_vel, c.chaser_force, s.knot_pos, s.knot_vel, s.mu_pos, s.mu_vel,
                s.bodies, s.bristle, s.crossed, s.crossed_count, s.closing, s.pair_length, s.locked, s.winch_length,
                s.tether_length, s.contacts,
            )  # fmt: skip

        before = s.copy() if len(self.model.arrays.crossing_threads.ends) else s
        cores.share(fly, flying)
        # Where more threads touch than there is room for, once more from the same state: with the same bits.
        while len(full := flying[s.crossed_count[flying] > s.crossed.shape[1]]):
            s.make_room(2 * int(s.crossed_count[full].max()))
            s.take(before, full)
            cores.share(fly, full)

    def begin_closing(self, state: State, index: int) -> None:
        """See :meth:`Engine.begin_closing`."""
        state.tether_length[index] = step.begin_closing(
            self.model.numbers, self.model.arrays, state.knot_pos[index], state.mu_pos[index],
            state.bodies[index, CHASER], state.pair_length[index], state.locked[index], state.winch_length[index],
        )  # fmt: skip
        state.closing[index] = True

    def _steps(self, period: float) -> int:
        time_step = self.model.numbers.time_step
        steps = round(period / time_step)
        if steps < 1 or abs(steps * time_step - period) > 1e-9 * period:
            raise ValueError(f"period = {period:g} s; allowed: a whole number of time steps of {time_step:g} s")
        return steps


class GridEngine(_KernelEngine):
    """For rectangular nets whose threads are all alike: nothing is looked up, everything vectorises."""

    def __init__(self, model: Model):
        """Raises ValueError for a net that is not a grid of equal threads, see :func:`is_uniform_grid`."""
        if model.grid is None or not is_uniform_grid(model):
            raise ValueError(
                "the grid engine flies rectangular nets of at least 2 x 2 nodes, numbered row by row, whose threads "
                "are all alike; use EdgeListEngine for this net"
            )
        a = model.arrays
        dense_from = int(_DENSE_SHARE * len(a.threads))
        rows, columns = model.grid
        super().__init__(
            model, Grid(rows, columns, float(a.rest[0]), float(a.stiffness[0]), float(a.damping[0]), dense_from)
        )


class EdgeListEngine(_KernelEngine):
    """For any net: each thread has its own ends, rest length, stiffness and damping."""

    def __init__(self, model: Model):
        a = model.arrays
        super().__init__(model, edge_list(model.numbers.knots, a.threads, a.rest, a.stiffness, a.damping, _DENSE_SHARE))


def is_uniform_grid(model: Model) -> bool:
    """Whether a net has the threads of a rectangular grid, row by row, all of one kind."""
    if model.grid is None or min(model.grid) < 2:
        return False
    a = model.arrays
    alike = all(len(values) and (values == values[0]).all() for values in (a.rest, a.stiffness, a.damping))
    return alike and np.array_equal(_in_order(a.threads), _in_order(grid_threads(*model.grid)))


def engine_for(model: Model) -> Engine:
    """The fastest engine that flies a model's net."""
    return GridEngine(model) if is_uniform_grid(model) else EdgeListEngine(model)


def _in_order(threads: np.ndarray) -> np.ndarray:
    ends = np.sort(threads, axis=1)
    return ends[np.lexsort(ends.T)]
