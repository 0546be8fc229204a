"""Files of trained models: safetensors with what they are, what they were made from, and by what."""

from __future__ import annotations

import hashlib
import json
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core.atomic_file import write_whole
from tethernet_core.errors import InputError
from tethernet_core.system import System

VERSION = 3
"""Of the format; readers refuse others. Before 3 models did not say which system they were made for."""

_SHOWN_DIGITS = 12
"""Of a digest in messages."""

_KEY = "tethernet"


class ModelFileError(InputError):
    """A file is not what it should be: what was found, and what is allowed."""


@dataclass(frozen=True)
class MadeFor:
    """The system that a model was made for."""

    system: str
    """Its name."""
    digest: str
    """Of its hardware."""
    units: int
    """How many it has."""

    @classmethod
    def of(cls, system: System) -> MadeFor:
        """A system's."""
        return cls(system.name, system.digest, system.unit_count)

    def check(self, system: System, kind: str) -> None:
        """Make sure that the model is for a system.

        Args:
            system: that shall use it; its name may be another, its hardware may not.
            kind: of the model, for the message.

        Raises:
            ModelFileError: when it is for another; names both.
        """
        if self.digest != system.digest:
            raise ModelFileError(
                f"this {kind} was made for system {self.system} (digest {self.digest[:_SHOWN_DIGITS]}), not for "
                f"{system.name} (digest {system.digest[:_SHOWN_DIGITS]}); allowed: one that was trained for "
                f"{system.name} as it is described now"
            )

    def as_json(self) -> dict[str, Any]:
        """Facts of a model's file."""
        return {"system": self.system, "system_digest": self.digest, "mus": self.units}

    @classmethod
    def from_json(cls, about: Mapping[str, Any], path: Path) -> MadeFor:
        """From a model's facts.

        Raises:
            ModelFileError: when they do not say it.
        """
        name, digest, units = (about.get(key) for key in ("system", "system_digest", "mus"))
        if not (isinstance(name, str) and isinstance(digest, str) and isinstance(units, int) and units >= 0):
            raise ModelFileError(
                f"{path} was made for system {name!r}, digest {digest!r}, {units!r} units; allowed: a name, a digest, "
                "and how many units it has"
            )
        return cls(name, digest, units)


def write(path: Path, kind: str, arrays: dict[str, np.ndarray], about: dict[str, Any]) -> None:
    """Write a model; an existing file is replaced at once or not at all.

    Args:
        path: ends in .safetensors.
        kind: what it is, for the reader.
        arrays: numbers by name, stored as float32 or their own whole-number type.
        about: facts that JSON can hold; among them those of :class:`MadeFor`.
    """
    from safetensors.numpy import save

    head = {**about, "kind": kind, "version": VERSION}
    plain = {
        name: np.ascontiguousarray(array, array.dtype if array.dtype.kind in "iu" else np.float32)
        for name, array in arrays.items()
    }
    data = save(plain, metadata={_KEY: json.dumps(head, sort_keys=True)})
    write_whole(path, lambda partial: partial.write_bytes(data))


def read(path: Path, kind: str) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Read a model.

    Returns:
        Its numbers by name, and its facts.

    Raises:
        ModelFileError: when there is no such file, or it is no model of this kind and version.
    """
    advice = f"allowed: a {kind} made by tethernet_learning, format version {VERSION}"
    arrays, head = read_any(path, advice)
    if (head.get("kind"), head.get("version")) != (kind, VERSION):
        found = f"a {head.get('kind')}, format version {head.get('version')}"
        old = head.get("kind") == kind and head.get("version") == VERSION - 1
        convert = f"; tethernet models convert {path} --system NAME|FILE makes one of it" if old else ""
        raise ModelFileError(f"{path} is {found}; {advice}{convert}")
    return arrays, head


def read_any(path: Path, advice: str) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Read a model of any kind and version.

    Args:
        path: the file.
        advice: what is allowed, for errors.

    Raises:
        ModelFileError: when there is no such file, or it does not say what it is.
    """
    from safetensors import SafetensorError, safe_open

    try:
        with safe_open(path, framework="np") as file:
            head = json.loads((file.metadata() or {}).get(_KEY, "null"))
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a dict
    except (OSError, SafetensorError, ValueError) as error:
        raise ModelFileError(f"{path} cannot be read as a model: {error}; {advice}") from error
    if not isinstance(head, dict):
        raise ModelFileError(f"{path} does not say what it is; {advice}")
    return arrays, head


def check_shapes(path: Path, arrays: dict[str, np.ndarray], shapes: dict[str, tuple[int | None, ...]]) -> None:
    """Make sure that arrays are there, have these shapes and are finite; None in a shape stands for any length.

    Raises:
        ModelFileError: naming the array.
    """
    for name, shape in shapes.items():
        found = arrays[name].shape if name in arrays else None
        fits = found is not None and len(found) == len(shape)
        if found is None or not fits or any(want not in (None, have) for want, have in zip(shape, found, strict=True)):
            raise ModelFileError(f"{path}: array {name!r} is {found or 'missing'}; allowed: shape {shape}")
        if not np.isfinite(arrays[name]).all():
            raise ModelFileError(f"{path}: array {name!r} is not finite")


def file_fingerprint(path: Path) -> str:
    """Short hash of a file's contents."""
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def commit() -> str:
    """The commit of these sources, with "-dirty" where they were changed since; "unknown" without git."""
    try:
        words = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty", "--abbrev=40"]
        done = subprocess.run([*words, "--exclude=*"], capture_output=True, text=True, timeout=20, check=True)
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return done.stdout.strip() or "unknown"
