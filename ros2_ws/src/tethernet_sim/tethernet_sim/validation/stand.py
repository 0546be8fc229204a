"""A test stand: any net, held at some nodes, under loads that missions do not have, flown by the missions' engine.

After each step of the engine, gravity, drag and outer forces change the velocities that it ended with, and the
positions by as much as these velocities would have; held nodes are put back. The engine finds all its forces from the
state at the beginning of the step, and so are the loads: the sum is the semi-implicit Euler step of the whole system,
to rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tethernet_core.parameters import load
from tethernet_core.system import System, load_system
from tethernet_core.system.net_file import graph_tables
from tethernet_sim.engine import Commands, Engine, engine_for
from tethernet_sim.model import build_model
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.stability import check_stable
from tethernet_sim.state import State, initial_state

BASE = "sag_hexagonal_1m"
"""The shipped system that cases change: nothing in it acts on the net by itself."""
FAR_AWAY = (0.0, 0.0, -500.0)
"""Where the debris is in cases without contact [m]."""
FIXED_KG = 1e7
"""A debris that hardly moves in a case [kg]."""

AtStep = Callable[[float, State], None]
"""Looks at the state after a step: time [s], state."""


def net_system(
    nodes: npt.ArrayLike,
    threads: npt.ArrayLike,
    rest_lengths: npt.ArrayLike,
    *,
    thread: Mapping[str, Any],
    masses: Mapping[int, float] | None = None,
    shape: Mapping[str, Any] | None = None,
    mass_kg: float = FIXED_KG,
) -> System:
    """A system that consists of a net and perhaps a debris.

    Args:
        nodes: positions [m], shape (N, 3).
        threads: nodes at the ends of each, shape (T, 2).
        rest_lengths: [m], shape (T,).
        thread: entries of ``net.thread``.
        masses: masses at nodes, besides their threads' [kg].
        shape: of the debris; None: a small sphere, for cases without contact.
        mass_kg: of the debris.
    """
    tables = graph_tables(np.asarray(nodes, float), np.asarray(threads, np.int64), np.asarray(rest_lengths, float))
    return load_system(
        BASE,
        {
            "net": {
                "graph": tables,
                # None: of the material where one is named, and not the base's.
                "thread": {"modulus_pa": None, "density_kg_m3": None, **thread},
                "springs_per_thread": 1,
                "masses": [{"node": node, "mass_kg": mass} for node, mass in (masses or {}).items()],
            },
            "launch": {"ejected": {"bodies": [0], "velocities_m_s": [[0.0, 0.0, 0.0]]}},
            "debris": {"shape": dict(shape or {"kind": "sphere", "radius_m": 0.1}), "mass_kg": mass_kg},
        },
    )


def threads_touch(physics: Mapping[str, Any]) -> bool:
    """Whether threads touch the debris between their knots, with these physical parameters.

    An engine that has no choice of the contact lets knots touch alone.
    """
    return getattr(load(PhysicsParameters, dict(physics)), "contact", "knots") == "threads"


def chain(points: npt.ArrayLike) -> np.ndarray:
    """Threads from each point to the next one, shape (N - 1, 2)."""
    numbers = np.arange(len(np.asarray(points)))
    return np.stack([numbers[:-1], numbers[1:]], axis=1)


class Stand:
    """One net under test."""

    def __init__(
        self,
        system: System,
        physics: Mapping[str, Any],
        *,
        held: Sequence[int] = (),
        gravity: Sequence[float] = (0.0, 0.0, 0.0),
        drag_1_s: float = 0.0,
        debris_position: Sequence[float] = FAR_AWAY,
        debris_rate: Sequence[float] = (0.0, 0.0, 0.0),
    ):
        """Args:
            system: net and debris.
            physics: physical parameters, in the place of the default ones.
            held: nodes that do not move, unless :attr:`held_velocity` says how.
            gravity: acceleration of all nodes [m/s^2].
            drag_1_s: drag force per mass and velocity [1/s].
            debris_position: [m].
            debris_rate: [rad/s], body frame.

        Raises:
            ParameterError: for a parameter that is wrong, or a time step that is unstable.
        """
        self.system = system
        self.physics = load(PhysicsParameters, dict(physics))
        check_stable(system, self.physics)
        self.model = build_model(system, self.physics)
        self.engine: Engine = engine_for(self.model)
        self.state = initial_state(
            self.model,
            system,
            self.physics,
            np.array([debris_position], float),
            np.array([[0.0, 0.0, 0.0, 1.0]]),
            np.array([debris_rate], float),
        )
        self.position[:] = system.net.nodes.T
        self.velocity[:] = 0.0
        self.held = np.array(held, np.int64)
        self.held_velocity = np.zeros((3, len(self.held)))
        """[m/s], shape (3, H)."""
        self.gravity = np.array(gravity, float)[:, None]
        self.drag_1_s = drag_1_s
        self.force = np.zeros((3, system.net.node_count))
        """Outer force on each node [N], shape (3, N)."""
        self.time_s = 0.0
        self._commands = Commands.of_thrust(np.zeros_like(self.state.mu_pos))

    @property
    def step_s(self) -> float:
        """The time step [s]."""
        return self.physics.time_step_s

    @property
    def position(self) -> np.ndarray:
        """Of the nodes [m], shape (3, N); can be written to."""
        return self.state.knot_pos[0]

    @property
    def velocity(self) -> np.ndarray:
        """Of the nodes [m/s], shape (3, N); can be written to."""
        return self.state.knot_vel[0]

    @property
    def masses(self) -> np.ndarray:
        """Of the nodes [kg], shape (N,)."""
        return self.system.net.node_masses

    def run(self, duration_s: float, at_step: AtStep | None = None) -> None:
        """Fly on, step by step."""
        dt, held = self.step_s, self.held
        constant = dt * (self.gravity + self.force / self.masses)
        place = self.position[:, held].copy()
        self.velocity[:, held] = self.held_velocity
        for _ in range(round(duration_s / dt)):
            kick = constant - dt * self.drag_1_s * self.velocity
            self.engine.advance(self.state, self._commands, dt)
            self.velocity[:] += kick
            self.position[:] += dt * kick
            place += dt * self.held_velocity
            self.position[:, held] = place
            self.velocity[:, held] = self.held_velocity
            self.time_s += dt
            if at_step is not None:
                at_step(self.time_s, self.state)

    def coast(self, duration_s: float) -> None:
        """Fly on without loads and held nodes, many steps at once: for what the engine does all by itself."""
        steps = max(1, round(duration_s / self.step_s))
        self.engine.advance(self.state, self._commands, steps * self.step_s)
        self.time_s += steps * self.step_s

    def tensions(self) -> np.ndarray:
        """Of all threads, damping left out [N], shape (T,)."""
        net = self.system.net
        length = np.linalg.norm(self._spans(), axis=0)
        return net.thread_stiffness * np.maximum(length - net.rest_lengths, 0.0)

    def pulls(self) -> np.ndarray:
        """Force of the threads on each node, damping left out [N], shape (3, N)."""
        first, second = self.system.net.threads.T
        spans = self._spans()
        pull = spans * (self.tensions() / np.linalg.norm(spans, axis=0))
        count = self.system.net.node_count
        return np.stack([np.bincount(first, row, count) - np.bincount(second, row, count) for row in pull])

    def _spans(self) -> np.ndarray:
        first, second = self.system.net.threads.T
        return self.position[:, second] - self.position[:, first]
