"""Descriptions as YAML text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import yaml

from .yaml_text import DescriptionLoader


class _Dumper(yaml.SafeDumper):
    """Tables as blocks, short lists in a line, numbers to the last bit."""


# What is plain text to the one must be to the other.
_Dumper.yaml_implicit_resolvers = DescriptionLoader.yaml_implicit_resolvers


def _text(dumper: yaml.SafeDumper, text: str) -> yaml.Node:
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style="|" if "\n" in text else None)


def _float(dumper: yaml.SafeDumper, value: float) -> yaml.Node:
    return dumper.represent_scalar("tag:yaml.org,2002:float", repr(value))


def _sequence(dumper: yaml.SafeDumper, items: list[Any] | tuple[Any, ...]) -> yaml.Node:
    flat = all(not isinstance(item, list | dict) for item in items)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", items, flow_style=flat)


_Dumper.add_representer(str, _text)
_Dumper.add_representer(float, _float)
_Dumper.add_representer(list, _sequence)
_Dumper.add_representer(tuple, _sequence)


def description_text(content: Mapping[str, Any]) -> str:
    """YAML text of a description."""
    return str(yaml.dump(content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=120))
