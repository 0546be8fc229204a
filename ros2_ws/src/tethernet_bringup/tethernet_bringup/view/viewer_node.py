"""The viewer: shows a mission while it is flown. Nothing depends on it.

::

    python -m tethernet_bringup.view.viewer_node --ros-args -p output:=mission.rrd -p system:=zenit_8mu

What moves it hears best effort, so that nobody sends it anything again, and looks at what is newest some times a
second, as the recorder does. It draws in a thread of its own: Rerun makes whoever sends it pictures
wait for a window that is slow, for ever for one that stands still. Meanwhile pictures are left out
(:class:`tethernet_bringup.view.snapshot.Newest`), and the node goes on to take signals.

It ends with SIGINT or SIGTERM, when the last picture is drawn. Exit status: 0 stopped, 1 a fault (what is shown cannot
be written or sent), 2 bad parameters.
"""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import quiet_start

    quiet_start()

import importlib
import os
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile

from tethernet_bringup.nodes import VIEWER
from tethernet_bringup.view.drawing import Drawing
from tethernet_bringup.view.observer import CHASER, DEBRIS, Observer
from tethernet_bringup.view.recording import close, leave_now, open_recording
from tethernet_bringup.view.settings import ViewerParameters
from tethernet_bringup.view.snapshot import Newest
from tethernet_core.errors import FaultError
from tethernet_core.parameters import ParameterError
from tethernet_core.system import load_system
from tethernet_ros import checks, qos, stop_request, topics
from tethernet_ros.checks import Check, NetMeasurement
from tethernet_ros.door import Door
from tethernet_ros.executor import FAULT, STOPPED, USAGE, bound_the_end, close_down, enter
from tethernet_ros.parameters import NODE_OPTIONS, declare
from tethernet_ros.polled import Polled
from tethernet_ros.serialized import OdometrySample

_NICE = 10
"""The controllers' processes go first where there are not enough cores for all."""
_END_S = 3.0
"""[s] wall time for the last pictures, once asked to end; a second signal ends it at once."""
_LAST_WORDS_S = 0.1
"""[s] wall time for what was said last, and for what has piled up where this process stood still."""
_TOLD_AGAIN_S = 3.5
"""[s] wall time within which a reliable writer of Fast DDS has told again what a reader lacks (heartbeats of 3 s)."""
_POLL_S = 0.05
_ANSWER_S = 0.5
"""[s] wall time between two looks at whether anybody asks for the parameters."""
_BEFORE_LAUNCH_S = 1.0
"""[s] wall time between two pictures before the launch, which all have time 0."""


