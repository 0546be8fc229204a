"""Checks any driver of an MU against the contract: ``tethernet check-driver --mu 3``.

Run it against the driver alone, with no mission: it stands in for the controller, and with ``--clock sim`` for the
simulator's clock too. It moves the MU: fasten it, or say ``--no-thrust``.
"""

from __future__ import annotations

import argparse
import math
import sys
import time

import rclpy
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from tethernet_control.driver_contract import Finding, Reaction, Sample, check_reaction, check_samples, table
from tethernet_control.driver_sample import driver_sample
from tethernet_core.errors import InputError
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters
from tethernet_core.subcommand import Parser, Subcommand, number, whole_number
from tethernet_core.system.option import add_system, chosen_system
from tethernet_ros import any_quality, executor, topics
from tethernet_ros.any_quality import quality_text
from tethernet_ros.conversions import set_stamp
from tethernet_ros.qos import CONTROL

_WATCH, _PUSH, _SILENCE = "watch", "push", "silence"
_FIRST_TICK = 20  # of the simulated clock: a stamp of zero means to many that none was set
_SILENCE_S = 2.0  # [s] long enough for the watchdog and two averages after it


class DriverCheck(Node):
    """Watches the driver, pushes the MU along each axis in turn, and remembers what it saw."""

    def __init__(self, options: argparse.Namespace, control: ControlParameters):
        super().__init__("check_driver")
        self.samples: list[Sample] = []
        self.reactions: list[Reaction] = []
        self._options, self._control = options, control
        self._plan = [(_WATCH, options.duration)]
        if not options.no_thrust:
            self._plan += [
                (what, options.push if what == _PUSH else _SILENCE_S) for _ in range(3) for what in (_PUSH, _SILENCE)
            ]
        self._phase, self._phase_begin_s = -1, 0.0
        self._marks: list[int] = []
        self._begin_s = time.monotonic()
        self._tick = _FIRST_TICK
        self._clock_ns: int | None = None
        self._writers: list[str] = []
        self._reader_count = 0
        self._thrust = WrenchStamped()
        self._thrust.header.frame_id = topics.FRAME
        self._thrust_topic = topics.mu_thrust(options.mu)
        self._thrust_publisher = self.create_publisher(WrenchStamped, self._thrust_topic, CONTROL)
        any_quality.subscribe(self, Odometry, topics.mu_odometry(options.mu), self._on_odometry, CONTROL)
        self._clock_publisher = self.create_publisher(Clock, topics.CLOCK, CONTROL) if options.clock == "sim" else None
        self.create_timer(control.control_period_s, self._on_period)

    @property
    def done(self) -> bool:
        """True when every phase is over, or the driver never spoke."""
        silent = not self.samples and time.monotonic() - self._begin_s > self._options.wait
        return silent or self._phase >= len(self._plan)

    def _on_period(self) -> None:
        if self._clock_publisher is not None:
            message = Clock()
            self._clock_ns = self._tick * self._control.period_ns
            set_stamp(message.clock, self._clock_ns)
            self._clock_publisher.publish(message)
            self._tick += 1

    def _on_odometry(self, message: Odometry) -> None:
        now = time.monotonic()
        clock_ns = self._clock_ns if self._clock_publisher is not None else time.time_ns()
        self.samples.append(driver_sample(message, now, clock_ns))
        writers = self.get_publishers_info_by_topic(topics.mu_odometry(self._options.mu))
        if len(writers) > len(self._writers):
            self._writers = [quality_text(writer.qos_profile) for writer in writers]
        self._reader_count = self._thrust_publisher.get_subscription_count()
        if self._phase < 0 or (
            self._phase < len(self._plan) and now - self._phase_begin_s >= self._plan[self._phase][1]
        ):
            self._phase += 1
            self._phase_begin_s = now
            self._marks.append(len(self.samples) - 1)
        if self._phase < len(self._plan):
            self._command(message)

    def _command(self, message: Odometry) -> None:
        """Answer this odometry as a controller would, in the way this phase wants it."""
        what = self._plan[self._phase][0]
        if what == _SILENCE:
            return
        axis = (self._phase - 1) // 2
        force = [0.0, 0.0, 0.0]
        if what == _PUSH:
            force[axis] = self._options.thrust
        self._thrust.header.stamp = message.header.stamp
        target = self._thrust.wrench.force
        target.x, target.y, target.z = force
        self._thrust_publisher.publish(self._thrust)
        if what == _PUSH:
            # Nonsense after every good command: a driver that lets NaN through shows it at once.
            target.x = target.y = target.z = math.nan
            self._thrust_publisher.publish(self._thrust)

    def _readers(self) -> str:
        """How many hear the thrust; where nobody does, what those ask for that would like to."""
        deaf = [quality_text(r.qos_profile) for r in self.get_subscriptions_info_by_topic(self._thrust_topic)]
        if self._reader_count or not deaf:
            return str(self._reader_count)
        return f"0; {_counted(deaf)} asked, {quality_text(CONTROL)} offered"

    def findings(self) -> list[Finding]:
        """What the whole run says."""
        mu = self._options.mu
        found = [
            Finding(f"one publisher of {topics.mu_odometry(mu)}", len(self._writers) == 1, _counted(self._writers)),
            Finding(f"{topics.mu_thrust(mu)} is listened to", self._reader_count >= 1, self._readers()),
            *check_samples(mu, self.samples, topics.FRAME, self._control),
        ]
        for axis in range(3 if not self._options.no_thrust else 0):
            push = 1 + 2 * axis
            if len(self._marks) <= push + 1:
                found.append(Finding(f"thrust along {'xyz'[axis]} is answered", False, "the odometry ended before"))
                continue
            begin, silence = self._marks[push], self._marks[push + 1]
            end = self._marks[push + 2] if len(self._marks) > push + 2 else len(self.samples)
            reaction = Reaction(
                axis, self._options.thrust, self.samples[:begin], self.samples[begin:silence], self.samples[silence:end]
            )
            found += check_reaction(reaction, self._options.mass, self._control)
        return found


