"""The largest stable step, and what is refused before it flies."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.physics import make_world
from tethernet_core.parameters import ParameterError, load
from tethernet_core.settings import ControlParameters
from tethernet_sim.fly import Settings
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.stability import Springs, largest_step, largest_step_of, net_springs


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
    model, physics = world.model, world.physics
    mass, stiffness, damping = (
        model.arrays.knot_mass, physics.thread_stiffness_n_m, physics.thread_damping_n_s_m,
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


def test_the_default_step_has_a_margin_for_both_designs():
    physics = load(PhysicsParameters)
    for mus in (4, 8):
        assert largest_step(make_world(mus).model) >= largest_step_of(physics)
    assert physics.time_step_s < 0.997 * largest_step_of(physics)


@pytest.mark.parametrize(
    "values",
    [
        {"thread_modulus_pa": 1.4e11}, {"thread_damping_ratio": 0.5}, {"contact_stiffness_n_m": 1e5},
        {"thread_density_kg_m3": 500.0}, {"time_step_s": 1.25e-4}, {"winch_stiffness_n_m": 2e4},
        {"joint_stiffness_n_m": 2e4, "joint_damping_ratio": 1.0},
        {"tether_damping_n_s_m": 10.0},
    ],
)  # fmt: skip
def test_what_would_diverge_is_refused_with_the_step_that_is_allowed(values):
    with pytest.raises(ParameterError, match=r"\.time_step_s = .*unstable.*allowed: at most") as refused:
        Settings.load(physics=values)
    largest = float(str(refused.value).split("at most ")[1].split(" s")[0])
    period = load(ControlParameters).control_period_s
    Settings.load(physics={**values, "time_step_s": period / math.ceil(period / largest)})


def test_a_net_of_another_mesh_is_refused():
    with pytest.raises(ParameterError, match=r"mesh_m = 0.5: .*allowed: 1 m"):
        Settings.load(physics={"mesh_m": 0.5})


@pytest.mark.parametrize(("body", "target"), [("radius", "target_radius_m"), ("length", "target_length_m")])
def test_a_debris_of_another_size_than_planned_for_is_refused(body, target):
    with pytest.raises(ParameterError, match=f"debris_{body}_m = 1.5, .*{target}"):
        Settings.load(physics={f"debris_{body}_m": 1.5})
    Settings.load(physics={f"debris_{body}_m": 1.5}, mission={target: 1.5})


def test_a_step_that_does_not_divide_the_control_period_is_refused():
    with pytest.raises(ParameterError, match="does not divide the control period"):
        Settings.load(physics={"time_step_s": 9.03e-5})
