"""Numbers that nobody has measured, drawn at random."""

from __future__ import annotations

import numpy as np
import pytest

from tethernet_core.system import load_system
from tethernet_learning import assumed_numbers
from tethernet_learning.assumed_numbers import GROUP, OF_PHYSICS, OF_SYSTEM, drawn, groups
from tethernet_learning.flight_settings import Flight
from tethernet_learning.policies.capture_sources import RandomlyAssumed
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.seeds import Purpose
from tethernet_sim.fly import Settings
from tethernet_sim.stability import check_stable


def as_described(name):
    system = load_system(name)
    return Flight(system, Settings.load(system, control={"kp": 5.0}))


@pytest.mark.parametrize("name", ["zenit_4mu", "zenit_8mu", "hexagonal_6mu"])
def test_a_draw_is_within_its_ranges_flies_with_a_stable_step_and_leaves_all_else(name):
    base = as_described(name)
    for seed in range(6):
        flight, numbers = drawn(base, seed)
        check_stable(flight.system, flight.settings.physics)
        assert flight.system.net.material.damping_ratio == pytest.approx(numbers["net.thread.damping_ratio"])
        assert 0.05 <= numbers["net.thread.damping_ratio"] <= 0.2
        assert flight.settings.physics.friction_coefficient == numbers["friction_coefficient"]
        assert 0.02 <= flight.settings.physics.fold_factor <= 0.1
        assert 500.0 <= flight.system.tether.stiffness_n_m <= 2000.0
        assert flight.settings.control == base.settings.control
        assert flight.settings.mission == base.settings.mission
        assert np.array_equal(flight.system.net.nodes, base.system.net.nodes)
        winches = base.system.closing.kind == "winch"
        assert ("closing.winch.stiffness_n_m" in numbers) == winches
        assert len(numbers) == len(OF_SYSTEM) + len(OF_PHYSICS) - (not winches)


def test_one_seed_gives_one_draw_and_every_range_is_drawn_from_end_to_end():
    base = as_described("zenit_4mu")
    first, again = drawn(base, 7), drawn(base, 7)
    assert first[1] == again[1]
    assert first[0] == again[0]
    assert first[0].system.digest != drawn(base, 8)[0].system.digest
    draws = [drawn(base, seed)[1] for seed in range(40)]
    for number in (*OF_SYSTEM, *OF_PHYSICS):
        low = number.value(0.0, drawn_from := _described(base, number.name))
        high = number.value(1.0, drawn_from)
        values = np.array([draw[number.name] for draw in draws])
        assert low <= values.min() < values.max() <= high
        shares = np.log(values / low) / np.log(high / low) if number.by_described else (values - low) / (high - low)
        assert shares.min() < 0.15
        assert shares.max() > 0.85


def _described(base, name):
    if name in {number.name for number in OF_PHYSICS}:
        return getattr(base.settings.physics, name)
    content = base.system.content
    for key in name.split("."):
        content = content[key]
    return content


def test_the_same_scenarios_share_draws_whoever_aims_them():
    scenarios = random_scenarios(load_system("zenit_4mu"), Purpose.POLICY_TRAINING, 0, 0, 2 * GROUP + 3)
    found = groups(scenarios)
    assert [len(numbers) for numbers, _ in found] == [GROUP, GROUP, 3]
    assert [seed for _, seed in found] == [scenarios[0].seed, scenarios[GROUP].seed, scenarios[2 * GROUP].seed]
    twice = groups([*scenarios, *scenarios])
    assert [seed for _, seed in twice] == [seed for _, seed in found]
    assert twice[1][0] == [*found[1][0], *(len(scenarios) + number for number in found[1][0])]


def test_episodes_fly_with_the_draw_of_their_group_and_come_back_in_their_order():
    base = as_described("zenit_4mu")
    scenarios = random_scenarios(base.system, Purpose.POLICY_TRAINING, 0, 0, GROUP + 2)
    flown = []

    class Source:
        def fly(self, some, flight=None):
            flown.append(([s.seed for s in some], flight.system.digest))
            numbers = np.array([s.seed for s in some], float)
            return pretended(numbers, base.system)

    mixed = [scenarios[i] for i in (3, 9, 0, 1, 2, 4, 5, 6, 7, 8)]
    result = RandomlyAssumed(Source(), base).fly([*mixed, mixed[0]])
    assert result.fuel_kg.tolist() == [s.seed for s in [*mixed, mixed[0]]]
    assert [len(seeds) for seeds, _ in flown] == [GROUP + 1, 2]
    assert [digest for _, digest in flown] == [
        drawn(base, mixed[0].seed)[0].system.digest, drawn(base, mixed[GROUP].seed)[0].system.digest,
    ]  # fmt: skip
    assert result.system == base.system, "judged as described"


def pretended(numbers, system):
    from tethernet_learning.flown import Flown

    return Flown(system.unit_count, numbers, numbers.astype(int), numbers, numbers, system)


def test_an_unknown_choice_is_refused():
    from tethernet_learning.policies.episode_settings import EpisodeSettings

    with pytest.raises(ValueError, match="assumed 'any'; allowed: described, random"):
        EpisodeSettings(load_system("zenit_4mu"), assumed="any")
    assert assumed_numbers.CHOICES == ("described", "random")
