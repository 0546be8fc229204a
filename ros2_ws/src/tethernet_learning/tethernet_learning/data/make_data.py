"""Fly the scenarios that surrogates learn from and are tested on."""

from __future__ import annotations

import argparse
import dataclasses
import functools
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core import atomic_file
from tethernet_core.subcommand import Parser, Subcommand, whole_number
from tethernet_core.system import System
from tethernet_core.system.option import add_system, chosen_system
from tethernet_learning import assumed_numbers, run_folder, workers
from tethernet_learning.data import data_set
from tethernet_learning.data.spread import random_offsets
from tethernet_learning.data.trigger import fly_and_look
from tethernet_learning.flight_settings import Flight, settings_fingerprint
from tethernet_learning.paper_figures import PAPER
from tethernet_learning.random_scenarios import random_scenarios
from tethernet_learning.run_progress import Progress
from tethernet_learning.seeds import Purpose, generators
from tethernet_planner.inference import model_file
from tethernet_planner.inference.model_file import MadeFor
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Outcome, Scenario

SPLITS = {"train": Purpose.SURROGATE_TRAINING, "test": Purpose.SURROGATE_TEST}
TRAIN_COUNT = 2790
"""Training scenarios where the paper has no number for the system."""
TEST_COUNT = 200
PART = 32
"""Scenarios flown and written down together."""
LEAST_FAILURES = 0.2


def scenarios(system: System, split: str, seed: int, begin: int, count: int) -> list[Scenario]:
    """Scenarios of a data set, aiming points spread widely.

    Args:
        system: that is flown.
        split: one of SPLITS.
        seed: of the data set.
        begin: number of the first.
        count: how many.
    """
    plain = random_scenarios(system, SPLITS[split], seed, begin, count)
    spread = []
    for scenario, random in zip(plain, generators(SPLITS[split], seed, begin, count), strict=True):
        # A stream of its own for the offsets: children of the scenario's sequence.
        offsets = random_offsets(random.spawn(1)[0], system)
        spread.append(dataclasses.replace(scenario, aiming_offsets=tuple(map(tuple, offsets.tolist()))))
    return spread


@dataclasses.dataclass(frozen=True)
class Part:
    """Some scenarios of a data set that are flown and written down together."""

    system: System
    split: str
    """One of SPLITS."""
    seed: int
    begin: int
    """Number of the first."""
    count: int
    assumed: str = assumed_numbers.AS_DESCRIBED
    """One of :data:`.assumed_numbers.CHOICES`."""

    def fly(self, settings: Settings) -> list[dict[str, Any]]:
        """The rows of the table."""
        wanted = scenarios(self.system, self.split, self.seed, self.begin, self.count)
        flown: dict[int, tuple[Outcome, np.ndarray | None]] = {}
        for numbers, with_system, with_settings in self._flights(wanted, settings):
            group = [dataclasses.replace(wanted[number], system=with_system) for number in numbers]
            outcomes, seen = fly_and_look(group, with_settings, stop_at_trigger=False)
            flown.update(zip(numbers, zip(outcomes, seen, strict=True), strict=True))
        in_order = [flown[number] for number in range(len(wanted))]
        return data_set.rows(self.begin, wanted, [outcome for outcome, _ in in_order], [row for _, row in in_order])

    def _flights(self, wanted: list[Scenario], settings: Settings) -> Iterator[tuple[Sequence[int], System, Settings]]:
        """Which scenarios are flown together, by their numbers, and how."""
        if self.assumed != assumed_numbers.RANDOM:
            yield range(len(wanted)), self.system, settings
            return
        for numbers, seed in assumed_numbers.groups(wanted):
            flight, _ = assumed_numbers.drawn(Flight(self.system, settings), seed)
            yield numbers, flight.system, flight.settings


