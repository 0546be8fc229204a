"""Threads of the net that touch each other: none passes, nothing is gained, whatever the lists."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.thread_passes import count_passes
from tests.engines import KNOT_KG, STEP_S, flat_state, fly, grid_model, make_model
from tests.physics import make_world
from tethernet_core.parameters import ParameterError, load
from tethernet_sim import audit
from tethernet_sim.energy import Auditor
from tethernet_sim.engine import EdgeListEngine, GridEngine
from tethernet_sim.fly import Settings
from tethernet_sim.kernels.crossing_work import RECORD
from tethernet_sim.memory import scenario_bytes, work_bytes
from tethernet_sim.model import Model
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.stability import largest_step, largest_step_of
from tethernet_sim.state import State

ON = {"net_contact": "threads"}
TOUCH_M = 0.005


def two_threads(*, friction: float = 0.0, net_contact: bool = True, viscosity_s: float = 0.0) -> Model:
    """Two slack threads of 1 m, free of each other but for their contact."""
    model = make_model(4, [(0, 1), (2, 3)], rest=2.0, net_contact=net_contact)
    changed = {"friction": friction, "crossing_viscosity": viscosity_s, "crossing_grip": 5e3 if friction else 0.0}
    return model._replace(numbers=model.numbers._replace(**changed))


def crossed(model: Model, velocity, *, above_m: float = 0.01, angle: float = 1.5, shift_m: float = 0.0) -> State:
    """One thread along x, at rest; the other ``above_m`` over it, turned by an angle and moving."""
    along = 0.5 * np.array([np.cos(angle), np.sin(angle), 0.0])
    middle = np.array([shift_m, 0.0, above_m])
    places = np.array([[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], middle - along, middle + along]).T
    state = flat_state(model, places.copy())
    state.knot_vel[0, :, 2:] = np.array(velocity)[:, None]
    return state


def over(state: State) -> float:
    """How far the second thread's middle is above the first's [m]."""
    z = state.knot_pos[0, 2]
    return float(z[2:].mean() - z[:2].mean())


@pytest.mark.parametrize("speed_m_s", [0.3, 3.0, 20.0])
@pytest.mark.parametrize("angle", [1.5, 0.2, -0.7])
def test_no_thread_passes_through_another(speed_m_s, angle):
    ends = {}
    for net_contact in (True, False):
        model = two_threads(net_contact=net_contact)
        state = fly(EdgeListEngine(model), crossed(model, (0.1, 0.0, -speed_m_s), angle=angle, shift_m=0.1), 0.04)
        ends[net_contact] = over(state)
    assert ends[False] < 0.0, "without contact it falls through"
    assert ends[True] > TOUCH_M, "with it, it bounces off, if need be from beyond the other: a spring of 5 kN/m"


def test_a_thread_that_went_through_within_a_step_comes_back_on_its_own_side():
    sides = {}
    for remembers in (True, False):
        model = two_threads()
        engine, state = EdgeListEngine(model), crossed(model, (0.0, 0.0, -1.0), above_m=0.006)
        fly(engine, state, 0.002)
        assert state.crossed_count[0] == 1
        assert 0.0 < over(state) < TOUCH_M
        state.knot_pos[0, 2, 2:] -= over(state) + 0.002  # what a jerk does in one step
        if not remembers:
            state.crossed_count[0] = 0
        sides[remembers] = over(fly(engine, state, 0.05))
    assert sides[True] > TOUCH_M
    assert sides[False] < -TOUCH_M, "without its memory it is pushed out on the other side"


def test_threads_that_turn_through_the_parallel_keep_their_sides():
    """The mixed product's sign changes, the side does not."""
    model = two_threads()
    state = crossed(model, (0.0, 0.0, 0.0), above_m=0.0045, angle=0.05)
    state.knot_vel[0, 1, 2:] = 10.0, -10.0
    state.knot_vel[0, 2, 2:] = -0.5
    fly(EdgeListEngine(model), state, 0.02)
    assert state.knot_pos[0, 1, 2] > 0.1, "it has turned through the parallel"
    assert over(state) > TOUCH_M


