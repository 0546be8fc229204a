"""What the MUs' odometry tells where nothing measures the net."""

from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters
from tethernet_core.system import load_system
from tethernet_planner.swarm import DockedPairs, SwarmCentroid

MS = 1_000_000
CONTROL = load(ControlParameters)
PERIOD = CONTROL.period_ns


def test_a_tick_is_complete_when_every_mu_has_given_a_newer_sample():
    swarm = SwarmCentroid(4, CONTROL)
    assert swarm.missing == {1, 2, 3, 4}
    for mu in (1, 2, 3):
        assert swarm.update(mu, (100 + mu) * MS, (float(mu), 0.0, 0.0)) is None
    assert swarm.missing == {4}
    tick = swarm.update(4, 104 * MS, (6.0, 0.0, -8.0))
    assert tick.stamp_ns == 104 * MS
    assert tick.position == (3.0, 0.0, -2.0)
    assert [swarm.update(mu, (150 + mu) * MS, (1.0, 2.0, 3.0)) for mu in (1, 2, 4, 1, 2)] == [None] * 5
    assert swarm.update(3, 149 * MS, (1.0, 2.0, 3.0)).position == (1.0, 2.0, 3.0)


def test_samples_out_of_order_are_ignored():
    swarm = SwarmCentroid(4, CONTROL)
    swarm.update(1, 100 * MS, (1.0, 0.0, 0.0))
    assert swarm.update(1, 50 * MS, (9.0, 0.0, 0.0)) is None
    assert swarm.positions[1] == (1.0, 0.0, 0.0)


def test_an_mu_that_falls_silent_is_left_out():
    swarm = SwarmCentroid(4, CONTROL)
    ticks = []
    for sample in range(20):
        for mu in (1, 2, 3, 4):
            if mu != 3 or sample < 5:
                ticks.append(swarm.update(mu, (sample * 50 + mu) * MS, (float(mu), 0.0, 0.0)))
    ticks = [tick for tick in ticks if tick is not None]
    assert ticks[4].position[0] == 2.5
    assert ticks[-1].position[0] == (1 + 2 + 4) / 3
    assert len(ticks) > 12
    assert set(swarm.behind) == {3}


def test_pairs_dock_for_good_in_their_order_round_the_mouth():
    pairs = DockedPairs(load_system("zenit_8mu"))
    apart = {mu: (10.0 * mu, 0.0, 0.0) for mu in range(1, 9)}
    assert pairs.update(apart) == 0
    assert pairs.update({**apart, 5: (10.4, 0.0, 0.0)}) == 1  # 1 and 5 are neighbours
    assert pairs.docked == {(1, 5)}
    assert pairs.update({**apart, 2: (10.4, 0.0, 0.0)}) == 1  # 1 and 2 are not; (1, 5) stays
    assert pairs.update({mu: (0.0, 0.0, 0.1 * mu) for mu in range(1, 9)}) > 1


def test_winches_pairs_cannot_be_seen_from_the_mus():
    assert DockedPairs(load_system("zenit_4mu")).update(dict.fromkeys(range(1, 5), (0.0, 0.0, 0.0))) == 0


def test_those_in_step_with_the_ticks_are_waited_for_until_they_are_silent():
    swarm = SwarmCentroid(8, CONTROL)
    assert swarm.awaited(0, PERIOD) == set(), "nobody knows of them"
    for mu in (1, 2, 3):
        swarm.update(mu, 10 * PERIOD, (0.0, 0.0, 0.0))
    swarm.update(4, 10 * PERIOD + 1, (0.0, 0.0, 0.0))
    assert swarm.awaited(10 * PERIOD, PERIOD) == set()
    assert swarm.awaited(11 * PERIOD, PERIOD) == {1, 2, 3}, "MU 4 has a clock of its own"
    swarm.update(1, 11 * PERIOD, (0.0, 0.0, 0.0))
    assert swarm.awaited(11 * PERIOD, PERIOD) == {2, 3}
    assert swarm.awaited(15 * PERIOD, PERIOD) == {1, 2, 3}
    assert swarm.awaited(16 * PERIOD, PERIOD) == {1}, "MU 2 and MU 3 have fallen silent"


class Swarm:
    """Eight MUs in step, and what is dropped of them."""

    def __init__(self):
        self.dropped = []
        self.swarm = SwarmCentroid(8, CONTROL, lambda what, why: self.dropped.append((what, why)))

    def tick(self, number, **stamps):
        """One sample of each MU; a stamp of its own for some of them; returns the ticks that were completed."""
        taken = [
            self.swarm.update(mu, stamps.get(f"mu{mu}", number * PERIOD), (float(mu), 0.0, 0.0)) for mu in range(1, 9)
        ]
        return [tick.stamp_ns for tick in taken if tick is not None]


def test_one_stamp_from_the_future_moves_nobodys_time():
    made = Swarm()
    assert [made.tick(k) for k in range(20)] == [[k * PERIOD] for k in range(20)]
    assert made.tick(20, mu3=10**18) == []
    assert made.swarm.newest_ns == 20 * PERIOD
    assert [what for what, _ in made.dropped] == ["odometry of MU 3"]
    assert made.tick(21) == [21 * PERIOD]
    assert made.swarm.behind == {}


def test_a_wild_first_stamp_is_overcome():
    made = Swarm()
    made.tick(0, mu3=10**18)
    for k in range(1, 10):
        made.tick(k)
    assert made.swarm.behind == {}
    assert made.tick(10) == [10 * PERIOD]


def test_an_mu_with_another_clock_is_left_out_and_the_others_fly_on():
    made = Swarm()
    for k in range(20):
        made.tick(k)
    ticks = [made.tick(k, mu3=10**18 + k * PERIOD) for k in range(20, 40)]
    assert ticks[-1] == [39 * PERIOD]
    assert set(made.swarm.behind) == {3}
    assert made.swarm.behind[3] < 0


def test_all_clocks_set_anew_are_followed():
    made = Swarm()
    for k in range(1000, 1020):
        made.tick(k)
    ticks = [made.tick(k) for k in range(20)]
    assert ticks[-1] == [19 * PERIOD]
    assert made.swarm.behind == {}
