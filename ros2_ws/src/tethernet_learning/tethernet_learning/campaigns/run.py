"""Fly what a results file lacks."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

from tethernet_core.system import System
from tethernet_learning.campaigns.cases import Case, most_units, row
from tethernet_learning.campaigns.chunks import fly_chunks
from tethernet_learning.campaigns.results import Results
from tethernet_learning.run_progress import MissionProgress
from tethernet_sim import cores
from tethernet_sim.fly import Settings


def resume(
    results: Results, cases: Sequence[Case], settings: Mapping[System, Settings], chunk: int, cluster: str | None = None
) -> bool:
    """Fly what is not flown yet; False when interrupted."""
    done, units = len(results.rows), most_units(cases)
    before = f", {done} flown before" if done else ""
    where = f"on the cluster at {cluster}" if cluster else f"on {cores.told()}"
    print(f"{len(cases)} missions{before}; {chunk} at a time {where}", file=sys.stderr)
    try:
        with MissionProgress(len(cases), done) as progress:
            for flown in fly_chunks(cases[done:], settings, chunk, cluster):
                begin = len(results.rows)
                results.add([row(begin + i, cases[begin + i], outcome, units) for i, outcome in enumerate(flown)])
                progress.add(flown)
        results.finish()
    except KeyboardInterrupt:
        print(
            f"interrupted; {len(results.rows)} of {len(cases)} missions are kept, the same command goes on",
            file=sys.stderr,
        )
        return False
    return True
