"""How many messages of a topic never arrived, by the counter that each publisher keeps."""

from __future__ import annotations


class PublicationCount:
    """Follows the counter of one topic's publisher.

    A counter that does not grow is another publisher's, or that of one that was started anew: several counters mixed
    say nothing about what was lost, so from then on nothing is counted.
    """

    def __init__(self, shared: bool = False):
        """Args:
        shared: whether several nodes may publish the topic.
        """
        self._mixed = shared
        self._newest: int | None = None
        self._lost = 0

    @property
    def lost(self) -> int:
        """Messages that the publisher has counted and that never came; 0 where that cannot be known."""
        return 0 if self._mixed else self._lost

    def take(self, sequence: int) -> None:
        """A message with this counter has come."""
        if self._newest is not None:
            if sequence <= self._newest:
                self._mixed = True
            else:
                self._lost += sequence - self._newest - 1
        self._newest = sequence
