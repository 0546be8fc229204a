"""The assessor as a process: how well the debris is held, on /capture/assessment."""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import quiet_start

    quiet_start()

import functools
from collections import deque

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from tethernet_core import unknown
from tethernet_core.parameters import ParameterError
from tethernet_core.rotation import Quaternion
from tethernet_core.settings import ControlParameters
from tethernet_core.shown import shown
from tethernet_core.step_guard import StampGuard
from tethernet_core.system import load_system
from tethernet_msgs.msg import CaptureAssessment
from tethernet_planner import predictors as prediction
from tethernet_planner.assessment import Assessment, CaptureAssessor
from tethernet_planner.inference.net_sample import NetSample
from tethernet_planner.settings import AssessorParameters, given_debris
from tethernet_planner.swarm import DockedPairs, SwarmCentroid
from tethernet_ros import checks, executor, topics
from tethernet_ros.checks import MissionNews, NetMeasurement
from tethernet_ros.conversions import Vector, set_stamp
from tethernet_ros.door import Door
from tethernet_ros.newest_odometry import NewestOdometry
from tethernet_ros.parameters import NODE_OPTIONS, declare
from tethernet_ros.qos import BULK, CONTROL, STATE, STATE_BACKLOG
from tethernet_ros.serialized import OdometrySample
from tethernet_ros.well_formed import MessageError

_POLL_S = 0.25  # [s] wall time between two looks whether the verdict is overdue
_WAITING = 400
"""Net states that may wait for the debris' odometry of the same time."""


class AssessorNode(Node):
    """Carries messages to and from one :class:`CaptureAssessor`."""

    PARAMETERS = (AssessorParameters, ControlParameters)

    def __init__(self) -> None:
        super().__init__("assessor", **NODE_OPTIONS)
        parameters, control = declare(self, *self.PARAMETERS)
        self._system = system = load_system(parameters.system)
        self._mu_count = system.unit_count
        try:
            predictor = prediction.make(parameters.predictor, system)
        except prediction.PredictorError as error:
            raise ParameterError(f"AssessorParameters.predictor: {error}") from error
        self._predictor_name = "" if predictor is None else parameters.predictor
        self._assessor = CaptureAssessor(system, control, parameters.progress_every, predictor)
        self._debris = NewestOdometry(control, given_debris(parameters.debris_position))
        self._net_clock = StampGuard(control)
        self._waiting: deque[NetMeasurement] = deque(maxlen=_WAITING)
        self._track: deque[tuple[int, Vector, Vector, Quaternion | None]] = deque(maxlen=_WAITING)

        self._door = door = Door(self)
        self._publisher = door.publish(CaptureAssessment, topics.CAPTURE_ASSESSMENT, STATE_BACKLOG)
        door.subscribe(checks.mission_state(system), topics.MISSION_STATE, self._on_mission, STATE)
        door.subscribe(checks.odometry(), topics.DEBRIS_ODOMETRY, self._on_debris, STATE_BACKLOG)
        if parameters.simulated:
            door.subscribe(checks.net_state(system), topics.NET_STATE, self._on_net, BULK)
        else:
            self._swarm = SwarmCentroid(self._mu_count, control, door.drop)
            self._pairs = DockedPairs(system)
            for mu in range(1, self._mu_count + 1):
                door.subscribe(checks.odometry(mu), topics.mu_odometry(mu), functools.partial(self._on_mu, mu), CONTROL)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_POLL_S, lambda: self._publish(self._assessor.overdue()), clock=wall)

    def _on_mission(self, news: MissionNews) -> None:
        self._publish(self._assessor.take_mission(news.mission))

    # Where something measures the net

    def _on_net(self, net: NetMeasurement) -> None:
        if not self._net_clock.take(net.stamp_ns).good:
            raise MessageError(self._net_clock.why(net.stamp_ns))
        self._waiting.append(net)
        self._assess_waiting()

    def _on_debris(self, sample: OdometrySample) -> None:
        if self._debris.take(sample):
            self._track.append((sample.stamp_ns, sample.position, sample.velocity, sample.attitude))
            self._assess_waiting()

    def _assess_waiting(self) -> None:
        """Assess every net state for which it is known where the debris was."""
        while self._waiting and self._debris.position is not None:
            stamp_ns = self._waiting[0].stamp_ns
            if 0 <= self._debris.stamp_ns < stamp_ns:
                return  # the debris' odometry of that time is still to come
            while len(self._track) > 1 and self._track[1][0] <= stamp_ns:
                self._track.popleft()
            debris = self._track[0][1:] if self._track else (self._debris.position, self._debris.velocity, None)
            self._publish(self._assessor.take_sample(self._sample(self._waiting.popleft(), *debris)))

    def _sample(
        self, net: NetMeasurement, position: Vector, velocity: Vector, attitude: Quaternion | None
    ) -> NetSample:
        return NetSample(
            net.stamp_ns,
            net.center,
            position,
            sum(net.locked),
            net.mu_positions,
            net.knot_positions,
            net.knot_velocities,
            net.mu_velocities,
            velocity,
            net.center_all,
            attitude,
            tuple(net.locked),
            net.max_load_share,
            net.max_contact_force,
        )

    # Where nothing but the MUs is measured

    def _on_mu(self, mu: int, sample: OdometrySample) -> None:
        tick = self._swarm.update(mu, sample.stamp_ns, sample.position)
        if tick is None or self._debris.position is None:
            return
        mission = self._assessor.mission
        if mission.closing and tick.stamp_ns >= mission.closing_ns:
            self._pairs.update(self._swarm.positions)
        positions = np.array([self._swarm.positions[mu] for mu in range(1, self._mu_count + 1)], np.float32)
        self._publish(
            self._assessor.take_sample(
                NetSample(tick.stamp_ns, tick.position, self._debris.position, len(self._pairs.docked), positions)
            )
        )

    def _publish(self, assessments: list[Assessment]) -> None:
        for assessment in assessments:
            self._publisher.publish(self._message(assessment))
            if assessment.prediction_failure:
                self.get_logger().warning(f"no prediction: {shown(assessment.prediction_failure)}")
            for text in filter(None, (assessment.verdict, assessment.hold_verdict)):
                self.get_logger().info(text)

    def _message(self, a: Assessment) -> CaptureAssessment:
        message = CaptureAssessment(
            stage=int(a.stage),
            locked_pairs=a.locked_pairs,
            max_locked_pairs=self._system.closing.max_locked_pairs,
            required_locked_pairs=self._system.capture.required_locked_pairs,
            source=a.source,
            captured=a.captured,
            verdict=shown(a.verdict),
            enclosed_valid=a.enclosed is not None,
            enclosed=a.enclosed is True,
            held_valid=a.held is not None,
            held=a.held is True,
            hold_verdict=shown(a.hold_verdict),
        )
        set_stamp(message.header.stamp, a.stamp_ns)
        message.header.frame_id = topics.FRAME
        if a.prediction is not None:
            message.predictor = shown(self._predictor_name)
        unknown.fill(message, a.numbers)
        return message


def main(args: list[str] | None = None) -> int:
    """Run the node; see :func:`tethernet_ros.executor.run` for the exit status."""
    import scipy.spatial  # noqa: F401  takes half a second: better now than in the middle of a flight

    return executor.run(AssessorNode, args)


if __name__ == "__main__":
    raise SystemExit(main())
