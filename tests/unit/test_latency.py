"""Latencies, counted in bounded memory."""

import numpy as np
import pytest

from tethernet_sim.latency import RESOLUTION, LatencyCount


def counted(durations):
    made = LatencyCount()
    for duration in durations:
        made.add(duration)
    return made


@pytest.mark.parametrize("scale", [2e-5, 1e-3, 3.0])
@pytest.mark.parametrize("share", [0.01, 0.5, 0.99, 1.0])
def test_quantiles_are_right_within_the_resolution(scale, share):
    durations = np.random.default_rng(1).lognormal(np.log(scale), 1.0, 20_000)
    exact = np.quantile(durations, share, method="inverted_cdf")
    assert exact <= counted(durations).quantile(share) * (1 + 1e-12)
    assert counted(durations).quantile(share) <= exact * (1.0 + RESOLUTION) * (1 + 1e-12)


def test_the_longest_is_exact_and_nothing_is_nothing():
    assert counted([0.001, 0.1234567, 0.002]).longest_s == 0.1234567
    assert counted([0.001]).quantile(0.5) == 0.001
    assert counted([]).quantile(0.99) == 0.0


def test_memory_does_not_grow():
    made = counted([0.001])
    size = len(made._bins)
    for duration in (0.0, -1.0, 1e-9, 1e9, *np.random.default_rng(2).lognormal(0.0, 5.0, 20_000)):
        made.add(duration)
    assert len(made._bins) == size < 1200
    assert vars(made).keys() == {"count", "longest_s", "_bins"}
    assert sum(made._bins) == made.count == 20_005
