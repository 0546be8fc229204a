"""What was measured of the shipped models, and whether it still holds.

Beside each shipped model lies ``NAME.json``, written by ``make cards`` (:mod:`.learning.renew_cards`) with the digest
of the flights that were flown. Where that is not today's, the figures are of other physics or control.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tethernet_core.errors import InputError
from tethernet_core.system import System
from tethernet_learning.flight_digest import flight_digest
from tethernet_planner.inference import shipped_models

RENEW = "make cards"
"""The command that measures all of them anew."""


class MeasuredError(InputError):
    """What was measured of a shipped model is missing or damaged: what to do."""


def place(kind: str, system: str) -> Path:
    """Where the measurements of a shipped model belong.

    Args:
        kind: one of :data:`.shipped_models.KINDS`.
        system: name of the system that it is for.
    """
    return shipped_models.place(kind, system).with_suffix(".json")


def read(kind: str, system: str) -> dict[str, Any]:
    """What was measured of a shipped model.

    Raises:
        MeasuredError: when it is not there or damaged.
    """
    file = place(kind, system)
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise MeasuredError(f"{file} cannot be read ({error}); {RENEW} writes it") from error
    if not isinstance(content, dict):
        raise MeasuredError(f"{file} does not hold measurements; {RENEW} writes it")
    return content


def stale(kind: str, system: System) -> str:
    """Why the card of a shipped model does not hold, in a sentence; empty when it does."""
    from tethernet_planner.inference.model_file import file_fingerprint

    try:
        measured = read(kind, system.name)
    except MeasuredError as error:
        return f"the card of the {kind} for {system.name}: {error}"
    if measured.get("model") != file_fingerprint(shipped_models.place(kind, system.name)):
        what = "of another file"
    elif measured.get("flight_digest") != flight_digest():
        what = "on other physics or control, or with other default parameters"
    elif measured.get("system_digest") != system.digest:
        what = "for another system of that name"
    else:
        return ""
    return f"the card of the {kind} for {system.name} is stale: it was measured {what}; {RENEW} measures anew"
