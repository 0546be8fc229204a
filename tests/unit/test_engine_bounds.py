"""No array is overrun, whatever the net's size: a run in which numba checks every index."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
SCRIPT = """
import numpy as np
import numba

from tests.engines import ENGINES, STEP_S, flat_state, fly, grid_model, make_model, shaken
from tethernet_sim.engine import EdgeListEngine
from tethernet_sim.kernels.crossing_kinds import CrossingThreads
from tethernet_sim.model import grid_threads

touched = set()
assert numba.core.config.BOUNDSCHECK == 1
for rows, columns in ((2, 2), (3, 7), (7, 3), (8, 8), (4, 8), (23, 23), (2, 40), (33, 31), (91, 91), (100, 100)):
    for units in (0, 1, 24):
        nodes = rows * columns
        pairs = [[0, nodes - 1], [1, nodes + units - 1]] if units else [[0, nodes - 1]]
        for name, engine in ENGINES.items():
            # Contact of net with net with one engine alone: each of both kinds takes minutes to compile like this.
            model = grid_model(
                rows, columns, units=units, pairs=pairs, pair_winch=[0, -1][: len(pairs)], center=nodes // 2,
                net_contact=name == "edge list",
            )
            if name == "edge list" and (units != 1 or nodes >= 2000):  # of so many threads in one heap, too many touch
                none = CrossingThreads(np.zeros((0, 2), np.int64))
                model = model._replace(arrays=model.arrays._replace(crossing_threads=none))
            # Amid the debris, everything taut: all lists are as long as they get.
            state = shaken(model, debris=(0.0, 0.0, 0.0))
            flown = engine(model)
            fly(flown, state, 2 * STEP_S)
            state.knot_pos *= 1.01
            flown.begin_closing(state, 0)
            fly(flown, state, 12 * STEP_S)
            state.knot_pos[:] *= 0.01  # all of it on the debris
            fly(flown, state, 12 * STEP_S)
            assert np.isfinite(state.knot_pos).all()
            touched.add((name, int(state.contacts[0]) > 544))
# A large net folded to a heap, with room for no contact at first.
model = grid_model(100, 100, net_contact=True)
state = shaken(model)
state.knot_pos *= 0.04
state.knot_pos += np.random.default_rng(0).normal(0.0, 0.02, state.knot_pos.shape)
fly(EdgeListEngine(model), state, 12 * STEP_S)
assert state.crossed.shape[1] >= state.crossed_count[0] > 100
# Nodes without order: loose threads beside blocks.
number = np.random.default_rng(0).permutation(33 * 31)
for threads in (number[grid_threads(33, 31)], number[grid_threads(33, 31)] // 3 * 3):
    threads = threads[threads[:, 0] != threads[:, 1]]
    model = make_model(33 * 31, threads, net_contact=True)
    state = flat_state(model, np.random.default_rng(1).normal(0.0, 2.0, (3, 33 * 31)))
    fly(EdgeListEngine(model), state, 20 * STEP_S)
assert {("grid", True), ("edge list", True)} <= touched, "more than one block of contacts"
print("all sizes flown")
"""


def test_no_index_leaves_its_array_for_any_size(tmp_path):
    environment = os.environ | {"NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    ran = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=environment, cwd=ROOT, capture_output=True, text=True, timeout=900,
        check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr[-3000:]
    assert "all sizes flown" in ran.stdout
