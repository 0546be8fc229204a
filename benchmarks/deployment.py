"""The deployment that engine and peer both fly: the paper's PID to the nominal aiming points, no noise."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from tethernet_control.law_numbers import law_numbers
from tethernet_core.aiming import nominal_aiming_points
from tethernet_core.system import load_system
from tethernet_sim.fly import Settings
from tethernet_sim.kernels import control as control_kernels
from tethernet_sim.world import World

DEBRIS = (0.0, 0.0, -50.0)
"""The debris' centre of mass [m], frame launch."""
DURATION_S = 23.0
"""[s] Ends before the net can touch the debris, which the peer does not have."""
IDENTITY = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Deployment:
    """A flown deployment, one row per control period, the first at its end."""

    mu_pos: np.ndarray  # (T, M, 3)
    """MU positions [m]."""
    net_center: np.ndarray  # (T, 3)
    """The knots' centre of mass [m]."""
    cpu_s: float
    """CPU time of the physics' steps [s], the commands not counted."""
    simulated_s: float
    contacts: int
    """Largest number of particles that touched the debris."""

    def errors(self, reference: Deployment) -> tuple[float, float]:
        """Largest distances from a reference over time and MUs: of an MU [m], of the net's centre [m]."""
        mu = np.linalg.norm(self.mu_pos - reference.mu_pos, axis=-1).max()
        center = np.linalg.norm(self.net_center - reference.net_center, axis=-1).max()
        return float(mu), float(center)


def fly_engine(mu_count: int = 8, duration_s: float = DURATION_S, time_step_s: float | None = None) -> Deployment:
    """Fly the deployment with our own engine, the code that the simulator's node runs.

    Args:
        mu_count: 4 or 8.
        duration_s: a multiple of the control period [s].
        time_step_s: of the integration [s]; None for the one that missions are flown with.
    """
    system = load_system(f"zenit_{mu_count}mu")
    units = system.units
    settings = Settings.paper(system, physics={} if time_step_s is None else {"time_step_s": time_step_s})
    control = settings.control
    world = World(
        system,
        np.array([DEBRIS]),
        np.array([IDENTITY]),
        np.zeros((1, 3)),
        settings.physics,
        control,
    )
    aim = np.array([nominal_aiming_points(system, DEBRIS)])
    start = world.state.mu_pos.copy()
    integral, carry, thrust = np.zeros_like(start), np.zeros_like(start), np.zeros_like(start)
    state, covariance = np.zeros((1, mu_count, 9)), np.zeros((1, mu_count, 6))
    alone, one, largest_error = np.arange(1), np.ones(1), np.zeros(1)
    never, on = np.full(1, -1.0), np.zeros((1, mu_count), bool)  # closing never begins, the thrusters stay on
    mu_pos, net_center, cpu_s, contacts = [], [], 0.0, 0
    law, mass = law_numbers(control, units[0]), np.array([unit.mass_kg for unit in units])
    limit = np.array([unit.thrust_limit_n for unit in units])
    for tick in range(round(duration_s / control.control_period_s)):
        control_kernels.command(
            law, mass, limit, alone, world.state.mu_pos, world.state.mu_vel, tick * control.control_period_s, never,
            one, control.control_period_s, on, start, aim, aim, state, covariance, integral, carry, thrust,
            largest_error,
        )  # fmt: skip
        began = time.process_time()
        world.advance(thrust)
        cpu_s += time.process_time() - began
        mu_pos.append(world.state.mu_pos[0].copy())
        net_center.append(world.net_center(0))
        contacts = max(contacts, int(world.state.contacts[0]))
    return Deployment(np.array(mu_pos), np.array(net_center), cpu_s, duration_s, contacts)


def fly_mujoco(
    mu_count: int = 8, duration_s: float = DURATION_S, *, time_step_s: float, integrator: str, threads: str
) -> Deployment:
    """Fly the deployment with the peer model, see :mod:`benchmarks.mujoco_net`.

    Args:
        mu_count: 4 or 8.
        duration_s: a multiple of the control period [s].
        time_step_s: of the integration [s].
        integrator: MuJoCo's name for it.
        threads: how they are modelled.

    Raises:
        ArithmeticError: when MuJoCo's state blew up.
    """
    from .mujoco_net import simulate

    flown = simulate(time_step_s, duration_s, DEBRIS, mu_count, integrator, threads)
    if not flown["finished"]:
        raise ArithmeticError(f"MuJoCo's {integrator} at {time_step_s:g} s diverged at t = {flown['t'][-1]:.2f} s")
    return Deployment(flown["mu_pos"], flown["net_com"], flown["cpu_s"], duration_s, 0)
