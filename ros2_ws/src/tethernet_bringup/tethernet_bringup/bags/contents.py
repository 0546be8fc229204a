"""What is found in a bag, whatever its storage: messages, topics, facts, and what is wrong with it."""

from __future__ import annotations

from dataclasses import dataclass, field

from tethernet_bringup.bags.metadata import BagTopic

LARGEST_RECORD_BYTES = 1 << 26
"""The longest message or chunk that is read [B]. Recorders write chunks of about 1 MiB."""
LARGEST_DESCRIPTION_BYTES = 1 << 20
"""The longest message definition, topic description or set of facts [B]; our longest definition has 20 kB."""
MOST_DESCRIPTION_BYTES = 1 << 24
"""All descriptions of a bag together [B]."""
MOST_PROBLEMS = 20
"""Problems that are listed one by one; a file of rubbish may have millions."""


@dataclass(frozen=True, slots=True)
class BagMessage:
    """One message as recorded."""

    topic: str
    log_time: int
    """[ns]"""
    publish_time: int
    """[ns]"""
    sequence: int
    data: bytes


@dataclass
class BagContents:
    """What has been found so far."""

    topics: dict[str, BagTopic] = field(default_factory=dict)
    """All topics met so far, by name."""
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    """Named texts met so far: "tethernet" holds the facts about the run."""
    problems: list[str] = field(default_factory=list)
    """What is wrong with the bag, one sentence each, the first :data:`MOST_PROBLEMS` of them."""
    problem_count: int = 0
    """All problems, listed or not."""
    verified: bool = True
    """Whether checksums over every byte of the bag were there and fit; without them "no problem" is no proof."""
    description_bytes: int = 0
    """Length of all descriptions kept so far [B]."""

    def start_anew(self) -> None:
        """Before the bag is read once more: topics and facts stay known, the problems are found again."""
        self.problems.clear()
        self.problem_count = 0
        self.verified = True
        self.description_bytes = 0

    def note(self, problem: str) -> None:
        """Put a problem on the list."""
        self.verified = False
        self.problem_count += 1
        if len(self.problems) < MOST_PROBLEMS:
            self.problems.append(problem)
        elif len(self.problems) == MOST_PROBLEMS:
            self.problems.append("and more of the like")

    def has_room_for(self, length: int) -> bool:
        """Whether one more description may be kept; if so, it is counted.

        Args:
            length: of the description [B].
        """
        if length > LARGEST_DESCRIPTION_BYTES or self.description_bytes + length > MOST_DESCRIPTION_BYTES:
            return False
        self.description_bytes += length
        return True
