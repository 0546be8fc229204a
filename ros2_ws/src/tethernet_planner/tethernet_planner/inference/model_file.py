"""Files of trained models: safetensors with what they are, what they were made from, and by what."""

from __future__ import annotations

import hashlib
import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core.atomic_file import write_whole
from tethernet_core.errors import InputError

VERSION = 2
"""Of the format; readers refuse others."""

_KEY = "tethernet"


class ModelFileError(InputError):
    """A file is not what it should be: what was found, and what is allowed."""


def write(path: Path, kind: str, arrays: dict[str, np.ndarray], about: dict[str, Any]) -> None:
    """Write a model; an existing file is replaced at once or not at all.

    Args:
        path: ends in .safetensors.
        kind: what it is, for the reader.
        arrays: numbers by name, stored as float32 or their own whole-number type.
        about: facts that JSON can hold; among them ``mus``.
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
    from safetensors import SafetensorError, safe_open

    advice = f"allowed: a {kind} made by tethernet_learning, format version {VERSION}"
    try:
        with safe_open(path, framework="np") as file:
            head = json.loads((file.metadata() or {}).get(_KEY, "null"))
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a dict
    except (OSError, SafetensorError, ValueError) as error:
        raise ModelFileError(f"{path} cannot be read as a model: {error}; {advice}") from error
    if not isinstance(head, dict):
        raise ModelFileError(f"{path} does not say what it is; {advice}")
    if (head.get("kind"), head.get("version")) != (kind, VERSION):
        found = f"a {head.get('kind')}, format version {head.get('version')}"
        raise ModelFileError(f"{path} is {found}; {advice}")
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
