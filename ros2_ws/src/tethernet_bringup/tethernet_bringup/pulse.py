"""Whether the nodes still answer: a process that hangs is alive to the operating system and dead to the mission."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

_ASK_PERIOD_S = 1.0
"""[s] wall time between two questions to one node."""
_LONGEST_LOOK_S = 1.0
"""[s] what one look counts at most: where this process stood still itself, nobody could have answered it."""

Answer = Callable[[], object | None]
"""Gives the answer to a question; None until it has come."""


class Pulse:
    """Asks each node now and then for a sign of life, and says which have given none for too long."""

    def __init__(
        self,
        ask: Mapping[str, Callable[[], Answer | None]],
        patience_s: float,
        clock: Callable[[], float] = time.monotonic,
    ):
        """Args:
        ask: puts the question to a node, by its name; gives None while it cannot be reached.
        patience_s: a node that answers nothing for so long hangs [s].
        clock: wall time [s].
        """
        self._ask, self._patience_s, self._clock = dict(ask), patience_s, clock
        self._answers: dict[str, Answer | None] = {}
        self._asked_s = dict.fromkeys(ask, -_ASK_PERIOD_S)
        self._silent_s = dict.fromkeys(ask, 0.0)
        self._looked_s = clock()
        self.hung: set[str] = set()
        """Nodes that hang now."""

    def watch(self, node: str, ask: Callable[[], Answer | None]) -> None:
        """Watch one more.

        Args:
            node: its name.
            ask: likewise.
        """
        self._ask[node] = ask
        self._asked_s[node], self._silent_s[node] = -_ASK_PERIOD_S, 0.0

    def forget(self, node: str) -> None:
        """This node has ended: nothing is expected of it any more."""
        self._ask.pop(node, None)

    def update(self) -> list[str]:
        """Look at the answers and ask again; returns the nodes that have been found to hang since the last look."""
        now = self._clock()
        passed_s = min(now - self._looked_s, _LONGEST_LOOK_S)
        self._looked_s = now
        news = []
        for node, ask in self._ask.items():
            answer = self._answers.get(node)
            if answer is not None and answer() is not None:
                self._answers[node] = None
                self._silent_s[node] = 0.0
                self.hung.discard(node)
            elif answer is not None or now - self._asked_s[node] >= _ASK_PERIOD_S:
                # It owes an answer, or cannot even be asked.
                self._silent_s[node] += passed_s
            if self._answers.get(node) is None and now - self._asked_s[node] >= _ASK_PERIOD_S:
                question = ask()
                if question is not None:
                    self._answers[node], self._asked_s[node] = question, now
            if self._silent_s[node] > self._patience_s and node not in self.hung:
                self.hung.add(node)
                news.append(node)
        return news
