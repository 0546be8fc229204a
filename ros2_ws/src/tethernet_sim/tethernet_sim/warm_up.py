"""Fill numba's cache: `python -m tethernet_sim.warm_up`, once after set-up.

One process compiles, so that the processes of a mission, and the workers of a campaign, only load.
"""

from __future__ import annotations

import sys
import time


def main() -> int:
    """Compile every kernel by flying a fifth of a second of each design. Returns 0."""
    from .fly import Settings, fly
    from .scenario import Scenario

    # A trigger at once and a short capture lead through closing and contact search too.
    settings = Settings.load(mission={"trigger_distance_m": 50.0, "capture_duration_s": 1.0})
    for mus in (4, 8):
        began = time.perf_counter()
        print(f"compiling the physics of {mus} MUs ...", end=" ", flush=True)
        fly(Scenario(mus=mus), settings)
        print(f"{time.perf_counter() - began:.1f} s", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
