"""Which systems rows of outcomes and scenarios are of."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

from tethernet_core.system import DescriptionError, System, load_system, system_from_text
from tethernet_core.system.option import system_with_units
from tethernet_learning.campaigns.columns import DIGEST, MUS, SYSTEM, Row
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_sim.scenario import default_system

_SHOWN_DIGITS = 12


class FlownSystems:
    """Systems by name: those that are given, those that the description beside an outcomes file holds, those that are
    shipped, and descriptions by path.
    """

    def __init__(self, given: Iterable[System] = (), files: Iterable[Path] = ()):
        """Args:
        given: these come first.
        files: outcomes files, for the descriptions that lie beside them.
        """
        self._known: dict[str, list[System]] = {}
        for system in (*given, *(system for file in files for system in _described(file))):
            self._known.setdefault(system.name, []).append(system)

    def of(self, name: str | None, digest: str | None, units: int | None) -> System:
        """The system of a row.

        Args:
            name: its name or the path of its description; None in files that are older than the column: then the
                number of units tells.
            digest: of its hardware; None where it is not told.
            units: how many it has; None where it is not told.

        Raises:
            CampaignError: where there is no such system, or it is not the one that was flown.
        """
        if name is None:
            system = load_system(default_system()) if units is None else system_with_units(units)
        else:
            system = self._named(name, digest)
        if digest is not None and system.digest != digest:
            raise CampaignError(
                f"{DIGEST} = {digest[:_SHOWN_DIGITS]}..., but {system.name} is {system.digest[:_SHOWN_DIGITS]}...: the "
                f"description has changed since; give the one that was flown with --system FILE, or empty {DIGEST}"
            )
        if units is not None and system.unit_count != units:
            raise CampaignError(f"{MUS} = {units}, but system {system.name} has {system.unit_count} units")
        return system

    def of_row(self, row: Row) -> System:
        """See :meth:`of`."""
        name, digest, units = row.get(SYSTEM), row.get(DIGEST), row.get(MUS)
        return self.of(
            None if name is None else str(name),
            None if digest is None else str(digest),
            None if units is None else int(units),
        )

    def _named(self, name: str, digest: str | None) -> System:
        known = self._known.get(name, [])
        for system in known:
            if digest is None or system.digest == digest:
                return system
        try:
            return load_system(name)
        except DescriptionError as error:
            if known:
                return known[0]
            raise CampaignError(f"{SYSTEM} = {name!r}: {error}; an own one can be given with --system FILE") from error


def descriptions(systems: Sequence[System]) -> dict[str, str]:
    """Texts of systems by their names, from which they can be made again."""
    return {system.name: system.to_yaml() for system in systems}


def _described(file: Path) -> list[System]:
    """Systems of the description beside an outcomes file; none where there is no such or it holds none."""
    beside = file.with_name(file.name + ".json")
    if not beside.is_file():
        return []
    try:
        texts = json.loads(beside.read_text(encoding="utf-8")).get("systems", {})
        return [system_from_text(text, folder=file.parent, source=name) for name, text in texts.items()]
    except (AttributeError, ValueError, OSError) as error:
        raise CampaignError(f"{beside} is no campaign's: {error}; remove it, or give --system FILE") from error
