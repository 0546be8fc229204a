"""What is known about an environment from one start to the next: which steps are done, and what they were done for."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass, field
from pathlib import Path

from .places import Places

FORMAT = 1


@dataclass
class State:
    """Contents of ``setup.json`` in the environment."""

    root: str
    """The repository's place when the environment was made: absolute paths to it are in many files."""
    interpreter: str = ""
    """The real file behind ``bin/python``, known from the first finished step on."""
    running: str = ""
    """The step that was begun last and has not ended: not empty after a kill."""
    done: dict[str, str] = field(default_factory=dict)
    """Fingerprint of what each finished step depends on, by the step's name."""
    format: int = FORMAT

    def save(self, path: Path) -> None:
        """Write the file as a whole or not at all."""
        partial = path.with_name(f"{path.name}.{os.getpid()}")
        partial.write_text(json.dumps(asdict(self), indent=1))
        partial.replace(path)


def load(places: Places) -> State | None:
    """The environment's state, None where the file is missing, torn or of another format."""
    try:
        content = json.loads(places.state.read_text())
        state = State(**content)
    except (OSError, ValueError, TypeError):
        return None
    return state if state.format == FORMAT and isinstance(state.done, dict) else None


def interpreter_of(places: Places) -> str:
    """The real file behind the environment's ``bin/python``, "" where it is missing or dangling."""
    return os.path.realpath(places.python) if os.access(places.python, os.X_OK) else ""
