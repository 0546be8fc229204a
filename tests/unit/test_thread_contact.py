"""Threads that touch the debris: what a net of knots alone lets through."""

from __future__ import annotations

import numpy as np
import pytest

from tests.engines import ENGINES, make_model
from tethernet_core.rotation import inverse, rotate
from tethernet_core.shapes import Box, Capsule, Compound, Cone, Cylinder, Part, Shape, Sphere
from tethernet_core.system import load_system, shipped_systems
from tethernet_sim import audit
from tethernet_sim.debris import debris_body, surface_distance
from tethernet_sim.engine import Commands, EdgeListEngine
from tethernet_sim.fly import Settings, fly, fly_many
from tethernet_sim.kernels.crossing_work import RECORD
from tethernet_sim.model import Model, build_model
from tethernet_sim.scenario import Scenario
from tethernet_sim.stability import largest_step
from tethernet_sim.state import State

KNOTS, THREADS = {"contact": "knots"}, {"contact": "threads"}
RADIUS_M = 0.001


def thread_on(shape: Shape, *, friction: float = 0.0, units: int = 0, mass_kg: float = 100.0) -> Model:
    """One slack thread of 1 m between two knots; its middle may touch a debris of any shape."""
    model = make_model(2, [(0, 1)], rest=2.0, units=units)
    ends = np.array([(0, 1), *((m % 2, 2 + m) for m in range(units))], np.int64)
    numbers = model.numbers._replace(
        open_segments=len(ends), half_longest=1.1, contact_stiffness=1e4, contact_damping_ratio=0.2,
        knot_radius=0.02, friction=friction,
    )  # fmt: skip
    arrays = model.arrays._replace(
        segments=ends, segment_radius=np.full(len(ends), RADIUS_M), segment_stiffness=np.full(len(ends), 5e3)
    )
    body = debris_body(shape, mass_kg)
    return model._replace(numbers=numbers, arrays=arrays, debris=body)


def laid(model: Model, first, second, velocity, position=(0.0, 0.0, 0.0)) -> State:
    """The thread from the one place to the other, moving as a whole; the debris at ``position``, not turned."""
    units = len(model.arrays.mu_knot)
    bodies = np.zeros((1, 2, 13))
    bodies[0, 0, :3], bodies[0, 1, :3], bodies[0, :, 9] = position, (0.0, 0.0, 50.0), 1.0
    knots = np.array([first, second], float).T
    return State(
        knot_pos=knots[None].copy(), knot_vel=np.repeat(np.array(velocity, float)[None, :, None], 2, axis=2),
        mu_pos=knots.T[None, model.arrays.mu_knot] + [0.0, 0.0, 0.4], mu_vel=np.zeros((1, units, 3)), bodies=bodies,
        bristle=np.zeros((1, model.contact_count, 3)), crossed=np.zeros((1, 0, RECORD)),
        crossed_count=np.zeros(1, np.int64), closing=np.zeros(1, bool), tether_length=np.zeros(1),
        pair_length=np.zeros((1, 0)), locked=np.zeros((1, 0), bool), winch_length=np.zeros((1, 0)),
        contacts=np.zeros(1, np.int64),
    )  # fmt: skip


def depths(model: Model, state: State) -> np.ndarray:
    """How deep the axis of each thread of the net and the units lies in the debris at its deepest point [m]."""
    position, _ = audit.particles(state)
    ends, share = position[0, model.arrays.segments[: model.numbers.open_segments]], np.linspace(0.0, 1.0, 101)[:, None]
    points = ends[:, :1] * (1.0 - share) + ends[:, 1:] * share
    debris = state.bodies[0, 0]
    local = rotate(inverse(debris[6:10])[None], points.reshape(-1, 3) - debris[:3])
    return -surface_distance(model.debris, local).reshape(len(points), -1).min(axis=1)


def advance(model: Model, state: State, duration_s: float) -> None:
    EdgeListEngine(model).advance(state, Commands.of_thrust(np.zeros_like(state.mu_pos)), duration_s)


CYLINDER = Cylinder(0.3, 1.0)
BOX = Box((0.2, 3.0, 0.2))
TWO_BOXES = Compound((Part(Box((0.1, 1.0, 0.4)), (-0.25, 0.0, 0.0)), Part(Box((0.1, 1.0, 0.4)), (0.25, 0.0, 0.0))))


