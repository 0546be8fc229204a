"""The loads of a flight: on threads as shares of their strength, and on the debris."""

from __future__ import annotations

import math

import numpy as np

from tethernet_sim.kernels import loads as kernels
from tethernet_sim.state import DEBRIS, VELOCITY
from tethernet_sim.world import World


class Loads:
    """The loads of each scenario of a world: those of the newest look, and the largest so far.

    Tensions are looked at at every control tick, not at every time step: a jerk that is over within the 50 ms between
    two ticks is missed, so that these are lower bounds of what a thread bears. The contact force is the mean over a
    control period, from the momentum that the debris gains, which nothing but contact changes.
    """

    def __init__(self, world: World):
        """Args:
        world: whose loads.
        """
        self._world = world
        batch = world.state.batch
        thread, tether = world.system.net.material.strength_n, world.system.tether_strength_n
        self._thread_n = math.nan if thread is None else thread
        self._tether_n = math.nan if tether is None else tether
        self._known = not (math.isnan(self._thread_n) or math.isnan(self._tether_n))
        unknown = 0.0 if self._known else math.nan
        self._share_now, self._share = np.full(batch, unknown), np.full(batch, unknown)
        self._contact_now_n, self._contact_n = np.zeros(batch), np.zeros(batch)
        self._before = world.state.bodies[:, DEBRIS, VELOCITY].copy()

    def look(self, chosen: np.ndarray) -> None:
        """Look at the state after a control period.

        Args:
            chosen: indices of the scenarios that flew it, shape (C,).
        """
        world, s = self._world, self._world.state
        velocity = s.bodies[chosen, DEBRIS, VELOCITY]
        gained = np.linalg.norm(velocity - self._before[chosen], axis=1)
        period_s = world.steps * world.model.numbers.time_step
        self._contact_now_n[chosen] = world.model.debris.mass * gained / period_s
        self._contact_n[chosen] = np.maximum(self._contact_n[chosen], self._contact_now_n[chosen])
        self._before[chosen] = velocity
        if not self._known:
            return
        self._share_now[chosen] = 0.0
        kernels.largest_share(
            world.model.numbers, world.model.arrays, chosen, self._thread_n, self._tether_n, s.knot_pos, s.knot_vel,
            s.mu_pos, s.mu_vel, s.bodies, s.closing, s.pair_length, s.locked, s.winch_length, s.tether_length,
            self._share_now,
        )  # fmt: skip
        self._share[chosen] = np.maximum(self._share[chosen], self._share_now[chosen])

    def share(self, index: int) -> float:
        """Largest tension over strength so far, of threads of the net, the units and the winches, joints and the main
        tether [-]; NaN where no strength is known.
        """
        return float(self._share[index])

    def share_now(self, index: int) -> float:
        """The same at the newest look [-]."""
        return float(self._share_now[index])

    def contact_n(self, index: int) -> float:
        """Largest contact force on the debris so far, mean over a control period [N]."""
        return float(self._contact_n[index])

    def contact_now_n(self, index: int) -> float:
        """The same over the newest control period [N]."""
        return float(self._contact_now_n[index])
