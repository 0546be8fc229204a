"""A campaign of faulted missions, resumable: missions that FOLDER knows already are not flown again.

python -m tests.faults --missions 500 --output FOLDER [--first-seed 0] [--jobs 1] [--kind "controller killed"]
"""

from __future__ import annotations

import argparse
import collections
import concurrent.futures
import json
import shutil
import subprocess
import sys
import time
from pathlib import Path

from . import isolation
from .kinds import CATALOGUE

HARD_LIMIT_S = 240.0
"""A mission that takes longer has hung in a way that even its watcher did not see."""


def fly(seed: int, folder: Path) -> dict:
    """One mission; what it wrote is kept when a promise was broken."""
    place = folder / f"{seed:06d}"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    words = [sys.executable, "-m", "tests.faults.mission", "--seed", str(seed), "--output", str(place)]
    command = isolation.isolated(words)
    result_file = place / "result.json"
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=HARD_LIMIT_S, check=False)
        result = json.loads(result_file.read_text())
    except subprocess.TimeoutExpired:
        result = {"seed": seed, "kind": CATALOGUE[seed % len(CATALOGUE)].name, "broken": ["the watcher hung"]}
    except (OSError, ValueError):
        result = {
            "seed": seed, "kind": CATALOGUE[seed % len(CATALOGUE)].name,
            "broken": [f"the watcher failed: {done.stdout[-500:]}{done.stderr[-1500:]}"],
        }  # fmt: skip
    if not result["broken"]:
        shutil.rmtree(place, ignore_errors=True)
    return result


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description=__doc__)
    parser.add_argument("--missions", type=int, default=len(CATALOGUE))
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--kind", help="only seeds of this kind")
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    if why := isolation.missing():
        print(f"python -m tests.faults: {why}", file=sys.stderr)
        return 2
    options.output.mkdir(parents=True, exist_ok=True)
    journal = options.output / "results.jsonl"
    known = {}
    if journal.exists():
        known = {row["seed"]: row for row in map(json.loads, journal.read_text().splitlines())}
    seeds = [
        seed for seed in range(options.first_seed, options.first_seed + options.missions)
        if options.kind in (None, CATALOGUE[seed % len(CATALOGUE)].name)
    ]  # fmt: skip
    todo = [seed for seed in seeds if seed not in known]
    began = time.monotonic()
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool, journal.open("a") as file:
        for number, result in enumerate(pool.map(lambda seed: fly(seed, options.output), todo), 1):
            known[result["seed"]] = result
            file.write(json.dumps(result) + "\n")
            file.flush()
            mark = "BROKEN " + result["broken"][0][:300] if result["broken"] else "held"
            print(
                f"{number}/{len(todo)} {time.monotonic() - began:.0f} s  seed {result['seed']} {result['kind']}"
                f" ({result.get('target', '')}, {result.get('moment')}, {result.get('pace')}):"
                f" status {result.get('status')} after {result.get('seconds')} s: {mark}",
                flush=True,
            )
    return summary([known[seed] for seed in seeds])


def summary(results: list[dict]) -> int:
    """Print how each kind went; 0 when every promise held."""
    kinds = collections.defaultdict(list)
    for result in results:
        kinds[result["kind"]].append(result)
    for name, some in sorted(kinds.items()):
        broken = sum(bool(result["broken"]) for result in some)
        statuses = dict(collections.Counter(str(result.get("status")) for result in some))
        slowest = max((result.get("after_fault_s") or 0.0 for result in some), default=0.0)
        print(f"{name:28} {len(some):4} missions, {broken:3} broken, ended within {slowest:.0f} s, statuses {statuses}")
    broken = sum(bool(result["broken"]) for result in results)
    print(f"{len(results)} missions, {broken} with a broken promise")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