def _counted(texts: list[str]) -> str:
    return f"{len(texts)}: {'; '.join(sorted(set(texts)))}" if texts else "0"


def run(options: argparse.Namespace) -> int:
    """Run the checks and print the table; gives 0 when all are passed, else 1."""
    control = load(ControlParameters)
    system = chosen_system(options)
    if options.mu > system.unit_count:
        raise InputError(f"--mu {options.mu}: {system.name} has {system.unit_count} units; or give --system NAME|FILE")
    unit = system.units[options.mu - 1]
    if options.mass is None:
        options.mass = unit.mass_kg
    if not 0.0 < abs(options.thrust) <= unit.thrust_limit_n:
        raise InputError(f"--thrust {options.thrust:g}: allowed: up to {unit.thrust_limit_n:g} N, not 0")
    rclpy.init(args=[])
    node = DriverCheck(options, control)
    runner = executor.make_executor()
    runner.add_node(node)
    try:
        while not node.done:
            runner.spin_once(timeout_sec=0.1)
    except (KeyboardInterrupt, ExternalShutdownException):
        print("stopped before the end; what was seen until then:", file=sys.stderr)
    findings = node.findings()
    runner.shutdown()
    executor.close_down(node)
    failed = sum(not finding.passed for finding in findings)
    print(table(findings))
    print(f"{len(findings) - failed} of {len(findings)} checks passed for the driver of MU {options.mu}")
    return 1 if failed else 0


def _add_arguments(parser: Parser) -> None:
    add, seconds = parser.add_argument, number(0.0, unit="s", above=True)
    add("--mu", type=whole_number(1), required=True, metavar="N", help="number of the MU")
    add_system(parser, required=False)
    add("--wait", type=seconds, default=10.0, metavar="S", help="[s] for the first odometry, default 10")
    add("--duration", type=seconds, default=5.0, metavar="S", help="[s] to watch before the MU is moved, default 5")
    add("--clock", choices=("own", "sim"), default="own", help="sim: give the driver /clock at 20 Hz")
    add("--thrust", type=number(-1e6, 1e6, "N"), default=1.0, metavar="N", help="[N] to push with, default 1")
    add("--push", type=seconds, default=1.0, metavar="S", help="[s] to push along each axis, default 1")
    add("--mass", type=number(0.0, unit="kg", above=True), metavar="KG", help="of the MU; default: as described")
    add("--no-thrust", action="store_true", help="only watch; nothing moves")


COMMAND = Subcommand(
    "Check a driver of an MU against the contract, alone, with no mission: this command stands in for the controller, "
    "with --clock sim for the simulator's clock too. It moves the MU: fasten it, or say --no-thrust.",
    ("--mu 3", "--mu 3 --system zenit_4mu --clock sim --no-thrust"), run, _add_arguments,
    exit_status="exit status: 0 all checks passed, 1 some failed, 2 bad usage",
)  # fmt: skip
