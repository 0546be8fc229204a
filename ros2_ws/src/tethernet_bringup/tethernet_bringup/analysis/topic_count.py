"""How completely a topic is recorded: times and counters of its messages, as they are read from a bag."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field


@dataclass
class TopicCount:
    """How completely a topic is recorded."""

    type_name: str
    times: array[int] = field(default_factory=lambda: array("q"))
    """On the mission's clock [ns]."""
    never_arrived: int = 0
    """Messages that the publisher counted and the recorder did not get."""
    newest: int = -1
    shared: bool = False
    """Several publishers: their counters say nothing."""

    @property
    def is_counted(self) -> bool:
        """Whether its messages have counters: most recorders keep none, SQLite bags have no place for them."""
        return self.newest > 0

    def count(self, time_ns: int, sequence: int) -> None:
        """Count one message."""
        self.times.append(time_ns)
        if sequence < self.newest:
            self.shared = True
        elif 0 <= self.newest < sequence - 1:
            self.never_arrived += sequence - 1 - self.newest
        self.newest = sequence
