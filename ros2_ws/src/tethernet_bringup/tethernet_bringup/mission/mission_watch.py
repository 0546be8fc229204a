"""What is watched from the first process to the last: deaths, hangs, silent drivers, strangers, interrupts."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from tethernet_bringup.mission.drivers import DriverWatch
from tethernet_bringup.mission.flight_plan import FlightPlan
from tethernet_bringup.mission.graph import UnexpectedPublisherWatch
from tethernet_bringup.mission.interrupts import Interrupts
from tethernet_bringup.mission.live_display import Display
from tethernet_bringup.mission.outcome import FlightRecord
from tethernet_bringup.mission.supervisor import Exit, Supervisor
from tethernet_bringup.nodes import mu_of
from tethernet_core.mission import Phase
from tethernet_core.settings import NANOSECOND_S
from tethernet_core.shown import SHORT, shown
from tethernet_ros import topics

if TYPE_CHECKING:
    from tethernet_bringup.mission.monitor_node import Monitor
    from tethernet_bringup.pulse import Pulse

SPIN_S = 0.05
"""[s] wall time between two looks at everything."""
BRISK_S = 0.01
"""[s] The same where all that is left before launch is to look: whatever has come meanwhile is seen that much later."""
_LOOK_PERIOD_S = 1.0
"""[s] wall time between two looks at who publishes what."""


class MissionFaultError(Exception):
    """The mission cannot go on; the message says why."""


class MissionWatch:
    """Steps a mission on and looks after all that can go wrong meanwhile."""

    def __init__(
        self, plan: FlightPlan, supervisor: Supervisor, interrupts: Interrupts, record: FlightRecord, display: Display
    ):
        """Args:
        plan: what is flown.
        supervisor: whose processes are watched.
        interrupts: end the mission early.
        record: gets what is found out.
        display: shows it.
        """
        self._plan = plan
        self._supervisor = supervisor
        self._interrupts = interrupts
        self._record = record
        self._display = display
        self.monitor: Monitor | None = None
        """The command's own node, once it is in the graph."""
        self.pulse: Pulse | None = None
        """Of the nodes that are asked for a sign of life."""
        self.drivers: DriverWatch | None = None
        """Of external MUs."""
        self.unexpected: UnexpectedPublisherWatch | None = None
        """Of strangers."""
        self.started = self.launched = False
        """Whether the planner has been told to start, and whether the MUs fly."""
        self._look_due = 0.0

    @property
    def joined(self) -> Monitor:
        """The command's own node in the graph."""
        if self.monitor is None:
            raise MissionFaultError("the command is not in the graph")
        return self.monitor

    def wait(
        self,
        done: Callable[[], bool],
        timeout_s: float,
        problem: Callable[[], str],
        excused: Callable[[], bool] = lambda: False,
        every_s: float = SPIN_S,
    ) -> None:
        """Step on until it is done.

        Args:
            done: whether it is.
            timeout_s: how long that may take [s].
            problem: what to say of it if it takes longer.
            excused: while this holds, time does not count.
            every_s: time of a step [s].

        Raises:
            MissionFaultError: when it takes longer, and what :meth:`step` raises.
        """
        deadline = time.monotonic() + timeout_s
        while not done():
            if excused():
                deadline = time.monotonic() + timeout_s
            if time.monotonic() > deadline:
                raise MissionFaultError(problem())
            self.step(every_s)

    def step(self, spin_s: float = SPIN_S) -> None:
        """Take what messages there are, then look at everything.

        Args:
            spin_s: how long to wait for messages [s].

        Raises:
            MissionFaultError: when the mission cannot go on.
            MissionInterrupt: when somebody ends it.
        """
        self.joined.spin(spin_s)
        self._interrupts.check()
        for death in self._supervisor.deaths():
            self._on_death(death)
        if self.pulse is not None:
            for name in self.pulse.update():
                self._on_hang(name)
        if self.drivers is not None and self.launched and not self._record.phase.over:
            self._look_after_drivers(self.drivers)
        if self.unexpected is not None and time.monotonic() >= self._look_due:
            self._look_due = time.monotonic() + _LOOK_PERIOD_S
            for node, topic in self.unexpected.update():
                self._on_stranger(node, topic)
        self._display.flight(self._record)
        if self._record.sim is not None and self._record.sim.fault:
            raise MissionFaultError(self._record.sim.fault)

    def _look_after_drivers(self, drivers: DriverWatch) -> None:
        held_s = self._plan.control.held_ns * NANOSECOND_S
        for mu, silent in drivers.changes(self._record.common_ns or 0):
            if silent:
                goes_on = "the others fly on and close the net without it"
                if self._record.phase == Phase.HOLDING:
                    goes_on = "the hold test goes on, in which all units are off"
                self._warn(
                    f"the driver of MU {mu} has fallen silent: no odometry for more than {held_s:g} s, zero thrust; "
                    f"{goes_on}"
                )
            else:
                self._display.note(f"the driver of MU {mu} is heard again")

    def _on_hang(self, name: str) -> None:
        text = f"{name} hangs: it has answered nothing for {self._plan.parameters.hang_timeout_s:g} s"
        mu = mu_of(name)
        if mu is None or not self.started:
            raise MissionFaultError(text)
        self._record.lost_controllers.add(mu)
        self._warn(f"{text}; {self._without_controller}")

    @property
    def _without_controller(self) -> str:
        """What becomes of the mission whose controller is lost now."""
        if self._record.phase == Phase.HOLDING:
            return "the hold test goes on, in which all units are off"
        return "the mission goes on, its thrust held for a moment and then zero"

    def _on_stranger(self, node: str, topic: str) -> None:
        if topic in map(topics.mu_odometry, self._plan.external):
            heard = "it cannot be told from the driver and is heard like it"
        else:
            # Whoever flies with the mission's own profile is in its partition; the graph does not tell partitions.
            heard = "not heard, unless with this mission's own DDS profile"
            if not self._plan.protected:
                heard = "the mission's nodes may obey it"
        self._warn(f"{name_of(node)}, which is no node of this mission, publishes {topic}: {heard}")

    def _warn(self, text: str) -> None:
        """Say it at once, and again at the end."""
        when = f"at {self._record.time_s:.1f} s" if self._record.time_s is not None else "before launch"
        text = f"{when}: {text}"
        self._display.note(text)
        self._record.warnings.append(text)

    def _on_death(self, death: Exit) -> None:
        if self._record.phase.over and death.code == 0:
            return  # it has done its part
        self._display.note(death.report())
        if death.node.bystander:
            self._record.warnings.append(f"{death.node.name} died ({death.how}); the mission went on without it")
            return
        if self.pulse is not None:
            self.pulse.forget(death.node.name)
        mu = mu_of(death.node.name)
        if death.node.essential or mu is None or not self.started:
            raise MissionFaultError(_why(death))
        self._record.lost_controllers.add(mu)
        self._record.warnings.append(f"{death.node.name} died ({death.how}); {self._without_controller}")


def _why(death: Exit) -> str:
    last = f": {death.tail[-1].strip()}" if death.tail else ""
    return f"{death.node.name} died ({death.how}){last}"


def name_of(node: str) -> str:
    """A node's name as it can be shown: it is somebody else's, and need not be what ROS allows."""
    return shown(node, SHORT) or "a nameless node"