@pytest.mark.parametrize("angle", [1.5, 0.1])
def test_momentum_and_angular_momentum_are_kept_to_rounding(angle):
    model = two_threads(friction=0.6, viscosity_s=1e-5)
    state = crossed(model, (0.7, 0.4, -0.9), angle=angle, above_m=0.006, shift_m=0.05)
    linear, angular = audit.linear_momentum(model, state), audit.angular_momentum(model, state)
    slide, touched = state.knot_vel[0, :2].copy(), 0
    for _ in range(20):
        fly(EdgeListEngine(model), state, 0.001)
        touched += int(state.crossed_count[0])
    assert touched
    assert np.abs(state.knot_vel[0, :2] - slide).max() > 0.01, "friction must have acted"
    assert np.abs(audit.linear_momentum(model, state) - linear).max() < 1e-15
    assert np.abs(audit.angular_momentum(model, state) - angular).max() < 1e-15


def test_friction_is_mu_times_the_normal_force_and_no_more():
    """Impulses of a bounce that slides all the time."""
    for friction, speed in ((0.3, 4.0), (0.6, 4.0), (0.6, 0.02)):
        model = two_threads(friction=friction)
        state = crossed(model, (speed, 0.0, -0.5), angle=np.pi / 2)
        before = state.knot_vel.copy()
        fly(EdgeListEngine(model), state, 0.03)
        assert state.crossed_count[0] == 0
        gained = KNOT_KG * (state.knot_vel - before)[0, :, 2:].sum(axis=1)
        along, normal = abs(gained[0]), gained[2]
        assert along <= friction * normal * 1.002  # the normal has turned a little
        assert (along > 0.9 * friction * normal) == (speed > 1.0), "the slow one sticks"


def energies(model: Model, state: State) -> float:
    return float((audit.kinetic_energy(model, state) + audit.elastic_energy(model, state))[0])


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_bounce_gives_no_energy_and_loses_what_damper_and_friction_take(friction):
    for viscosity in (0.0, 1e-4):
        model = two_threads(friction=friction, viscosity_s=viscosity)
        state = crossed(model, (0.5, 0.2, -0.5), shift_m=0.1)
        before = energies(model, state)
        for _ in range(60):
            fly(EdgeListEngine(model), state, 0.0005)
            assert energies(model, state) < 1.05 * before, "a step is a tenth of the spring's period over 2 pi"
        after = energies(model, state)
        assert state.crossed_count[0] == 0
        lossless = friction == viscosity == 0.0
        assert after == pytest.approx(before, rel=0.02) if lossless else 0.2 * before < after < 0.97 * before


def test_a_thread_that_comes_to_lie_near_another_over_its_end_is_given_no_energy():
    """It slips in from the side, past the other's end, at a millimetre's distance."""
    model = two_threads()
    state = crossed(model, (-1.0, 0.0, 0.0), above_m=0.001, shift_m=0.505)
    before = energies(model, state)
    touched = 0
    for _ in range(40):
        fly(EdgeListEngine(model), state, 0.0005)
        touched += int(state.crossed_count[0])
    assert touched
    assert energies(model, state) == pytest.approx(before, rel=1e-6)
    assert state.knot_vel[0, 0, 2:] == pytest.approx(-1.0, rel=1e-3)


def crumpled(model: Model, seed: int = 0) -> State:
    """A grid folded to a heap in which threads move in all directions and touch from the start."""
    random = np.random.default_rng(seed)
    state = flat_state(model)
    state.knot_pos *= 0.03
    state.knot_pos += random.normal(0.0, 0.025, state.knot_pos.shape)
    state.knot_vel[:] = random.normal(0.0, 1.0, state.knot_vel.shape)
    return state


def test_both_engines_and_any_lists_find_the_same_contacts():
    """Flown in one go, step by step with lists made anew at each, and by the other engine."""
    model = grid_model(9, 12, net_contact=True)
    states = [crumpled(model) for _ in range(3)]
    seen = 0
    for _ in range(6):
        fly(GridEngine(model), states[0], 50 * STEP_S)
        fly(EdgeListEngine(model), states[1], 50 * STEP_S)
        for _ in range(50):
            fly(GridEngine(model), states[2], STEP_S)
        pairs = [{tuple(row[:2]) for row in state.crossed[0, : state.crossed_count[0]]} for state in states]
        assert pairs[0] == pairs[1] == pairs[2]
        seen += len(pairs[0])
    assert seen > 60
    for other in states[1:]:
        assert np.abs(other.knot_pos - states[0].knot_pos).max() < 1e-9


