"""What was measured of the shipped models, and whether it still holds.

Beside each shipped model lies ``NAME.json``, written by ``make cards`` (:mod:`.learning.renew_cards`) with the digest
of the flights that were flown. Where that is not today's, the figures are of other physics or control.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tethernet_core.errors import InputError
from tethernet_learning.flight_digest import flight_digest
from tethernet_planner.inference import shipped_models

RENEW = "make cards"
"""The command that measures all of them anew."""


class MeasuredError(InputError):
    """What was measured of a shipped model is missing or damaged: what to do."""


def place(kind: str, mu_count: int) -> Path:
    """Where the measurements of a shipped model belong.

    Args:
        kind: one of :data:`.shipped_models.KINDS`.
        mu_count: 4 or 8.
    """
    return shipped_models.place(kind, mu_count).with_suffix(".json")


def read(kind: str, mu_count: int) -> dict[str, Any]:
    """What was measured of a shipped model.

    Raises:
        MeasuredError: when it is not there or damaged.
    """
    file = place(kind, mu_count)
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise MeasuredError(f"{file} cannot be read ({error}); {RENEW} writes it") from error
    if not isinstance(content, dict):
        raise MeasuredError(f"{file} does not hold measurements; {RENEW} writes it")
    return content


def stale(kind: str, mu_count: int) -> str:
    """Why the card of a shipped model does not hold, in a sentence; empty when it does."""
    from tethernet_planner.inference.model_file import file_fingerprint

    try:
        measured = read(kind, mu_count)
    except MeasuredError as error:
        return f"the card of the {kind} for {mu_count} MUs: {error}"
    if measured.get("model") != file_fingerprint(shipped_models.place(kind, mu_count)):
        what = "of another file"
    elif measured.get("flight_digest") != flight_digest():
        what = "on other physics or control, or with other default parameters"
    else:
        return ""
    return f"the card of the {kind} for {mu_count} MUs is stale: it was measured {what}; {RENEW} measures anew"
