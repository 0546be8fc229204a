"""One mission from the first process to the verdict."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from tethernet_bringup.mission.assembly import Assembly
from tethernet_bringup.mission.flight_plan import FlightPlan
from tethernet_bringup.mission.interrupts import Interrupts, MissionInterrupt
from tethernet_bringup.mission.live_display import Display
from tethernet_bringup.mission.mission_watch import BRISK_S, SPIN_S, MissionFaultError, MissionWatch
from tethernet_bringup.mission.outcome import FlightRecord
from tethernet_bringup.mission.run_folder import keep_traceback
from tethernet_bringup.mission.supervisor import Supervisor
from tethernet_core.mission import Phase
from tethernet_core.shown import SHORT, shown

if TYPE_CHECKING:
    from tethernet_bringup.mission.monitor_node import Monitor

_SETTLE_S = 1.0
"""[s] Grace for the last accounts of controllers once the verdict is there."""
_OVERTIME_S = 5.0
"""[s] mission time that the planner may take to put the end of the longest mission on record."""
_MEMORY_AFTER_S = 2.0
"""[s] wall time after launch at which memory is measured; again at the end."""


def _join_graph(record: FlightRecord) -> Monitor:
    from tethernet_bringup.mission.monitor_node import Monitor  # rclpy takes its time: bad usage and help do without

    return Monitor(record)


class Flight:
    """Runs the processes of a mission and follows it to its end."""

    def __init__(
        self,
        plan: FlightPlan,
        supervisor: Supervisor,
        interrupts: Interrupts,
        record: FlightRecord,
        display: Display,
        began: float,
        join: Callable[[FlightRecord], Monitor] = _join_graph,
    ):
        """Args:
        plan: what is flown.
        supervisor: has no process yet.
        interrupts: end the mission early.
        record: gets what is found out.
        display: shows it.
        began: when the command started [s], time.monotonic.
        join: makes the command's own node.
        """
        self._plan = plan
        self._supervisor = supervisor
        self._interrupts = interrupts
        self._record = record
        self._display = display
        self._began = began
        self._join = join
        self._watch = MissionWatch(plan, supervisor, interrupts, record, display)
        self._assembly = Assembly(plan, supervisor, self._watch, record, display)
        self._launched_at: float | None = None
        self._memory_due: float | None = None

    def fly(self) -> None:
        """Fly the mission; faults and interrupts end up in the record, and no process stays behind.

        The graph is left by :meth:`leave`.
        """
        try:
            self._interrupts.check()
            self._assembly.claim_domain()
            self._supervisor.start_all(self._plan.processes)  # they import what they need while this process looks
            self._watch.monitor = self._join(self._record)
            self._assembly.look_around()
            self._supervisor.let_in()
            self._assembly.assemble()
            self._assembly.await_drivers()
            self._assembly.know_publishers()
            self._launch()
            self._follow()
            self._await_verdict()
        except MissionInterrupt as interrupt:
            self._record.interrupted_by = str(interrupt)
        except MissionFaultError as fault:
            self._record.faults.append(str(fault))
        except OSError as error:
            self._record.faults.append(f"cannot start the nodes: {error}")
        except Exception as error:  # not foreseen: end in order all the same, and keep what a developer needs
            self._record.faults.append(keep_traceback(error, self._supervisor.log_folder))
        finally:
            self._end()

    def leave(self, status: int) -> None:
        """Leave the graph, once: after all is written and told, because the middleware may hang in it.

        Args:
            status: the process' exit status, which it then keeps all the same.
        """
        if self._watch.monitor is not None:
            self._watch.monitor.close(status)
            self._watch.monitor = None
        # Saying goodbye to a node that was killed makes its segments anew; the middleware may have come no further than
        # half a port, here or in a node that was killed while it joined.
        self._supervisor.clean_up()
        self._supervisor.call_off()

    def _launch(self) -> None:
        """Tell the planner to start and wait until the MUs fly."""
        self._watch.started = True
        answer, refusal, asked = self._watch.joined.start(), "", time.monotonic()

        def launched() -> bool:
            nonlocal answer, refusal, asked
            given = answer()
            refused = given is not None and not given[0] and self._record.phase == Phase.WAITING
            if given is not None and refused and time.monotonic() - asked >= SPIN_S:
                # It may only lack a first message, such as the debris' place: ask again until it has got it.
                answer, refusal, asked = self._watch.joined.start(), f": {given[1]}", time.monotonic()
            return self._record.launched or self._record.phase.over

        timeout = self._plan.parameters.launch_timeout_s
        self._watch.wait(
            launched,
            timeout,
            lambda: f"no launch {timeout:g} s after the planner was told to start{refusal}",
            every_s=BRISK_S,
        )
        if self._record.launched:
            self._watch.launched = True
            self._launched_at = time.monotonic()
            self._record.start_s = self._launched_at - self._began
            self._memory_due = self._launched_at + _MEMORY_AFTER_S

    def _follow(self) -> None:
        """Follow the flight until the mission is over."""
        news, heard = None, time.monotonic()
        silence = self._plan.parameters.silence_timeout_s
        while not self._record.phase.over:
            self._watch.step()
            state = self._record.state
            latest = (self._record.newest_ns, state and (state.sequence, state.confirmed))
            if latest != news:
                news, heard = latest, time.monotonic()
            elif time.monotonic() - heard > silence:
                at = f"{self._record.time_s or 0.0:.2f} s after launch"
                raise MissionFaultError(f"nothing new has been heard of the mission for {silence:g} s, at {at}")
            flown = self._record.most_flown_s
            if flown is not None and flown > self._plan.longest_s + _OVERTIME_S:
                longest = f"the longest mission takes {self._plan.longest_s:g} s"
                raise MissionFaultError(f"the planner has not ended the mission {flown:.1f} s after launch; {longest}")
            if self._memory_due is not None and time.monotonic() >= self._memory_due:
                self._memory_due = None
                self._measure_memory()
        if self._record.phase == Phase.ABORTED:
            raise MissionFaultError(f"the mission was aborted: {self._record.why_aborted}")

    def _await_verdict(self) -> None:
        """Wait for the assessor's verdict and for the last accounts."""
        from tethernet_bringup.mission.monitor_node import settled

        def told() -> bool:
            return self._record.all_judged

        def problem() -> str:
            what = "no verdict" if self._record.final is None else "no verdict on the hold"
            return f"{what} {timeout:g} s after the end of the mission"

        timeout = self._plan.parameters.verdict_timeout_s
        self._watch.wait(told, timeout, problem)
        if self._launched_at is not None:
            self._record.wall_time_s = time.monotonic() - self._launched_at
        self._measure_memory()
        deadline = time.monotonic() + _SETTLE_S
        while not settled(self._record, self._plan.simulated) and time.monotonic() < deadline:
            self._watch.step()

    def _end(self) -> None:
        """Put an early end on record, then stop everything."""
        record = self._record
        if self._launched_at is not None and record.wall_time_s is None:
            record.wall_time_s = time.monotonic() - self._launched_at
        early = record.interrupted_by or record.faults
        if early and self._watch.started and not record.phase.over:
            self._abort()
        if (monitor := self._watch.monitor) is not None:
            record.warnings += [f"{shown(name, SHORT)}: {text}" for name, text in monitor.dropped.items()]
        self._display.live("stopping")
        self._supervisor.stand_by()
        self._stop_processes(bool(early))
        self._assembly.release_domain()

    def _stop_processes(self, early: bool) -> None:
        record = self._record
        for ended in self._supervisor.stop(hurry=early):
            if ended.forced:
                record.warnings.append(f"{ended.node.name} did not end when asked and was killed")
            elif ended.code != 0 and not early:
                record.warnings.append(f"{ended.node.name} ended with {ended.how}, see its log")

    def _abort(self) -> None:
        try:
            self._watch.joined.abort()
            deadline = time.monotonic() + self._plan.parameters.abort_timeout_s
            while not self._record.phase.over and time.monotonic() < deadline:
                self._watch.joined.spin(SPIN_S)
        except Exception as error:
            self._record.warnings.append(f"the planner could not be told to abort: {error}")

    def _measure_memory(self) -> None:
        self._record.memory_mb = max(self._record.memory_mb or 0.0, self._supervisor.memory_mb())
