"""The largest stable step, and what is refused before it flies."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.physics import make_world
from tethernet_core.parameters import ParameterError, load
from tethernet_core.settings import ControlParameters
from tethernet_core.system import load_system, shipped_systems
from tethernet_sim.fly import Settings
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.stability import Springs, largest_step_of, net_springs


def grows(stiffness: float, damping: float, step: float) -> bool:
    """Whether semi-implicit Euler diverges for one mass of 1 kg on a spring and damper."""
    place, speed = 1.0, 0.0
    for _ in range(4000):
        speed -= step * (stiffness * place + damping * speed)
        place += step * speed
    return not abs(place) + step * abs(speed) < 1e3


@pytest.mark.parametrize("damping", [0.0, 20.0, 150.0])
def test_the_limit_of_one_mass_is_where_it_begins_to_diverge(damping):
    stiffness = 1e4
    springs = Springs(np.array([1.0]))
    springs.to_ground(stiffness, damping)
    springs.between([0], [0], 0.0, 0.0)
    limit = springs.largest_step()
    assert limit == pytest.approx(4.0 / (damping + math.sqrt(damping**2 + 4.0 * stiffness)), rel=1e-12)
    assert not grows(stiffness, damping, 0.995 * limit)
    assert grows(stiffness, damping, 1.005 * limit)


def test_the_bound_of_the_whole_net_is_its_largest_eigenvalue():
    world = make_world(8)
    model = world.model
    mass, stiffness, damping = (
        model.arrays.knot_mass, world.system.net.thread_stiffness[0], world.system.net.thread_damping[0],
    )  # fmt: skip
    matrix = np.zeros((529, 529))
    index = np.arange(529).reshape(23, 23)
    for a, b in [*zip(index[:, :-1].flat, index[:, 1:].flat), *zip(index[:-1].flat, index[1:].flat)]:  # noqa: B905
        matrix[[a, b], [a, b]] += 1.0
        matrix[[a, b], [b, a]] -= 1.0
    top = np.linalg.eigvalsh(matrix / np.sqrt(mass[:, None] * mass))[-1]
    exact = 4.0 / (damping * top + math.sqrt((damping * top) ** 2 + 4.0 * stiffness * top))
    bound = net_springs(model).largest_step()
    assert bound <= exact * (1.0 + 1e-12)
    assert bound == pytest.approx(exact, rel=1e-3)


def collapsed(step: float) -> float:
    """How far the middle of a net whose taut threads all lie along one line is from there after 9 steps, for a ripple
    of a micrometre at the start [m]."""
    world = make_world(4, debris=(0.0, 0.0, -200.0))
    world.model = world.engine.model = world.model._replace(
        numbers=world.model.numbers._replace(time_step=step),
        arrays=world.model.arrays._replace(kick=step / world.model.arrays.knot_mass),
    )
    row, column = np.divmod(np.arange(529), 23)
    line = (row + column) * 1.001
    state = world.state
    state.knot_pos[0] = np.array([[0.0], [0.0], [-1.5]])
    state.knot_pos[0, 0] = line + 1e-6 * (-1.0) ** (row + column)
    state.mu_pos[0] = state.knot_pos[0][:, world.model.arrays.mu_knot].T
    world.steps = 9
    world.advance(np.zeros((1, 4, 3)))
    middle = (abs(row - 11) < 2) & (abs(column - 11) < 2)  # the border is not felt there yet
    return float(np.abs(state.knot_pos[0, 0] - line)[middle].max())


def test_a_collapsed_taut_net_is_what_sets_the_limit():
    """Meshes drawn flat are stiffer than a flat net's rim: the old limit of 1.4e-4 s, and 1.25e-4 s, let them grow."""
    assert collapsed(load(PhysicsParameters).time_step_s) < 2e-6
    assert collapsed(1.25e-4) > 2e-5


@pytest.mark.parametrize("name", ["zenit_4mu", "zenit_8mu"])
def test_the_default_step_has_a_margin(name):
    physics = load(PhysicsParameters)
    assert physics.time_step_s < 0.997 * largest_step_of(load_system(name), physics)


@pytest.mark.parametrize("name", shipped_systems())
def test_every_shipped_system_is_stable_with_its_own_step(name):
    system = load_system(name)
    physics = Settings.load(system).physics
    assert physics.time_step_s < largest_step_of(system, physics)


@pytest.mark.parametrize(
    ("hardware", "values"),
    [
        ({"net.thread.modulus_pa": 1.4e11}, {}), ({"net.thread.damping_ratio": 0.5}, {}),
        ({"net.thread.density_kg_m3": 500.0}, {}), ({"closing.winch.stiffness_n_m": 2e4}, {}),
        ({"tether.damping_n_s_m": 10.0}, {}), ({"net.square.mesh_m": 0.5}, {}),
        ({}, {"contact_stiffness_n_m": 1e5}), ({}, {"time_step_s": 1.25e-4}),
        ({}, {"joint_stiffness_n_m": 2e4, "joint_damping_ratio": 1.0}),
    ],
)  # fmt: skip
def test_what_would_diverge_is_refused_with_the_step_that_is_allowed(hardware, values):
    system = load_system("zenit_4mu", hardware)
    with pytest.raises(ParameterError, match=r"\.time_step_s = .*unstable.*zenit_4mu.*allowed: at most") as refused:
        Settings.load(system, physics=values)
    largest = float(str(refused.value).split("at most ")[1].split(" s")[0])
    period = load(ControlParameters).control_period_s
    Settings.load(system, physics={**values, "time_step_s": period / math.ceil(period / largest)})


@pytest.mark.parametrize(
    ("subsystem", "name", "entry"),
    [
        ("physics", "mesh_m", "net.square.mesh_m"), ("physics", "debris_radius_m", "debris.shape.radius_m"),
        ("control", "thrust_limit_n", "unit.thrust_limit_n"), ("mission", "docking_distance_m", "closing.docking"),
    ],
)  # fmt: skip
def test_a_parameter_that_describes_hardware_is_refused_with_its_entry(subsystem, name, entry):
    with pytest.raises(ParameterError, match=f"'{name}' any more: it is {entry}.* of the system"):
        Settings.load(**{subsystem: {name: 1.0}})


def test_an_unknown_subsystem_is_refused():
    with pytest.raises(ParameterError, match=r"'quality'.*allowed: physics, control, mission"):
        Settings.load(quality={"cqi_threshold": 2.0})


def test_a_step_that_does_not_divide_the_control_period_is_refused():
    with pytest.raises(ParameterError, match="does not divide the control period"):
        Settings.load(physics={"time_step_s": 9.03e-5})