class Viewer(Node):
    """Looks at a mission and hands snapshots of it to the thread that draws them.

    Raises:
        ParameterError: a parameter is unknown, of the wrong type, out of range, or names what does not exist.
        FaultError: when what is to be written cannot be.
    """

    def __init__(self) -> None:
        super().__init__(VIEWER, **NODE_OPTIONS)
        self.settings: ViewerParameters = declare(self, ViewerParameters)
        if not self.settings.output:
            raise ParameterError("output is empty; allowed: the address of a Rerun server, or the path of an .rrd file")
        system = load_system(self.settings.system)
        self.fault = ""
        """Why nothing is drawn any more."""
        self._observer = Observer(system)
        self._newest = Newest()
        self._shown_ns, self._next_s = 0, 0.0
        self._looks: list[Callable[[], None]] = []
        self._door = Door(self)
        self._look_at_all()
        os.nice(_NICE)  # this thread and those that it starts: not the middleware's, which take what comes
        self._recording = open_recording(self.settings.output, system.name)
        self._drawing = Drawing(self._recording, system)
        self._thread = threading.Thread(target=self._draw, name="drawing", daemon=True)
        self._thread.start()
        self.get_logger().info(f"showing {system.name} in {self.settings.output}")

    @property
    def stuck(self) -> bool:
        """Whether the thread that draws still waits for Rerun."""
        return self._thread.is_alive()

    def look(self) -> None:
        """Take what is newest; hand over a snapshot where anything has changed."""
        for look in self._looks:
            look()
        observer, now = self._observer, time.monotonic()
        moved = observer.newest_ns != self._shown_ns
        if observer.news or (moved and (observer.launched or now >= self._next_s)):
            self._shown_ns, self._next_s = observer.newest_ns, now + _BEFORE_LAUNCH_S
            self._newest.put(observer.snapshot())

    def finish(self, hurried: Callable[[], bool]) -> None:
        """Show what has come last, and end the recording.

        Args:
            hurried: whether there is no time for that any more.
        """
        # Whoever has told it is still there and tells it again where it was lost on the way.
        began = time.monotonic()
        while time.monotonic() < began + _LAST_WORDS_S or not (self._observer.ended or hurried()):
            time.sleep(_POLL_S)
            self.look()
            if time.monotonic() > began + _TOLD_AGAIN_S:
                break
        self._newest.close()
        until = time.monotonic() + _END_S
        while self.stuck and time.monotonic() < until and not hurried():
            self._thread.join(_POLL_S)
        if self.stuck:
            self.fault = self.fault or f"{self.settings.output} takes no more pictures"
        self.get_logger().info(f"shown until the end; {self._newest.dropped} pictures were left out")

    def _look_at_all(self) -> None:
        observer, system = self._observer, self._observer.system

        def net(seen: NetMeasurement) -> None:
            observer.net(seen.stamp_ns, seen.center, seen.knot_positions, seen.mu_positions, seen.locked)

        # Phases and verdicts are said once: their writers keep the newest for whoever lacks one, and wait for nobody.
        state, said = checks.mission_state(system), qos.STATE_BACKLOG
        self._look_at(state, topics.MISSION_STATE, lambda news: observer.state(news.message), said)
        self._look_at(checks.assessment(system), topics.CAPTURE_ASSESSMENT, observer.assessment, said)
        for body, topic in ((DEBRIS, topics.DEBRIS_ODOMETRY), (CHASER, topics.CHASER_ODOMETRY)):
            self._look_at(checks.odometry(), topic, self._body_taker(body))
        for mu in range(1, system.unit_count + 1):
            self._look_at_unit(mu)
        # The net last: what else is shown at its time is then no newer, and at most a tick older.
        self._look_at(checks.net_state(system), topics.NET_STATE, net)

    def _look_at_unit(self, mu: int) -> None:
        observer = self._observer

        def odometry(sample: OdometrySample) -> None:
            observer.unit(mu, sample.stamp_ns, sample.position)

        self._look_at(checks.odometry(mu), topics.mu_odometry(mu), odometry)
        self._look_at(checks.THRUST, topics.mu_thrust(mu), lambda command: observer.thrust(mu, command.force))
        self._look_at(checks.mu_status(mu), topics.mu_status(mu), lambda status: observer.status(mu, status))

    def _body_taker(self, body: str) -> Callable[[OdometrySample], None]:
        return lambda sample: self._observer.body(body, sample.stamp_ns, sample.position, sample.attitude)

    def _look_at(
        self, check: Check[Any], topic: str, take: Callable[[Any], None], quality: QoSProfile = qos.NEWEST
    ) -> None:
        polled = Polled(self, self._door, check, topic, quality)

        def look() -> None:
            for value in polled.take():
                take(value)

        self._looks.append(look)

    def _draw(self) -> None:
        try:
            while (snapshot := self._newest.take()) is not None:
                self._drawing.draw(snapshot)
            close(self._recording, self.settings.output)
        except Exception as error:  # whatever it is: the node ends by it, and says so
            self.fault = str(error) if isinstance(error, FaultError) else f"{type(error).__name__}: {error}"


def main(args: list[str] | None = None) -> int:
    """Run the node; returns the exit status."""
    if not enter(VIEWER, sys.argv if args is None else args, lambda: importlib.import_module("rerun")):
        return USAGE
    status = _run()
    if status is None:
        leave_now(FAULT)
    bound_the_end()
    close_down(None)
    return status


def _run() -> int | None:
    """Look on until this process is asked to stop; the exit status, None where Rerun holds a thread of this process."""
    try:
        viewer = Viewer()
    except ExternalShutdownException:
        return STOPPED
    except (ParameterError, FaultError) as error:
        print(f"{VIEWER}: {error}", file=sys.stderr, flush=True)
        return USAGE if isinstance(error, ParameterError) else FAULT
    # The only executor that respects callback groups; it has nothing to do but parameters.
    answers = SingleThreadedExecutor()
    answers.add_node(viewer)
    period, next_answer = 1.0 / viewer.settings.rate_hz, 0.0
    while not stop_request.requests() and not viewer.fault:
        began = time.monotonic()
        viewer.look()
        if began >= next_answer:
            answers.spin_once(timeout_sec=0.0)
            next_answer = began + _ANSWER_S
        time.sleep(max(0.0, began + period - time.monotonic()))
    viewer.finish(lambda: stop_request.requests() > 1)
    if viewer.fault:
        print(f"{VIEWER}: {viewer.fault}", file=sys.stderr, flush=True)
    if viewer.stuck:
        return None
    viewer.destroy_node()
    return FAULT if viewer.fault else STOPPED


if __name__ == "__main__":
    sys.exit(main())
