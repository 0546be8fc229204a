"""Models of described systems."""

from __future__ import annotations

import numpy as np
import pytest

from tests.physics import make_world
from tethernet_core.system import load_system
from tethernet_sim.debris import inertia_tensor, surface_distance
from tethernet_sim.engine import Commands, EdgeListEngine, GridEngine, engine_for
from tethernet_sim.kernels.cylinder_body import CylinderBody
from tethernet_sim.model import build_model


@pytest.mark.parametrize("mus", [4, 8])
def test_the_papers_systems_have_the_designs_models(mus):
    world = make_world(mus)
    described, design = build_model(load_system(f"zenit_{mus}mu"), world.physics), world.model
    assert described.grid == design.grid
    for part in ("numbers", "arrays"):
        for name, value in getattr(design, part)._asdict().items():
            other = getattr(getattr(described, part), name)
            if name in ("winch_speed", "winch_tension", "winch_stiffness", "joint_pull") and mus == (
                4 if name == "joint_pull" else 8
            ):
                continue  # of a closing that the system does not have
            assert np.asarray(other).shape == np.asarray(value).shape, name
            assert np.allclose(other, value, rtol=1e-12, atol=0.0), name
    assert isinstance(engine_for(described), GridEngine)


@pytest.mark.parametrize("mus", [4, 8])
def test_a_described_system_flies(mus):
    world = make_world(mus)
    final = []
    for model in (world.model, build_model(load_system(f"zenit_{mus}mu"), world.physics)):
        state = make_world(mus).state
        engine_for(model).advance(state, Commands.of_thrust(np.full((1, mus, 3), 1.0)), 0.05)
        final.append(state.mu_pos)
    assert np.allclose(final[0], final[1], rtol=0.0, atol=1e-12)


def test_a_hexagonal_net_goes_to_the_edge_list():
    model = build_model(load_system("hexagonal_6mu"), make_world(8).physics)
    assert model.grid is None
    assert isinstance(engine_for(model), EdgeListEngine)


def test_a_passive_net_has_no_units():
    model = build_model(load_system("passive_5m"), make_world(8).physics)
    assert len(model.arrays.mu_mass) == 0
    assert model.arrays.knot_mass.max() > 10.0 * np.median(model.arrays.knot_mass), "masses hang at its corners"


def test_the_debris_is_the_described_body():
    physics = make_world(8).physics
    for name in ("envisat_8mu", "passive_5m", "zenit_8mu"):
        debris = load_system(name).debris
        body = build_model(load_system(name), physics).debris
        assert body.mass == debris.mass_kg
        assert isinstance(body, CylinderBody) == (debris.shape.kind == "cylinder")
        np.testing.assert_allclose(inertia_tensor(body), debris.inertia, rtol=1e-12, atol=1e-9)
        points = np.random.default_rng(1).uniform(-20.0, 20.0, (500, 3))
        expected = debris.shape.distance(points + debris.center_of_mass)[0]
        np.testing.assert_allclose(surface_distance(body, points), expected, atol=1e-10)
