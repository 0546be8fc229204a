"""Measure the shipped models anew and write their cards."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from tethernet_core.atomic_file import write_text
from tethernet_core.subcommand import Parser, Subcommand
from tethernet_core.system import System, load_system
from tethernet_learning import measured
from tethernet_learning.data import data_set, make_data
from tethernet_learning.data.trigger import fly_and_look
from tethernet_learning.evaluation import evaluate_policies, holds, model_card
from tethernet_learning.evaluation import policy_scores as evaluation
from tethernet_learning.evaluation.policy_scores import Evaluated
from tethernet_learning.flight_digest import flight_digest
from tethernet_learning.flight_settings import Flight, fingerprints, settings_fingerprint
from tethernet_learning.run_progress import MissionProgress
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
"""Unseen ones, for each system and policy."""

_PART = 50
"""Test scenarios of surrogates flown between two lines of progress."""


def measure_policies(count: int, facts: dict[str, Any], folder: Path) -> list[Evaluated]:
    """Fly the shipped policies on the unseen scenarios, write their cards, and the evaluation into a folder.

    Args:
        count: scenarios for each system and policy.
        facts: how it was measured.
        folder: for the evaluation's files.
    """
    settings = _settings(shipped_models.POLICY)
    flights = {system: Flight(system, one) for system, one in settings.items()}
    chosen = evaluation.contenders([policies.RL], list(flights))
    with MissionProgress(count * sum(map(len, chosen.values())) + holds.SCENARIOS * len(flights)) as progress:
        evaluated = evaluation.evaluate(chosen, count, 0, flights, progress=progress.add)
        tested = holds.fly(list(flights), progress=progress.add)
    facts = {
        "scenarios": count,
        "stream": Purpose.POLICY_EVALUATION.name,
        "seed": 0,
        **facts,
        "flight_parameters": fingerprints(settings),
    }
    evaluate_policies.write(folder, facts, evaluated)
    content = {**facts, "systems": evaluation.as_json(evaluated)}
    for e, held in zip(evaluated, tested, strict=True):
        file = shipped_models.place(shipped_models.POLICY, e.system.name)
        flown = {"flown": _flown(e), "flown_with_hold": holds.flown(held)}
        _write(shipped_models.POLICY, AimingPolicy.load(file), {**content, "hold": holds.told(held)}, flown)
    return evaluated


def _settings(kind: str) -> dict[System, Settings]:
    """The systems for which a model is shipped, each with the parameters that it is flown with."""
    systems = [load_system(name) for name in shipped_models.shipped(kind)]
    return {system: Settings.load(system) for system in systems}


def _flown(e: Evaluated) -> list[dict[str, Any]]:
    """What each scenario came to, for who flies it again."""
    return [
        {
            name: {"captured": outcome.captured, "locked_pairs": outcome.locked_pairs, "fuel_kg": sum(outcome.fuel_kg)}
            for name, outcome in zip(e.outcomes, outcomes, strict=True)
        }
        for outcomes in zip(*e.outcomes.values(), strict=True)
    ]


def measure_surrogates(count: int, facts: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Fly the test scenarios of the shipped surrogates anew, and write their cards.

    Args:
        count: scenarios for each system.
        facts: how it was measured.

    Returns:
        Scores by name of the system, see :func:`.surrogate_scores.scores`.
    """
    by_system = _settings(shipped_models.SURROGATE)
    found = {}
    with MissionProgress(len(by_system) * count) as progress:
        for system, settings in by_system.items():
            file = shipped_models.place(shipped_models.SURROGATE, system.name)
            surrogate = Surrogate.load(file)
            surrogate.check_system(system)
            outcomes: list[Outcome] = []
            seen = []
            for begin in range(0, count, _PART):
                flown = make_data.scenarios(system, "test", 0, begin, min(_PART, count - begin))
                some, looks = fly_and_look(flown, settings, stop_at_trigger=False)
                outcomes += some
                seen += looks
                progress.add(some)
            test = data_set.captures(outcomes, seen, dict(facts), system)
            found[system.name] = scores(surrogate, test)
            content = {"scenarios": count, "stream": Purpose.SURROGATE_TEST.name, "seed": 0, **facts}
            content |= {"flight_parameters": settings_fingerprint(settings), "scores": found[system.name]}
            _write(shipped_models.SURROGATE, surrogate, content, None)
    return found


def _write(kind: str, model: AimingPolicy | Surrogate, content: dict[str, Any], flown: dict[str, Any] | None) -> None:
    """The measurements for programs, and the card for people."""
    file = shipped_models.place(kind, model.made_for.system)
    picture = file.with_suffix(".png")
    history = picture.name if picture.is_file() else ""
    card = model_card.card(file, kind, model.about, content, history)
    kept = {
        "model": model_file.file_fingerprint(file),
        "system": model.made_for.system,
        "system_digest": model.made_for.digest,
        **content,
    }
    if flown is not None:
        systems = kept.pop("systems")
        kept["policies"] = {
            name: {key: value for key, value in told.items() if key not in ("scenarios", "model")}
            for name, told in systems[model.made_for.system]["policies"].items()
        }
        kept |= flown
    write_text(measured.place(kind, model.made_for.system), evaluate_policies.as_text(kept))
    write_text(file.with_suffix(".md"), card)


def run(options: argparse.Namespace) -> None:
    """Measure the shipped models and write their cards."""
    began = time.monotonic()
    facts = {
        "flight_digest": flight_digest(),
        "commit": model_file.commit(),
        "flown_on": cores.told(),
    }
    options.output.mkdir(parents=True, exist_ok=True)
    measure_policies(SCENARIOS, facts, options.output)
    judged = measure_surrogates(make_data.TEST_COUNT, facts)
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
