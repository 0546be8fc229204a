"""No kernel reads or writes beside an array: whole missions, compiled with bounds checked."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

_FLY = """
import numba, numpy as np
from tethernet_sim.fly import fly
from tethernet_sim.kernels.options import inlined
from tethernet_sim.scenario import Scenario

@inlined
def beside(values):
    return values[len(values)]

try:
    beside(np.zeros(3))
    raise SystemExit("bounds are not checked")
except IndexError:
    pass
for mus in (4, 8):
    assert fly(Scenario(f"zenit_{mus}mu", debris_rate=(0.02, 0.03, 0.0))).captured
"""


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_whole_missions_stay_within_their_arrays(tmp_path):
    script = tmp_path / "fly.py"
    script.write_text(_FLY)
    environment = {**os.environ, "NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
