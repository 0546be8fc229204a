"""A described system: hardware with a digest, a description that makes it again, and a summary."""

from __future__ import annotations

import functools
from dataclasses import dataclass

from .digest import hardware_digest
from .hardware import Hardware
from .summary import summary_lines
from .writing import description_text


@dataclass(frozen=True, eq=False)
class System(Hardware):
    """The hardware of a mission. Two systems are equal when they have the same name, hardware and parameters."""

    @functools.cached_property
    def digest(self) -> str:
        """SHA-256 of the hardware, however it is described; name, description and parameters do not count."""
        return hardware_digest(self)

    def to_yaml(self) -> str:
        """A description that makes an equal system, wherever it lies."""
        return description_text(self.content)

    def summary(self) -> list[str]:
        """What the system is, in lines of text."""
        return summary_lines(self, self.digest)

    def __repr__(self) -> str:
        """Name and hardware, in a line."""
        return f"System({self.name}, {self.digest[:16]})"

    def __eq__(self, other: object) -> bool:
        """Same name, hardware and parameters."""
        if not isinstance(other, System):
            return NotImplemented
        return (self.name, self.digest, self.parameters) == (other.name, other.digest, other.parameters)

    def __hash__(self) -> int:
        """Of name and hardware."""
        return hash((self.name, self.digest))