def test_a_crumpled_net_passes_through_itself_four_times_less_at_least():
    passes = {}
    for net_contact in (True, False):
        model = grid_model(9, 12, net_contact=net_contact)
        state, passes[net_contact] = crumpled(model), 0
        for _ in range(100):
            before = state.knot_pos[0].copy()
            fly(GridEngine(model), state, 0.001)
            passes[net_contact] += count_passes(before, state.knot_pos[0], model.arrays.threads)
    assert passes[False] > 100
    assert passes[True] <= 0.25 * passes[False], "most of these are pushed back from where the heap was made"


def test_more_contacts_than_there_is_room_for_are_all_kept_with_the_same_bits():
    model = grid_model(9, 12, net_contact=True)
    rooms = (0, 3, 5000)
    states = []
    for room in rooms:
        state = crumpled(model)
        state.crossed = np.zeros((1, room, RECORD))
        states.append(fly(GridEngine(model), state, 0.02))
        assert state.crossed.shape[1] >= max(state.crossed_count[0], room)
    assert states[0].crossed_count[0] > rooms[1]
    for state in states[:2]:
        assert state.knot_pos.tobytes() == states[2].knot_pos.tobytes()
        assert state.crossed_count[0] == states[2].crossed_count[0]


def test_a_scenario_among_others_has_the_same_bits():
    model = grid_model(9, 12, net_contact=True)
    alone = fly(GridEngine(model), crumpled(model, 1), 0.02)
    both = crumpled(model, 0)
    for name in ("knot_pos", "knot_vel", "mu_pos", "mu_vel", "bodies", "bristle", "crossed", "crossed_count"):
        setattr(both, name, np.concatenate([getattr(both, name), getattr(crumpled(model, 1), name)]))
    for name in ("closing", "tether_length", "pair_length", "locked", "winch_length", "contacts"):
        setattr(both, name, np.repeat(getattr(both, name), 2, axis=0))
    fly(GridEngine(model), both, 0.02)
    assert both.knot_pos[1].tobytes() == alone.knot_pos[0].tobytes()


def test_the_work_of_net_on_net_is_booked():
    world = make_world(4, debris=(0.0, 0.0, -200.0), **ON)
    random = np.random.default_rng(0)
    world.state.knot_pos += random.normal(0.0, 0.02, world.state.knot_pos.shape)
    world.state.knot_vel[:] = random.normal(0.0, 0.5, world.state.knot_vel.shape)
    auditor = Auditor()
    auditor.attach(world)
    for _ in range(4):
        world.advance(np.zeros((1, 4, 3)))
    balance = auditor.balance()
    assert balance.work == pytest.approx(balance.gained, rel=1e-9)
    lost = balance.lost["net on net"]
    assert lost > 0.01
    assert abs(balance.residual) < 0.02 * lost
    assert balance.lost["contact"] == balance.lost["friction"] == 0.0


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        ("net_contact", "knots", "one of none, threads"),
        ("net_contact_distance_m", 0.0, "0.0001 to 0.05"),
        ("net_contact_distance_m", 0.2, "0.0001 to 0.05"),
        ("net_contact_stiffness_n_m", -1.0, "1 to 1e"),
    ],
)
def test_bad_values_are_refused(name, value, allowed):
    with pytest.raises(ParameterError, match=name) as refused:
        load(PhysicsParameters, {name: value})
    assert allowed in str(refused.value)


@pytest.mark.parametrize("system", ["zenit_8mu", "zenit_4mu", "zenit_8mu_winch", "hexagonal_6mu", "envisat_8mu"])
def test_the_default_contact_needs_no_smaller_step(system):
    settings = Settings.load(system, physics=ON)
    assert (settings.physics.net_contact, settings.physics.time_step_s) == ("threads", 1e-4)


def test_a_stiffer_contact_needs_a_smaller_step_and_is_refused():
    with pytest.raises(ParameterError, match=r"time_step_s = 0.0001: unstable.*allowed: at most"):
        Settings.load("zenit_8mu", physics=ON | {"net_contact_stiffness_n_m": 2e4})
    Settings.load("zenit_8mu", physics={"net_contact_stiffness_n_m": 2e4})
    world = make_world(8)
    off = load(PhysicsParameters)
    assert largest_step_of(world.system, off) == largest_step(world.model)
    assert largest_step(make_world(8, **ON).model) < largest_step(world.model)


def test_the_memory_that_it_takes_is_counted():
    off, on = make_world(4).model, make_world(4, **ON).model
    assert scenario_bytes(on) > scenario_bytes(off)
    assert work_bytes(on) > work_bytes(off) + 100 * len(on.arrays.threads)
