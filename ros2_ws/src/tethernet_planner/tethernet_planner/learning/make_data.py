"""Fly the scenarios that surrogates learn from and are tested on.

``python -m tethernet_planner.learning.make_data``.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Scenario

from . import data_set, model_file, run_folder, task
from .progress import Progress
from .seeds import Purpose, generators
from .spread import random_offsets
from .trigger import fly_and_look

SPLITS = {"train": Purpose.SURROGATE_TRAINING, "test": Purpose.SURROGATE_TEST}
TRAIN_COUNT = {4: 2540, 8: 2790}
"""As in the paper."""
TEST_COUNT = 200
PART = 32
"""Scenarios flown and written down together."""
LEAST_FAILURES = 0.2


def scenarios(mus: int, split: str, seed: int, begin: int, count: int) -> list[Scenario]:
    """Scenarios of a data set, aiming points spread widely.

    Args:
        mus: 4 or 8.
        split: one of SPLITS.
        seed: of the data set.
        begin: number of the first.
        count: how many.
    """
    plain = task.random_scenarios(mus, SPLITS[split], seed, begin, count)
    spread = []
    for scenario, random in zip(plain, generators(SPLITS[split], seed, begin, count), strict=True):
        # A stream of its own for the offsets: children of the scenario's sequence.
        offsets = random_offsets(random.spawn(1)[0], mus)
        spread.append(dataclasses.replace(scenario, aiming_offsets=tuple(map(tuple, offsets.tolist()))))
    return spread


def make(folder: Path, mus: int, split: str, count: int, seed: int, settings: Settings, about: dict) -> Path:
    """Fly one split, part by part; parts that are there already are kept.

    Returns:
        The file with all of it.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    parts = folder / f"{split}.parts"
    parts.mkdir(exist_ok=True)
    form = data_set.schema(mus, {**about, "split": split, "count": count})
    files = []
    done = sum(min(PART, count - begin) for begin in range(0, count, PART) if (parts / f"{begin:06d}.parquet").exists())
    progress = Progress(f"{split} scenarios with {mus} MUs", count, done)
    for begin in range(0, count, PART):
        size = min(PART, count - begin)
        files.append(parts / f"{begin:06d}.parquet")
        if files[-1].exists():
            continue
        flown = scenarios(mus, split, seed, begin, size)
        outcomes, seen = fly_and_look(flown, settings, stop_at_trigger=False)
        data_set.write(files[-1], pa.Table.from_pylist(data_set.rows(begin, flown, outcomes, seen), form))
        done += size
        progress.tell(done)
    whole = folder / f"{split}.parquet"
    data_set.write(
        whole, pa.concat_tables([pq.read_table(file) for file in files]).replace_schema_metadata(form.metadata)
    )
    return whole


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tethernet_planner.learning.make_data",
        description="Fly scenarios with widely spread aiming points in full and write them down in Parquet. "
        "Killed and started again with the same words it goes on.",
    )
    parser.add_argument("--mus", type=int, choices=(4, 8), required=True)
    parser.add_argument("--output", type=Path, required=True, metavar="FOLDER", help="train.parquet, test.parquet")
    parser.add_argument("--train", type=int, metavar="N", help="training scenarios, default 2540 (4 MUs) or 2790 (8)")
    parser.add_argument("--test", type=int, default=TEST_COUNT, metavar="N", help="test scenarios, default 200")
    parser.add_argument("--seed", type=int, default=0, help="of the data set, default 0")
    options = parser.parse_args(argv)
    options.train = TRAIN_COUNT[options.mus] if options.train is None else options.train
    for name in ("train", "test"):
        if getattr(options, name) < 1:
            parser.error(f"--{name} {getattr(options, name)}: allowed: 1 or more")
    if options.seed < 0:
        parser.error(f"--seed {options.seed}: allowed: 0 or more")
    return options


def main(argv: Sequence[str] | None = None) -> int:
    """Fly and write. Returns 0; 2 for bad usage or a folder with another run."""
    options = _arguments(argv)
    settings = Settings.load()
    counts = {"train": options.train, "test": options.test}
    facts = {
        "mus": options.mus,
        "seed": options.seed,
        "flight_parameters": model_file.settings_fingerprint(settings),
    }
    try:
        run_folder.claim(options.output, {"command": "make_data", **facts, "counts": counts})
    except run_folder.RunFolderError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    about = {**facts, "commit": model_file.commit(), "settings": dataclasses.asdict(settings)}
    for split, count in counts.items():
        began = time.monotonic()
        captures = data_set.read(make(options.output, options.mus, split, count, options.seed, settings, about))
        share = captures.failures / captures.scenarios
        lost = int((~captures.captured).sum())
        print(
            f"{split}: {captures.scenarios} scenarios, {100 * share:.1f} % not captured; closing began in "
            f"{len(captures.captured)}, {lost} of them not captured; {time.monotonic() - began:.0f} s"
        )
        if share < LEAST_FAILURES:
            print(f"warning: fewer than {100 * LEAST_FAILURES:.0f} % failures in {split}", file=sys.stderr)
    run_folder.write_text(options.output / "README.md", data_set.description(options.mus, {**about, **counts}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
