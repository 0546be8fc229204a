"""A folder in which a long run keeps what it has done, so that it goes on after a kill."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tethernet_core.atomic_file import write_text
from tethernet_core.errors import InputError

SETTINGS = "settings.json"


class RunFolderError(InputError):
    """A folder cannot be used for this run: why, and what to do."""


def claim(folder: Path, settings: dict[str, Any]) -> bool:
    """Begin a run in a folder, or go on with the one that is there.

    Args:
        folder: made where missing.
        settings: all that the run's results depend on, as JSON holds it.

    Returns:
        True when an earlier run is to be gone on with.

    Raises:
        RunFolderError: when the folder holds a run with other settings, or anything else.
    """
    file = folder / SETTINGS
    wanted = json.loads(json.dumps(settings))
    if file.exists():
        try:
            found = json.loads(file.read_text(encoding="utf-8"))
        except ValueError as error:
            raise RunFolderError(f"{file} is damaged: {error}; name another folder, or remove it") from error
        differences = _differences(found, wanted)
        if differences:
            raise RunFolderError(
                f"{folder} holds a run with other settings ({'; '.join(differences)}); "
                "name another folder, or remove it"
            )
        return True
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise RunFolderError(f"{folder} holds something that is no run; name a new or an empty folder")
    folder.mkdir(parents=True, exist_ok=True)
    write_text(file, json.dumps(wanted, indent=2) + "\n")
    return False


def _differences(found: Any, wanted: Any, name: str = "") -> list[str]:
    if isinstance(found, dict) and isinstance(wanted, dict):
        keys = sorted(found.keys() | wanted.keys())
        nested = (_differences(found.get(k), wanted.get(k), f"{name}.{k}" if name else k) for k in keys)
        return [difference for some in nested for difference in some]
    return [] if found == wanted else [f"{name}: there {found}, asked for {wanted}"]


def tell(result: dict[str, Any], file: Path | None) -> None:
    """Print what was measured as JSON, and write it to a file where one is named."""
    text = json.dumps(result, indent=2)
    if file is not None:
        write_text(file, text + "\n")
    print(text)
