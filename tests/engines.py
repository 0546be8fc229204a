"""Models of any net and both engines, for the tests of the engines."""

from __future__ import annotations

import numpy as np

from tethernet_sim.engine import Commands, EdgeListEngine, Engine, GridEngine
from tethernet_sim.kernels.crossing_kinds import CrossingThreads, no_crossings
from tethernet_sim.kernels.crossing_work import RECORD
from tethernet_sim.kernels.cylinder_body import CylinderBody
from tethernet_sim.model import Arrays, Model, Numbers, grid_threads
from tethernet_sim.state import State

ENGINES = {"grid": GridEngine, "edge list": EdgeListEngine}
MESH_M, STEP_S = 1.0, 1e-4
STIFFNESS_N_M, DAMPING_N_S_M = 5.5e4, 1.0
KNOT_KG, MU_KG = 0.005, 2.5


def make_model(
    nodes: int,
    threads: np.ndarray,
    *,
    rest=MESH_M,
    units: int = 0,
    grid: tuple[int, int] | None = None,
    pairs=(),
    pair_winch=(),
    damping=DAMPING_N_S_M,
    stiffness=STIFFNESS_N_M,
    center: int = -1,
    time_step: float = STEP_S,
    net_contact: bool = False,
) -> Model:
    """A net with equal knots; units hang on the first nodes, or several on one; a debris far smaller than the net."""
    threads = np.asarray(threads, np.int64).reshape(-1, 2)
    count = len(threads)
    masses = np.concatenate([np.full(nodes, KNOT_KG), MU_KG + 0.1 * np.arange(units)])
    pairs = np.asarray(pairs, np.int64).reshape(-1, 2)
    pair_winch = np.asarray(pair_winch, np.int64).reshape(-1)
    if not len(pair_winch):
        pair_winch = np.full(len(pairs), -1)
    winches = int(pair_winch.max(initial=-1)) + 1
    mu_mass = masses[nodes:]
    numbers = Numbers(
        knots=nodes, center_node=center, time_step=time_step, chaser_mass=500.0, chaser_inertia=200.0,
        chaser_half_side=0.5,
        tether_anchor=-0.5, tether_stiffness=100.0, tether_damping=0.1, contact_stiffness=1e3, mu_contact_share=1.0,
        friction=0.5, knot_radius=0.05, mu_radius=0.1, contact_damping_ratio=0.1, open_segments=0, half_longest=0.0,
        winch_speed=0.5, winch_tension=10.0, winch_stiffness=2500.0,
        joint_stiffness=1e3, joint_draw_in=0.1, joint_pull=50.0, docking_distance=0.3,
        crossing_distance=0.005, crossing_stiffness=5e3, crossing_viscosity=2e-5, crossing_grip=100.0,
    )  # fmt: skip
    arrays = Arrays(
        knot_mass=masses[:nodes],
        kick=time_step / masses[:nodes],
        threads=threads,
        rest=np.broadcast_to(rest, (count,)).astype(float),
        stiffness=np.broadcast_to(stiffness, (count,)).astype(float),
        damping=np.broadcast_to(damping, (count,)).astype(float),
        mu_mass=mu_mass,
        mu_inverse_mass=1.0 / mu_mass,
        mu_radius=np.full(units, 0.1),
        meeting=np.zeros((0, 2), np.int64),
        mu_knot=np.arange(units) % nodes,
        mu_thread=0.5 + 0.01 * np.arange(units),
        mu_stiffness=np.full(units, STIFFNESS_N_M),
        mu_damping=np.full(units, DAMPING_N_S_M),
        coupling_stiffness=4.0 * mu_mass,
        coupling_damping=4.0 * mu_mass,
        pairs=pairs,
        pair_winch=pair_winch,
        winch_begin=np.searchsorted(pair_winch, np.arange(winches + 1)) if winches else np.zeros(1, np.int64),
        joint_damping=np.full(len(pairs), 1.0),
        contact_damping=2.0 * 0.1 * np.sqrt(1e3 * masses),
        segments=np.zeros((0, 2), np.int64),
        segment_radius=np.zeros(0),
        segment_stiffness=np.zeros(0),
        inverse_mass=1.0 / masses,
        crossing_threads=CrossingThreads(threads.copy()) if net_contact else no_crossings(),
    )
    debris = CylinderBody(mass=100.0, across=50.0, along=30.0, radius=0.4, half_length=0.5)
    return Model(numbers, arrays, debris, grid)


def grid_model(rows: int, columns: int, **options) -> Model:
    """A rectangular net."""
    return make_model(rows * columns, grid_threads(rows, columns), grid=(rows, columns), **options)


def flat_state(model: Model, positions: np.ndarray | None = None, debris=(0.0, 0.0, -50.0), batch: int = 1) -> State:
    """A net at rest, flat if it is a grid, its units a little below their nodes."""
    if positions is None:
        rows, columns = model.grid
        x, y = np.meshgrid(np.arange(columns) - (columns - 1) / 2, np.arange(rows) - (rows - 1) / 2)
        positions = np.stack([x.ravel(), y.ravel(), np.zeros(rows * columns)]) * MESH_M
    units, pairs = len(model.arrays.mu_knot), len(model.arrays.pairs)
    below = np.array([0.0, 0.0, -0.4])
    mu_pos = positions[:, model.arrays.mu_knot].T + below
    bodies = np.zeros((batch, 2, 13))
    bodies[:, 0, :3], bodies[:, 1, :3], bodies[:, :, 9] = debris, (0.0, 0.0, 20.0), 1.0
    return State(
        knot_pos=np.repeat(positions[None], batch, axis=0),
        knot_vel=np.zeros((batch, 3, positions.shape[1])),
        mu_pos=np.repeat(mu_pos[None], batch, axis=0),
        mu_vel=np.zeros((batch, units, 3)),
        bodies=bodies,
        bristle=np.zeros((batch, model.contact_count, 3)),
        crossed=np.zeros((batch, 0, RECORD)),
        crossed_count=np.zeros(batch, np.int64),
        closing=np.zeros(batch, bool),
        tether_length=np.zeros(batch),
        pair_length=np.zeros((batch, pairs)),
        locked=np.zeros((batch, pairs), bool),
        winch_length=np.zeros((batch, model.winch_threads)),
        contacts=np.zeros(batch, np.int64),
    )


def shaken(model: Model, seed: int = 0, **options) -> State:
    """A flat net with random velocities of some 0.3 m/s, a bit larger than at rest: many threads are taut at once."""
    random = np.random.default_rng(seed)
    state = flat_state(model, **options)
    state.knot_pos *= 1.0001
    state.knot_vel[:] = random.normal(0.0, 0.3, state.knot_vel.shape)
    state.mu_vel[:] = random.normal(0.0, 0.3, state.mu_vel.shape)
    return state


def fly(engine: Engine, state: State, duration_s: float) -> State:
    """Fly without thrust."""
    engine.advance(state, Commands.of_thrust(np.zeros_like(state.mu_pos)), duration_s)
    return state
