"""The energy balance of a whole mission: what thrusters, winches and motors put in, what is stored, what is lost.

Every step is flown alone and booked from the laws of forces (kernels/energy.py); none of the terms is what the others
leave over. Such a mission takes some fifty times longer, others pay nothing for it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tethernet_sim import audit
from tethernet_sim.fly import Settings, fly
from tethernet_sim.kernels import crossing_energy
from tethernet_sim.kernels import energy as book
from tethernet_sim.scenario import Outcome, Scenario
from tethernet_sim.world import World

ROOM_PER_THREAD = 16
"""Touching pairs of threads that a booked flight has room for, for each thread: steps that are booked are not flown
again."""


@dataclass(frozen=True)
class EnergyBalance:
    """Energies of one mission, launch to verdict [J]."""

    gained: float
    """Kinetic energy of everything, end minus start."""
    stored: float
    """In springs, end minus start."""
    work: float
    """Of all forces on all bodies: equal to ``gained`` as far as the kernels follow the laws of forces."""
    put_in: dict[str, float]
    """By thrusters, winches, and the motors that draw docked pairs in."""
    lost: dict[str, float]
    """In the dampers of threads, tether, contact and joints, by friction, in winches that slip, in the contact of net
    with net."""

    @property
    def all_in(self) -> float:
        """All that was put in [J]: what the residual is measured by."""
        return sum(self.put_in.values())

    @property
    def residual(self) -> float:
        """Energy from nowhere, or gone there if negative [J]."""
        return self.gained + self.stored + sum(self.lost.values()) - self.all_in


def audit_mission(scenario: Scenario, settings: Settings | None = None) -> tuple[Outcome, EnergyBalance]:
    """Fly one mission step by step and book the energy."""
    auditor = Auditor()
    outcome = fly(scenario, settings, auditor)
    return outcome, auditor.balance()


class Auditor:
    """Books the energy of one scenario; an observer of :func:`~tethernet_sim.fly.fly`."""

    def __init__(self) -> None:
        self._booked: World | None = None
        self._start = (0.0, 0.0)
        self._ledger = np.zeros(book.TERMS)

    def __call__(self, _stamp_ns: int, world: World, _flying: np.ndarray) -> None:
        """Take the world's periods over, at the first control tick."""
        if self._booked is None:
            self.attach(world)

    def attach(self, world: World) -> None:
        """Book all periods that ``world`` flies from now on; its first scenario is the one that is looked at."""
        self._booked = world
        world.state.make_room(ROOM_PER_THREAD * len(world.model.arrays.crossing_threads.ends))
        world.advance = self._fly_period  # type: ignore[method-assign]  # this one world, for as long as it is booked
        self._start = self._energies()

    def balance(self) -> EnergyBalance:
        """The balance from where the world was attached until now."""
        row = self._ledger
        kinetic, elastic = self._energies()
        return EnergyBalance(
            gained=kinetic - self._start[0],
            stored=elastic - self._start[1],
            work=float(row[book.WORK]),
            put_in={
                "thrusters": float(row[book.THRUST]),
                "winches": float(row[book.WINCH_IN]),
                "docking motors": float(row[book.JOINT_IN]),
            },
            lost={
                "threads": float(row[book.THREADS]),
                "tether": float(row[book.TETHER]),
                "contact": float(row[book.CONTACT]),
                "friction": float(row[book.FRICTION]),
                "winches slipping": float(row[book.WINCH_SLIP]),
                "joints": float(row[book.JOINTS]),
                "net on net": float(row[crossing_energy.NET_CONTACT]),
            },
        )

    @property
    def _world(self) -> World:
        if self._booked is None:
            raise ValueError("nothing has been booked; attach a world first")
        return self._booked

    def _energies(self) -> tuple[float, float]:
        model, state = self._world.model, self._world.state
        kinetic, elastic = audit.kinetic_energy(model, state), audit.elastic_energy(model, state)
        return float(kinetic[0]), float(elastic[0])

    def _fly_period(self, thrust: np.ndarray, chosen: np.ndarray | None = None) -> None:
        world = self._world
        if world.state.batch != 1 or world.external.any():
            raise ValueError("energy is booked for one scenario alone, without external MUs")
        s = world.state
        s.contacts[0] = book.fly_booked(
            self._ledger, world.model.numbers, world.model.arrays, world.engine.threads, world.model.debris,
            world.steps, thrust[0], world.external[0], world.target_pos[0], world.target_vel[0],
            world.chaser_force[0], s.knot_pos[0], s.knot_vel[0], s.mu_pos[0], s.mu_vel[0], s.bodies[0], s.bristle[0],
            s.crossed[0], s.crossed_count, s.closing[0], s.pair_length[0], s.locked[0], s.winch_length[0],
            s.tether_length[0],
        )  # fmt: skip
        if s.crossed_count[0] > s.crossed.shape[1]:
            raise ValueError(
                f"{s.crossed_count[0]} pairs of threads touch each other; energy can be booked for {s.crossed.shape[1]}"
            )
