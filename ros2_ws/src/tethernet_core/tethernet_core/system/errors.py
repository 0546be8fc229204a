"""Errors of system descriptions, and the place in a description that they name."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass

from ..parameters import ParameterError
from ..shown import SHORT, shown


class DescriptionError(ParameterError):
    """A system's description cannot be read, or describes what cannot be built or flown."""

    def __init__(self, *sentences: str):
        """Args:
        sentences: one for each mistake that was found.
        """
        self.sentences = sentences
        more = f" (and {len(sentences) - 1} more)" if len(sentences) > 1 else ""
        super().__init__("".join(sentences[:1]) + more)


class Findings:
    """Collects the mistakes of parts that can be read whether or not the others can."""

    def __init__(self) -> None:
        self.sentences: list[str] = []

    @contextlib.contextmanager
    def collected(self) -> Iterator[None]:
        """Keep the mistakes of what is done within."""
        try:
            yield
        except DescriptionError as error:
            self.sentences += (sentence for sentence in error.sentences if sentence not in self.sentences)

    def raise_them(self) -> None:
        """Raises: DescriptionError: with all mistakes, if there are any."""
        if self.sentences:
            raise DescriptionError(*self.sentences)


@dataclass(frozen=True)
class Place:
    """A place in a description: ``units[3].node`` of a system."""

    system: str
    """Name or file of the description."""
    path: str = ""
    """Full path of the entry in the description."""

    def __truediv__(self, key: str) -> Place:
        """The entry ``key`` of this section."""
        return Place(self.system, f"{self.path}.{key}" if self.path else key)

    def __getitem__(self, index: int) -> Place:
        """The element ``index`` of this list."""
        return Place(self.system, f"{self.path}[{index}]")

    def error(self, value: object, why: str, allowed: str) -> DescriptionError:
        """An error about the value given here.

        Args:
            value: what was given.
            why: what is wrong with it.
            allowed: what is allowed.
        """
        return DescriptionError(f"system {self.system}: {self.path} = {_brief(value)}: {why}; allowed: {allowed}")

    def problem(self, why: str, allowed: str) -> DescriptionError:
        """An error about this place as a whole: what is wrong, and what is allowed."""
        return DescriptionError(f"system {self.system}: {self.path or 'description'}: {why}; allowed: {allowed}")


def _brief(value: object) -> str:
    return shown(repr(value), SHORT)
