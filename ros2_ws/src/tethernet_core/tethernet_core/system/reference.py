"""The table of all entries of a description, as the README shows it."""

from __future__ import annotations

import dataclasses
from typing import Any

from . import sections
from .entries import allowed_text, entry_kinds
from .parts import Chaser, Tether

_SECTIONS: tuple[tuple[str, type], ...] = (
    ("", sections.DescriptionSection),
    ("net", sections.NetSection),
    ("net.square", sections.SquareSection),
    ("net.hexagonal, net.triangular", sections.LatticeSection),
    ("net.file", sections.FileSection),
    ("net.graph", sections.GraphSection),
    ("net.thread", sections.ThreadSection),
    ("net.masses[i]", sections.MassSection),
    ("unit, units[i]", sections.UnitSection),
    ("closing.docking", sections.DockingSection),
    ("closing.winch", sections.WinchSection),
    ("launch.ejected", sections.EjectedSection),
    ("debris", sections.DebrisSection),
    ("debris.cqi", sections.QualitySection),
    ("chaser", Chaser),
    ("tether", Tether),
    ("capture", sections.CaptureSection),
    ("aiming", sections.AimingSection),
)


def entries_table() -> str:
    """Markdown: one row an entry, with unit, range, default and meaning."""
    rows = ["| entry | what it is | unit | allowed | default |", "|---|---|---|---|---|"]
    for name, cls in _SECTIONS:
        rows.append(f"| **{name or 'description'}** | | | | |")
        kinds = entry_kinds(cls)
        for field in dataclasses.fields(cls):
            meta = field.metadata
            cells = (
                f"`{field.name}`",
                meta["description"],
                meta["unit"],
                _allowed(field, kinds[field.name]),
                _default(field),
            )
            rows.append("| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(rows)


def _allowed(field: dataclasses.Field[Any], kind: Any) -> str:
    if field.metadata["form"] == sections.NODE_FORM:
        return "a node"
    return allowed_text(field, kind).removesuffix(f" {field.metadata['unit']}")


def _default(field: dataclasses.Field[Any]) -> str:
    if field.metadata["default_text"]:
        return str(field.metadata["default_text"])
    if field.default is dataclasses.MISSING:
        return "must be given"
    if field.default in (None, "", ()):
        return "none"
    return str(field.default).lower() if isinstance(field.default, bool) else f"{field.default}"
