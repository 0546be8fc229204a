"""Where the models that come with the package lie, and which words of users mean a model's file."""

from __future__ import annotations

from pathlib import Path

from tethernet_core.shown import SHORT, shown

POLICY = "policy"
SURROGATE = "surrogate"
KINDS = (POLICY, SURROGATE)
"""Kinds of models; the same words as in their files."""

SUFFIX = ".safetensors"
FOLDER = Path(__file__).parent / "models"


def place(kind: str, system: str) -> Path:
    """Where a shipped model belongs, whether it is there or not.

    Args:
        kind: one of KINDS.
        system: name of the system that it is for.
    """
    return FOLDER / f"{kind}_{system}{SUFFIX}"


def shipped(kind: str) -> list[str]:
    """Names of the systems for which a model is shipped, sorted.

    Args:
        kind: one of KINDS.
    """
    return sorted(file.stem.removeprefix(f"{kind}_") for file in FOLDER.glob(f"{kind}_*{SUFFIX}"))


def means_file(word: str) -> bool:
    """Whether a word names a file of a model rather than something that is known by its name."""
    return word.endswith(SUFFIX) or "/" in word


def absolute(word: str) -> str:
    """The word, as an absolute path where it names a file: so that every process of a mission finds it."""
    return str(Path(word).absolute()) if means_file(word) else word


def find(kind: str, word: str, shipped_word: str, system: str) -> Path:
    """The file that a word of the user means.

    Args:
        kind: one of KINDS.
        word: a path, or the word that stands for the shipped model.
        shipped_word: that word.
        system: name of the system that it is for.

    Raises:
        FileNotFoundError: when no model is shipped for this system, or there is no such file; says what to do.
    """
    file = Path(word) if word != shipped_word else place(kind, system)
    try:
        if file.is_file():
            return file
    except OSError as error:  # such as a name that is too long
        raise FileNotFoundError(f"there can be no file {shown(word, SHORT)}: {error.strerror}") from error
    if word != shipped_word:
        raise FileNotFoundError(f"there is no file {shown(word, SHORT)}")
    there = ", ".join(shipped(kind)) or "none"
    raise FileNotFoundError(
        f"no {kind} for system {shown(system, SHORT)} is shipped with this version (shipped: {there}); give the path "
        f"of one that tethernet train has made for it (PATH/{kind}{SUFFIX}), or put it in its place with "
        "tethernet models install"
    )
