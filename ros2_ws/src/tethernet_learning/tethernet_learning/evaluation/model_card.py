"""A model's card: what its file says of itself, and how it did, as Markdown."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tethernet_planner.inference import shipped_models
from tethernet_planner.inference.model_file import file_fingerprint

_WHAT = {
    shipped_models.POLICY: (
        "where the MUs aim, given the debris' position at launch",
        "Trained for one attitude and angular rate of the debris, those of the default scenario, and for debris "
        "positions within the bounds below; elsewhere the nominal aiming points stand in, and it is said. It knows "
        "nothing of failures.",
    ),
    shipped_models.SURROGATE: (
        "what a capture comes to, from the net at the start of closing",
        "Holds for the net, the debris and the control that it was trained with. It predicts; the verdict comes from "
        "what is measured at the end.",
    ),
}


def card(
    file: Path, kind: str, about: dict[str, Any], evaluation: dict[str, Any] | None = None, history: str = ""
) -> str:
    """Write the card of a model.

    Args:
        file: of the model.
        kind: one of :data:`tethernet_planner.inference.shipped_models.KINDS`.
        about: what stands in its head.
        evaluation: where a policy was flown, the content of the evaluation's JSON file; of a surrogate, how it was
            tested, and its scores.
        history: name of a picture of the training, if there is one.
    """
    what, limits = _WHAT[kind]
    lines = [f"# {file.stem}", "", f"A trained {kind}: {what}.", "", f"Limits: {limits}", ""]
    lines += ["| fact | value |", "|---|---|", f"| file's hash | {file_fingerprint(file)} |"]
    anew = ("scores",) if evaluation is not None else ()  # those of the training are of its day's flights
    lines += [f"| {name} | {_text(value)} |" for name, value in _leaves(_shown(about), anew)]
    if evaluation is not None and kind == shipped_models.POLICY:
        lines += _scores(file, about["system"], evaluation)
    elif evaluation is not None:
        lines += ["", "## Test", "", "| fact | value |", "|---|---|"]
        lines += [f"| {name} | {_text(value)} |" for name, value in _leaves(evaluation)]
    if history:
        lines += ["", f"![Training]({history})"]
    return "\n".join(lines) + "\n"


def _shown(about: dict[str, Any]) -> dict[str, Any]:
    """Facts as the card shows them: of images, how many."""
    return {**about, "images": len(about["images"])} if "images" in about else about


def _scores(file: Path, system: str, evaluation: dict[str, Any]) -> list[str]:
    flown = evaluation.get("systems", {}).get(system, {}).get("policies", {})
    own = [facts for facts in flown.values() if facts["model"] == file_fingerprint(file)]
    if not own:
        raise ValueError(f"the evaluation has not flown this policy for {system}; make one with tethernet evaluate")
    [facts, *_] = own
    left_out = ("scenarios", "model", "saved_kg")
    lines = ["", "## Evaluation", "", "| fact | this policy | nominal |", "|---|---|---|"]
    told = {key: value for key, value in evaluation.items() if key != "systems"}
    lines += [f"| {key} | {_text(value)} | - |" for key, value in _leaves(told)]
    nominal = dict(_leaves(flown["nominal"], left_out))
    lines += [f"| {key} | {_text(v)} | {_text(nominal.get(key, '-'))} |" for key, v in _leaves(facts, left_out)]
    return lines


def _leaves(values: dict[str, Any], without: tuple[str, ...] = (), prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if name in without:
            continue
        if isinstance(value, dict):
            yield from _leaves(value, without, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.5g}"
    return " ".join(map(_text, value)) if isinstance(value, list | tuple) else str(value)
