"""Eight numbers at once: every operation against NumPy, for a processor with and without wide instructions."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from tethernet_core.system import load_system
from tethernet_sim.fly import Settings
from tethernet_sim.kernels import lanes
from tethernet_sim.kernels.edge_list import SLACK_M
from tethernet_sim.model import build_model
from tethernet_sim.thread_blocks import edge_list

RANDOM = np.random.default_rng(0)


@pytest.mark.parametrize("wide", [False, True])
def test_the_indices_of_a_masks_bits_are_appended_in_order(wide, monkeypatch):
    monkeypatch.setattr(lanes, "COMPRESSES", wide)

    @numba.njit
    def append(found, count, begin, mask):
        return lanes.append_indices(found, np.uint64(count), np.uint64(begin), np.uint64(mask))

    for mask in range(256):
        found = np.full(12, 7, np.uint32)
        expected = [80 + k for k in range(8) if mask >> k & 1]
        assert append(found, 3, 80, mask) == 3 + len(expected)
        assert found[:3].tolist() == [7, 7, 7]
        assert found[3 : 3 + len(expected)].tolist() == expected
        assert found[11] == 7, "eight entries are written, no more"


def test_arithmetic_is_numpys():
    @numba.njit
    def calculate(a, b, out, further):
        x, y = lanes.load(a, np.uint64(3)), lanes.load(b, np.uint64(0))
        lanes.store(out, np.uint64(1), (x + y) * (x - y) / lanes.square_root(x * x + lanes.spread(1.0)))
        lanes.store(further, np.uint64(0), lanes.next_lanes(lanes.load(a, np.uint64(0)), lanes.load(a, np.uint64(8))))
        lanes.store(further, np.uint64(8), lanes.where_positive(x, y))
        return lanes.mask_greater(x, y)

    a, b = RANDOM.normal(size=16), RANDOM.normal(size=8)
    out, further = np.zeros(10), np.zeros(16)
    mask = calculate(a, b, out, further)
    x = a[3:11]
    np.testing.assert_allclose(out[1:9], (x + b) * (x - b) / np.sqrt(x * x + 1.0), rtol=1e-14)
    assert out[0] == out[9] == 0.0
    assert further[:8].tolist() == a[1:9].tolist()
    assert further[8:].tolist() == np.where(x > 0.0, b, 0.0).tolist()
    assert [bool(mask >> k & 1) for k in range(8)] == (x > b).tolist()


def test_numbers_from_all_over_a_row_are_gathered_and_compared():
    @numba.njit
    def calculate(row, indices, flags, out):
        one = lanes.gather(row, indices, np.uint64(2))
        other = lanes.gather(row, indices, np.uint64(8))
        lanes.store(out, np.uint64(0), one)
        lanes.store(out, np.uint64(8), lanes.least(one, other))
        lanes.store(out, np.uint64(16), lanes.greatest(one, other))
        return lanes.mask_set(flags, np.uint64(3))

    row, indices = RANDOM.normal(size=10_000), RANDOM.integers(0, 10_000, 16).astype(np.uint32)
    indices[5] = 9_999
    flags, out = RANDOM.choice([0, 1, 255], 12).astype(np.uint8), np.zeros(24)
    mask = calculate(row, indices, flags, out)
    one, other = row[indices[2:10]], row[indices[8:]]
    assert out.tolist() == [*one, *np.minimum(one, other), *np.maximum(one, other)]
    assert [bool(mask >> k & 1) for k in range(8)] == (flags[3:11] != 0).tolist()


@pytest.mark.parametrize("index", [10_000, 4_000_000_000])
def test_an_index_beyond_its_row_is_found_where_indices_are_checked(index):
    @numba.njit(boundscheck=True)
    def calculate(row, indices):
        return lanes.mask_greater(lanes.gather(row, indices, np.uint64(0)), lanes.spread(0.0))

    indices = np.zeros(8, np.uint32)
    assert calculate(np.ones(10_000), indices) == 255
    indices[7] = index
    with pytest.raises(IndexError):
        calculate(np.ones(10_000), indices)


def test_every_thread_has_one_place():
    """A random net with parallel and turned threads: blocks and loose threads are together the net."""
    threads = RANDOM.integers(0, 60, (700, 2))
    threads = threads[threads[:, 0] != threads[:, 1]]
    rest, stiffness, damping = RANDOM.uniform(1.0, 2.0, (3, len(threads)))
    made = edge_list(60, threads, rest, stiffness, damping, 0.2)
    kept = made.rest < SLACK_M
    found = np.stack([made.first, made.second, made.rest, made.stiffness, made.damping])[:, kept]
    expected = np.vstack([np.sort(threads, axis=1).T, rest, stiffness, damping])
    assert found[:, np.lexsort(found)].tolist() == expected[:, np.lexsort(expected)].tolist()
    assert (made.stiffness[~kept] == 0.0).all()
    assert 0 < 8 * len(made.block_first) < len(made.first), "some are in blocks, some loose"
    lead = made.second.astype(int) - made.first
    assert (lead[: 8 * len(made.block_first)].reshape(-1, 8) == lead[: 8 * len(made.block_first) : 8, None]).all()


@pytest.mark.parametrize("name", ["zenit_8mu", "hexagonal_6mu", "passive_5m", "envisat_8mu"])
def test_most_threads_of_the_shipped_nets_stand_in_blocks(name):
    arrays = build_model(load_system(name), Settings.load(name).physics).arrays
    made = edge_list(len(arrays.kick), arrays.threads, arrays.rest, arrays.stiffness, arrays.damping, 0.2)
    assert len(made.first) - 8 * len(made.block_first) < 0.1 * len(arrays.threads)