@pytest.mark.parametrize(
    ("shape", "height"),
    [
        (Sphere(0.3), 0.3), (CYLINDER, 0.5), (BOX, 0.1), (TWO_BOXES, 0.2),
        (Capsule(0.2, 1.0), None), (Cone(0.3, 1.0, 0.1), None),
    ],
)  # fmt: skip
def test_a_thread_whose_knots_miss_every_shape_is_stopped_by_it(shape, height):
    model = thread_on(shape)
    if height is None:
        height = shape.exit_distance(np.array([[0.0, 0.0, 1.0]]))[0]
    state = laid(model, (-0.5, 0.0, height + 0.02), (0.5, 0.03, height + 0.02), (0.0, 0.0, -0.5))
    deepest = -1.0
    for _ in range(200):
        advance(model, state, 0.001)
        deepest = max(deepest, float(depths(model, state).max()))
    # A spring of 5 kN/m takes the 10 g at 0.5 m/s in within 0.7 mm.
    assert 0.0 < deepest + RADIUS_M < 0.001
    assert (state.knot_vel[0, 2] > 0.0).all(), "it must have bounced off"


def test_momentum_and_angular_momentum_are_kept_to_rounding():
    model = thread_on(CYLINDER, friction=0.6, units=2)
    state = laid(model, (-0.5, 0.1, 0.52), (0.5, 0.2, 0.51), (0.3, -0.1, -0.8))
    linear, angular = audit.linear_momentum(model, state), audit.angular_momentum(model, state)
    touched = 0
    for _ in range(50):
        advance(model, state, 0.002)
        touched += int(state.contacts[0] > 0)
    assert touched
    assert np.abs(audit.linear_momentum(model, state) - linear).max() < 1e-13 * np.abs(linear).max() * 100
    assert np.abs(audit.angular_momentum(model, state) - angular).max() < 1e-12 * np.abs(angular).max() * 100
    assert np.linalg.norm(state.bodies[0, 0, 10:13]) > 1e-4, "the debris must have been turned"


def test_a_bounce_does_not_gain_energy():
    for damping in (0.0, 0.3):
        model = thread_on(BOX)
        model = model._replace(numbers=model.numbers._replace(contact_damping_ratio=damping))
        state = laid(model, (-0.5, 0.0, 0.13), (0.5, 0.05, 0.13), (0.0, 0.0, -0.5))
        before = float(audit.kinetic_energy(model, state)[0])
        advance(model, state, 0.25)
        assert not state.contacts[0]
        after = float(audit.kinetic_energy(model, state)[0])
        # A bounce of an undamped spring, its contact point looked for every ms, keeps the energy to 2 %.
        assert (0.98 * before if damping == 0.0 else 0.05 * before) < after < (1.02 if damping == 0.0 else 0.9) * before


def over_an_edge(seed: int, slide_m_s: float) -> tuple[float, float, bool]:
    """Energy [J] before and after a thread was thrown over an edge, without friction and damping, and whether it
    touched; it slides along itself.
    """
    random = np.random.default_rng(seed)
    shape, edge = (CYLINDER, (0.3, 0.0, 0.5)) if seed % 2 else (BOX, (0.1, 0.0, 0.1))
    model = thread_on(shape, mass_kg=1e6)
    model = model._replace(
        numbers=model.numbers._replace(contact_damping_ratio=0.0, knot_radius=0.0),
        arrays=model.arrays._replace(damping=np.zeros(1), rest=np.array([0.8]), contact_damping=np.zeros(2)),
    )
    outward, along = np.array([np.sqrt(0.5), 0.0, np.sqrt(0.5)]), np.array([0.0, 1.0, 0.0])
    turn, lift, share = random.uniform(-1.0, 1.0), random.uniform(-0.5, 0.5), random.uniform(0.2, 0.8)
    way = np.cos(turn) * np.cross(outward, along) + np.sin(turn) * along + lift * outward
    way /= np.linalg.norm(way)
    place = np.array(edge) + 0.005 * outward
    velocity = slide_m_s * way - random.uniform(1.0, 3.0) * outward + random.normal(0.0, 0.5, 3)
    state = laid(model, place - 0.8 * share * way, place + 0.8 * (1.0 - share) * way, velocity)
    before = float(audit.kinetic_energy(model, state)[0])
    touched = 0
    for _ in range(30):
        advance(model, state, 0.001)
        touched += int(state.contacts[0])
        if touched and not state.contacts[0] and depths(model, state).max() < -0.005:
            break
    after = float(audit.kinetic_energy(model, state)[0] + audit.elastic_energy(model, state)[0])
    return before, after, touched > 0


@pytest.mark.parametrize("slide_m_s", [0.0, 5.0, 20.0])
def test_an_edge_gives_no_energy_to_a_thread_that_crosses_it(slide_m_s):
    """The normal changes at an edge at once. That of one side alone drives a thread along itself for ever."""
    before, after, touched = np.array([over_an_edge(seed, slide_m_s) for seed in range(40)]).T
    assert touched.mean() > 0.5
    assert after.sum() == pytest.approx(before.sum(), rel=0.03)
    assert (after < 1.1 * before + 2e-3).all()


