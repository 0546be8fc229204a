"""YAML of descriptions, read with the rules of YAML 1.2's core schema and limits that no file can exceed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

from ..parameters import StrictLoader
from .errors import DescriptionError

LARGEST_FILE_BYTES = 4 * 1024 * 1024
"""A description with 10,000 nodes and their threads written into it takes about 1 MiB."""


class DescriptionLoader(StrictLoader):
    """As parameter files are read, but with the scalars of YAML 1.2."""


DescriptionLoader.yaml_implicit_resolvers = {}
# YAML 1.1, as the library has it, takes 7e10 for text, "no" for false and 1:30 for ninety.
for _tag, _pattern, _first in (
    ("bool", r"^(?:true|True|TRUE|false|False|FALSE)$", "tTfF"),
    ("int", r"^[-+]?[0-9]+$", "-+0123456789"),
    (
        "float",
        r"^(?:[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))$",
        "-+.0123456789",
    ),
    ("null", r"^(?:~|null|Null|NULL|)$", ["~", "n", "N", ""]),
):
    DescriptionLoader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(_pattern), list(_first))


def _construct_int(loader: yaml.SafeLoader, node: Any) -> int:
    return int(loader.construct_scalar(node))  # 010 is ten


def _construct_float(loader: yaml.SafeLoader, node: Any) -> float:
    return float(str(loader.construct_scalar(node)).lower().replace(".inf", "inf").replace(".nan", "nan"))


DescriptionLoader.add_constructor("tag:yaml.org,2002:int", _construct_int)
DescriptionLoader.add_constructor("tag:yaml.org,2002:float", _construct_float)


def read_mapping(path: Path) -> dict[str, Any]:
    """Read a description's file.

    Raises:
        DescriptionError: where it cannot be read, is no YAML, is too large or is no mapping.
    """
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE_BYTES + 1)
    except OSError as error:
        raise DescriptionError(
            f"cannot read the system's description {path}: {error.strerror or error}; allowed: the name of a shipped "
            "system or the path of a readable YAML file"
        ) from error
    if len(data) > LARGEST_FILE_BYTES:
        raise DescriptionError(
            f"{path} holds more than {LARGEST_FILE_BYTES // 1024**2} MiB; allowed: a description in YAML, with "
            "a large net in a file of its own (net.file)"
        )
    return parse_mapping(data, str(path))


def parse_mapping(data: bytes | str, source: str) -> dict[str, Any]:
    """Parse a description.

    Args:
        data: YAML text.
        source: named in errors.

    Raises:
        DescriptionError: where it is no YAML or no mapping.
    """
    try:
        text = data.decode("utf-8-sig") if isinstance(data, bytes) else data
        content = yaml.load(text, DescriptionLoader)
    except (yaml.YAMLError, ValueError) as error:  # a number of five thousand digits, bytes that are no text
        raise DescriptionError(f"{source} is not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(content, dict):
        raise DescriptionError(
            f"{source} holds {'nothing' if content is None else type(content).__name__}; allowed: a mapping of a "
            "system's sections (net, units, closing, debris, ...)"
        )
    return content
