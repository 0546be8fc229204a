"""What every command that learns from episodes lets its user choose."""

from __future__ import annotations

from dataclasses import dataclass

from tethernet_planner.inference import task


@dataclass(frozen=True)
class EpisodeSettings:
    """Which episodes are flown, and what they are worth."""

    mus: int
    """4 or 8."""
    seed: int = 0
    """Of scenarios, weights and exploration: one seed gives one result."""
    episodes: int = 11360
    """Budget [P]."""
    reward: str = "threshold"
    """One of :data:`.reward.VARIANTS`."""
    symmetry: str = "none"
    """One of :data:`.task.SYMMETRIES`."""
    source: str = "surrogate"
    """What captures come to: ``surrogate`` [P] or ``full``."""
    noise: str = "split"
    """Of the surrogate, one of :data:`.surrogate_file.NOISES`; ``paper`` [P]."""

    def __post_init__(self) -> None:
        """Raises:
        ValueError: naming the value and what is allowed.
        """
        if self.symmetry not in task.SYMMETRIES:
            raise ValueError(f"symmetry {self.symmetry!r}; allowed: {', '.join(task.SYMMETRIES)}")
