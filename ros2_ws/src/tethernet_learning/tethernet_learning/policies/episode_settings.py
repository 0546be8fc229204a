"""What every command that learns from episodes lets its user choose."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from tethernet_core.system import System
from tethernet_learning import assumed_numbers
from tethernet_learning.flight_settings import Flight
from tethernet_learning.symmetries import group
from tethernet_planner.inference import task
from tethernet_planner.inference.task import Task, aimed_task_of
from tethernet_sim.fly import Settings


@dataclass(frozen=True)
class EpisodeSettings:
    """Which episodes are flown, and what they are worth."""

    system: System
    """That is flown."""
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
    assumed: str = assumed_numbers.AS_DESCRIBED
    """Numbers that nobody has measured, one of :data:`.assumed_numbers.CHOICES_OF_TRAINING`: as described, drawn at
    random, or each at either end of its range."""

    def __post_init__(self) -> None:
        """Raises:
        ValueError: naming the value and what is allowed.
        """
        if self.symmetry not in task.SYMMETRIES:
            raise ValueError(f"symmetry {self.symmetry!r}; allowed: {', '.join(task.SYMMETRIES)}")
        if self.assumed not in assumed_numbers.CHOICES_OF_TRAINING:
            raise ValueError(f"assumed {self.assumed!r}; allowed: {', '.join(assumed_numbers.CHOICES_OF_TRAINING)}")

    def check_ends(self, name: str, flown_together: int) -> None:
        """Make sure that what is flown together has all choices of the assumed numbers, where each is taken in turn.

        Args:
            name: of the setting that says how many scenarios are flown together.
            flown_together: its value.

        Raises:
            ValueError: naming the value and what is allowed.
        """
        if self.assumed != assumed_numbers.ENDS:
            return
        choices = len(assumed_numbers.at_ends(Flight(self.system, Settings.load(self.system))))
        needed = assumed_numbers.GROUP * choices
        if flown_together % needed:
            raise ValueError(
                f"{flown_together} {name}; allowed with assumed = {assumed_numbers.ENDS}: multiples of {needed}, "
                f"{assumed_numbers.GROUP} with each of {choices} choices of the assumed numbers"
            )

    @property
    def task(self) -> Task:
        """What is learned: bounds, grid, and the images under which one debris position stands for others.

        Raises:
            TaskError: for a system without units.
        """
        return learned_task(self.system, self.symmetry)

    def as_json(self) -> dict[str, Any]:
        """All of it as JSON holds it, the system by its name."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return {**values, "system": self.system.name}


def learned_task(system: System, symmetry: str) -> Task:
    """What is learned for a system.

    Args:
        system: that is flown.
        symmetry: one of :data:`.task.SYMMETRIES`.

    Raises:
        TaskError: for a system without units.
    """
    plain = aimed_task_of(system)
    return plain if symmetry == "none" else plain.with_images(group(system))