def make(
    folder: Path,
    system: System,
    split: str,
    count: int,
    seed: int,
    settings: Settings,
    about: dict[str, Any],
    cluster: str | None = None,
    assumed: str = assumed_numbers.AS_DESCRIBED,
) -> Path:
    """Fly one split, part by part; parts that are there already are kept.

    Args:
        folder: gets the file, and a folder with its parts.
        system: that is flown.
        split: one of SPLITS.
        count: scenarios in all.
        seed: of the data set.
        settings: of the flights.
        about: facts for the file's head.
        cluster: see :func:`tethernet_learning.workers.run`.
        assumed: one of :data:`.assumed_numbers.CHOICES`.

    Returns:
        The file with all of it.

    Raises:
        ClusterError: when the cluster cannot be used.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    parts = folder / f"{split}.parts"
    parts.mkdir(exist_ok=True)
    form = data_set.schema(system, {**about, "split": split, "count": count})
    files = {
        parts / f"{begin:06d}.parquet": Part(system, split, seed, begin, min(PART, count - begin), assumed)
        for begin in range(0, count, PART)
    }
    missing = [file for file in files if not file.exists()]
    done = count - sum(files[file].count for file in missing)
    flown = workers.run(functools.partial(Part.fly, settings=settings), [files[file] for file in missing], cluster)
    with Progress(f"{split} scenarios of {system.name}", count, done, unit="scenarios") as progress:
        for file, rows in zip(missing, flown, strict=True):
            data_set.write(file, pa.Table.from_pylist(rows, form))
            done += files[file].count
            progress.tell(done)
    whole = folder / f"{split}.parquet"
    data_set.write(
        whole, pa.concat_tables([pq.read_table(file) for file in files]).replace_schema_metadata(form.metadata)
    )
    return whole


def run(options: argparse.Namespace) -> None:
    """Fly and write."""
    system = chosen_system(options)
    settings = Settings.load(system)
    train = PAPER[system.name].train_scenarios if system.name in PAPER else TRAIN_COUNT
    counts = {"train": train if options.train is None else options.train, "test": options.test}
    facts = {
        **MadeFor.of(system).as_json(),
        "seed": options.seed,
        "assumed": options.assumed,
        "flight_parameters": settings_fingerprint(settings),
    }
    run_folder.claim(options.output, {"command": "make_data", **facts, "counts": counts})
    about = {
        **facts,
        "commit": model_file.commit(),
        "settings": dataclasses.asdict(settings),
        "description": {"text": system.to_yaml()},
    }
    for split, count in counts.items():
        began = time.monotonic()
        file = make(
            options.output, system, split, count, options.seed, settings, about, options.cluster, options.assumed
        )
        captures = data_set.read(file)
        share = captures.failures / captures.scenarios
        lost = int((~captures.captured).sum())
        print(
            f"{split}: {captures.scenarios} scenarios, {100 * share:.1f} % not captured; closing began in "
            f"{len(captures.captured)}, {lost} of them not captured; {time.monotonic() - began:.0f} s"
        )
        if share < LEAST_FAILURES:
            print(f"warning: fewer than {100 * LEAST_FAILURES:.0f} % failures in {split}", file=sys.stderr)
    atomic_file.write_text(options.output / "README.md", data_set.description(system, {**about, **counts}))


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add_system(parser)
    add("--output", type=Path, required=True, metavar="FOLDER", help="train.parquet, test.parquet")
    add("--train", type=whole_number(1), metavar="N", help=f"training scenarios, default the paper's, or {TRAIN_COUNT}")
    add("--test", type=whole_number(1), default=TEST_COUNT, metavar="N", help=f"test scenarios, default {TEST_COUNT}")
    add("--seed", type=whole_number(0), default=0, metavar="N", help="of the data set, default 0")
    add(
        "--assumed", choices=assumed_numbers.CHOICES, default=assumed_numbers.AS_DESCRIBED,
        help="numbers that nobody has measured: as described (default), or drawn at random for every "
        f"{assumed_numbers.GROUP} scenarios",
    )  # fmt: skip
    add("--cluster", metavar="ADDRESS", help=workers.HELP)


COMMAND = Subcommand(
    "Fly scenarios with widely spread aiming points in full and write them down in Parquet. Killed and started again "
    "with the same words it goes on.",
    ("--mus 8 --output DATA", "--system zenit_4mu --train 64 --test 32 --output DATA"), run, _add_arguments,
)  # fmt: skip
