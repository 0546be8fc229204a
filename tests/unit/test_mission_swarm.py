"""What the MUs' odometry tells where nothing measures the net."""

from tethernet_planner.swarm import DockedPairs, SwarmCentroid

MS = 1_000_000
PERIOD = 50 * MS


def test_a_tick_is_complete_when_every_mu_has_given_a_newer_sample():
    swarm = SwarmCentroid(4, 250 * MS)
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
    swarm = SwarmCentroid(4, 250 * MS)
    swarm.update(1, 100 * MS, (1.0, 0.0, 0.0))
    assert swarm.update(1, 50 * MS, (9.0, 0.0, 0.0)) is None
    assert swarm.positions[1] == (1.0, 0.0, 0.0)


def test_an_mu_that_falls_silent_is_left_out():
    swarm = SwarmCentroid(4, 250 * MS)
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
    pairs = DockedPairs(8, 0.5)
    apart = {mu: (10.0 * mu, 0.0, 0.0) for mu in range(1, 9)}
    assert pairs.update(apart) == 0
    assert pairs.update({**apart, 5: (10.4, 0.0, 0.0)}) == 1  # 1 and 5 are neighbours
    assert pairs.docked == {(1, 5)}
    assert pairs.update({**apart, 2: (10.4, 0.0, 0.0)}) == 1  # 1 and 2 are not; (1, 5) stays
    assert pairs.update({mu: (0.0, 0.0, 0.1 * mu) for mu in range(1, 9)}) > 1


def test_winches_pairs_cannot_be_seen_from_the_mus():
    assert DockedPairs(4, 0.5).update(dict.fromkeys(range(1, 5), (0.0, 0.0, 0.0))) == 0


def test_those_in_step_with_the_ticks_are_waited_for_until_they_are_silent():
    swarm = SwarmCentroid(8, 5 * PERIOD)
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