def test_a_thread_that_lies_across_a_narrow_face_rests_on_both_edges():
    model = thread_on(BOX)
    state = laid(model, (-0.5, 0.0, 0.1005), (0.5, 0.0, 0.1005), (0.0, 0.0, -0.05))
    advance(model, state, 1e-3)
    assert state.contacts[0] == 2


@pytest.mark.parametrize(("friction", "slows"), [(0.0, False), (0.8, True)])
def test_friction_acts_where_the_thread_touches(friction, slows):
    """Pressed on by its arrival: Coulomb's law takes mu times the change of speed along the normal."""
    model = thread_on(Sphere(0.3), friction=friction, mass_kg=1e6)
    state = laid(model, (-0.5, 0.0, 0.31), (0.5, 0.0, 0.31), (0.0, 1.0, -0.2))
    advance(model, state, 0.1)
    normal, along = state.knot_vel[0, 2].mean() + 0.2, 1.0 - state.knot_vel[0, 1].mean()
    if slows:
        assert along == pytest.approx(friction * normal, rel=0.1)
    else:
        assert abs(along) < 1e-2  # the sphere falls away under the thread that slides across its top


@pytest.mark.parametrize("name", shipped_systems())
def test_a_knot_with_its_threads_is_no_harder_than_a_knot_alone(name):
    """So that threads may touch in every shipped net, with its own step and nothing else changed."""
    system = load_system(name)
    alone, both = (build_model(system, Settings.load(system, physics=p).physics) for p in (KNOTS, THREADS))
    nodes = alone.numbers.knots
    ends, stiffness = both.arrays.segments, both.arrays.segment_stiffness
    added = np.bincount(ends.ravel(), np.repeat(stiffness, 2))
    assert (added + both.numbers.contact_stiffness).max() == pytest.approx(alone.numbers.contact_stiffness)
    masses = 1.0 / both.arrays.inverse_mass[ends.ravel()]
    dampers = 2.0 * both.numbers.contact_damping_ratio * np.sqrt(np.repeat(stiffness, 2) * masses)
    dampers = np.bincount(ends.ravel(), dampers)[:nodes] + both.arrays.contact_damping[:nodes]
    assert (dampers <= alone.arrays.contact_damping[:nodes] * (1.0 + 1e-12)).all()
    assert largest_step(both) >= largest_step(alone)


@pytest.mark.parametrize("engine", ENGINES)
def test_knots_alone_need_no_list_of_threads(engine):
    model = make_model(4, [(0, 1), (2, 3), (0, 2), (1, 3)], grid=(2, 2))
    assert model.contact_count == 4
    ENGINES[engine](model)


def compliance(model: Model, state: State) -> np.ndarray:
    """How far each thread of the net and the units can be pressed into the debris by the threads at its ends [m]: on
    both sides one that pulls straight back, with the largest tension there is at either end.
    """
    net, units = audit.thread_lengths(model, state)
    arrays, ends = model.arrays, model.arrays.segments[: model.numbers.open_segments]
    tension = np.concatenate(
        [
            arrays.stiffness * np.maximum(net[0] - arrays.rest, 0.0),
            arrays.mu_stiffness * np.maximum(units[0] - arrays.mu_thread, 0.0),
        ]
    )
    largest = np.zeros(len(arrays.inverse_mass))
    np.maximum.at(largest, ends.ravel(), np.repeat(tension, 2))
    return 2.0 * largest[ends].max(axis=1) / arrays.segment_stiffness[: len(ends)]


@pytest.mark.parametrize("name", ["zenit_8mu", "zenit_4mu"])
def test_no_thread_of_a_mission_cuts_into_the_debris(name):
    """Not 5 mm beyond what the springs of its contact yield under the threads that press it on."""
    deepest, beyond = {}, {}
    for contact, physics in (("knots", KNOTS), ("threads", THREADS)):
        found = [(0.0, 0.0)]
        model = build_model(load_system(name), Settings.load(name, physics=THREADS).physics)

        def look(_stamp_ns, world, _flying, found=found, model=model):
            if world.state.contacts[0]:
                depth = depths(model, world.state)
                found.append((float(depth.max()), float((depth - compliance(model, world.state)).max())))

        outcome = fly(Scenario(name), Settings.load(name, physics=physics), look)
        assert outcome.captured, outcome.verdict
        deepest[contact], beyond[contact] = np.max(found, axis=0)
    assert deepest["knots"] > 0.1
    assert deepest["threads"] < 0.05
    assert beyond["threads"] < 0.005
    assert beyond["knots"] > 0.1, "so the bound tells them apart"


def test_a_scenario_flies_the_same_bits_alone_and_among_others():
    settings = Settings.load("zenit_8mu", physics=THREADS, mission={"capture_duration_s": 2.0})
    scenarios = [Scenario("zenit_8mu", seed=seed, debris_position=(0.1 * seed, 0.0, -50.0)) for seed in range(3)]
    assert fly_many(scenarios, settings)[2] == fly(scenarios[2], settings)
