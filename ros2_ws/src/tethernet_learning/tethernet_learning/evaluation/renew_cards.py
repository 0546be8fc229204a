"""Measure the shipped models anew and write their cards."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tethernet_core.atomic_file import write_text
from tethernet_core.layout import system_of
from tethernet_core.subcommand import Parser, Subcommand
from tethernet_learning import measured
from tethernet_learning.campaigns.progress import Progress
from tethernet_learning.data import data_set, make_data
from tethernet_learning.data.trigger import fly_and_look
from tethernet_learning.evaluation import evaluate_policies, model_card
from tethernet_learning.evaluation import policy_scores as evaluation
from tethernet_learning.evaluation.policy_scores import Evaluated
from tethernet_learning.flight_digest import flight_digest
from tethernet_learning.flight_settings import settings_fingerprint
from tethernet_learning.seeds import Purpose
from tethernet_learning.surrogates import surrogate_report
from tethernet_learning.surrogates.surrogate_scores import scores
from tethernet_planner import policies
from tethernet_planner.inference import model_file, shipped_models
from tethernet_planner.inference.policy_file import AimingPolicy
from tethernet_planner.inference.surrogate_file import Surrogate
from tethernet_sim import cores
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Outcome

SCENARIOS = 100
"""Unseen ones, for each design and policy."""

_PART = 50
"""Test scenarios of surrogates flown between two lines of progress."""


def measure_policies(settings: Settings, count: int, facts: dict[str, Any], folder: Path) -> list[Evaluated]:
    """Fly the shipped policies on the unseen scenarios, write their cards, and the evaluation into a folder.

    Args:
        settings: of the flights.
        count: scenarios for each design and policy.
        facts: how it was measured.
        folder: for the evaluation's files.
    """
    chosen = evaluation.contenders([policies.RL], [4, 8])
    progress = Progress(count * sum(map(len, chosen.values())))

    def tell(outcomes: Sequence[Outcome]) -> None:
        progress.add(len(outcomes), sum(bool(outcome.error) for outcome in outcomes))

    evaluated = evaluation.evaluate(chosen, count, 0, settings, progress=tell)
    facts = {"scenarios": count, "stream": Purpose.POLICY_EVALUATION.name, "seed": 0, **facts}
    evaluate_policies.write(folder, facts, evaluated)
    content = {**facts, "designs": evaluation.as_json(evaluated)}
    for e in evaluated:
        file = shipped_models.place(shipped_models.POLICY, e.mus)
        _write(shipped_models.POLICY, AimingPolicy.load(file), content, _flown(e))
    return evaluated


def _flown(e: Evaluated) -> list[dict[str, Any]]:
    """What each scenario came to, for who flies it again."""
    return [
        {
            name: {"captured": outcome.captured, "locked_pairs": outcome.locked_pairs, "fuel_kg": sum(outcome.fuel_kg)}
            for name, outcome in zip(e.outcomes, outcomes, strict=True)
        }
        for outcomes in zip(*e.outcomes.values(), strict=True)
    ]


def measure_surrogates(settings: Settings, count: int, facts: dict[str, Any]) -> dict[int, dict[str, Any]]:
    """Fly the test scenarios of the shipped surrogates anew, and write their cards.

    Args:
        settings: of the flights.
        count: scenarios for each design.
        facts: how it was measured.

    Returns:
        Scores by design, see :func:`.surrogate_scores.scores`.
    """
    progress, found = Progress(2 * count), {}
    for mus in (4, 8):
        file = shipped_models.place(shipped_models.SURROGATE, mus)
        surrogate = Surrogate.load(file)
        outcomes: list[Outcome] = []
        seen = []
        for begin in range(0, count, _PART):
            flown = make_data.scenarios(mus, "test", 0, begin, min(_PART, count - begin))
            some, looks = fly_and_look(flown, settings, stop_at_trigger=False)
            outcomes += some
            seen += looks
            progress.add(len(some), sum(bool(outcome.error) for outcome in some))
        test = data_set.captures(outcomes, seen, dict(facts), system_of(mus))
        found[mus] = scores(surrogate, test)
        content = {"scenarios": count, "stream": Purpose.SURROGATE_TEST.name, "seed": 0, **facts, "scores": found[mus]}
        _write(shipped_models.SURROGATE, surrogate, content, None)
    return found


def _write(kind: str, model: AimingPolicy | Surrogate, content: dict[str, Any], flown: list[Any] | None) -> None:
    """The measurements for programs, and the card for people."""
    file = shipped_models.place(kind, model.mus)
    picture = file.with_suffix(".png")
    history = picture.name if picture.is_file() else ""
    card = model_card.card(file, kind, model.about, content, history)
    kept = {"model": model_file.file_fingerprint(file), **content}
    if flown is not None:
        designs = kept.pop("designs")
        kept["policies"] = {
            name: {key: value for key, value in told.items() if key not in ("scenarios", "model")}
            for name, told in designs[str(model.mus)]["policies"].items()
        }
        kept["flown"] = flown
    write_text(measured.place(kind, model.mus), evaluate_policies.as_text(kept))
    write_text(file.with_suffix(".md"), card)


def run(options: argparse.Namespace) -> None:
    """Measure the shipped models and write their cards."""
    settings, began = Settings.load(), time.monotonic()
    facts = {
        "flight_digest": flight_digest(),
        "flight_parameters": settings_fingerprint(settings),
        "commit": model_file.commit(),
        "flown_on": cores.told(),
    }
    options.output.mkdir(parents=True, exist_ok=True)
    measure_policies(settings, SCENARIOS, facts, options.output)
    judged = measure_surrogates(settings, make_data.TEST_COUNT, facts)
    report = surrogate_report.short(judged)
    write_text(options.output / "surrogates.md", report)
    print((options.output / evaluate_policies.REPORT).read_text(encoding="utf-8"))
    print(report)
    print(f"{time.monotonic() - began:.0f} s; cards in {shipped_models.FOLDER}, tables in {options.output}")


def _add_arguments(parser: Parser) -> None:
    parser.add_argument("--output", type=Path, default=Path("runs/cards"), metavar="FOLDER", help="for the tables")


COMMAND = Subcommand(
    "Fly the shipped policies on their unseen scenarios and the shipped surrogates' test scenarios anew, and write "
    "what comes out into the models' cards. To be done after every change of physics, control or default parameters.",
    ("", "--output runs/cards"), run, _add_arguments,
)  # fmt: skip
