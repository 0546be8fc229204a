"""The assessor as a process: how well the debris is held, on /capture/assessment."""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_control.quiet_start import quiet_start

    quiet_start()

from collections import deque

import numpy as np
from nav_msgs.msg import Odometry
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from tethernet_control.layout import design
from tethernet_control.parameters import ParameterError
from tethernet_control.ros import executor, topics
from tethernet_control.ros.conversions import (
    MessageError,
    Vector,
    coordinates,
    finite,
    mission_from,
    nanoseconds,
    set_stamp,
)
from tethernet_control.ros.newest_odometry import NewestOdometry
from tethernet_control.ros.parameters import NODE_OPTIONS, declare
from tethernet_control.ros.qos import BULK, CONTROL, STATE, STATE_BACKLOG
from tethernet_control.ros.serialized_odometry import serialized_odometry_values
from tethernet_control.settings import ControlParameters, MissionParameters
from tethernet_control.step_guard import StampGuard
from tethernet_msgs.msg import CaptureAssessment, MissionState, NetState
from tethernet_sim.capture_quality import QualityParameters

from . import prediction
from .assessment import Assessment, CaptureAssessor
from .net_sample import NetSample
from .settings import AssessorParameters
from .swarm import DockedPairs, SwarmCentroid

_POLL_S = 0.25  # [s] wall time between two looks whether the verdict is overdue
_WAITING = 400
"""Net states that may wait for the debris' odometry of the same time."""


class AssessorNode(Node):
    """Carries messages to and from one :class:`CaptureAssessor`."""

    PARAMETERS = (AssessorParameters, ControlParameters, MissionParameters, QualityParameters)

    def __init__(self):
        super().__init__("assessor", **NODE_OPTIONS)
        parameters, control, rules, quality = declare(self, *self.PARAMETERS)
        self._mu_count = parameters.mu_count
        try:
            predictor = prediction.make(parameters.predictor, self._mu_count)
        except prediction.PredictorError as error:
            raise ParameterError(f"AssessorParameters.predictor: {error}") from error
        self._predictor_name = "" if predictor is None else parameters.predictor
        self._assessor = CaptureAssessor(self._mu_count, control, quality, parameters.progress_every, predictor)
        self._debris = NewestOdometry("debris odometry", control, self._drop, tuple(parameters.debris_position) or None)
        self._net_clock = StampGuard(control)
        self._waiting: deque[NetState] = deque(maxlen=_WAITING)
        self._track: deque[tuple[int, Vector, Vector]] = deque(maxlen=_WAITING)
        self._dropped = 0

        self._publisher = self.create_publisher(CaptureAssessment, topics.CAPTURE_ASSESSMENT, STATE)
        self.create_subscription(MissionState, topics.MISSION_STATE, self._on_mission, STATE)
        self.create_subscription(Odometry, topics.DEBRIS_ODOMETRY, self._on_debris, STATE_BACKLOG, raw=True)
        if parameters.simulated:
            self.create_subscription(NetState, topics.NET_STATE, self._on_net, BULK)
            import scipy.spatial  # noqa: F401  takes half a second: better now than in the middle of a flight
        else:
            self._swarm = SwarmCentroid(self._mu_count, control, self._drop)
            self._pairs = DockedPairs(self._mu_count, rules.docking_distance_m)
            for mu in range(1, self._mu_count + 1):
                self.create_subscription(
                    Odometry, topics.mu_odometry(mu), lambda data, mu=mu: self._on_mu(mu, data), CONTROL, raw=True
                )
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_POLL_S, lambda: self._publish(self._assessor.overdue()), clock=wall)

    def _on_mission(self, message: MissionState) -> None:
        try:
            mission = mission_from(message)
        except MessageError as error:
            self.get_logger().error(f"{error}; ignored")
            return
        if mission.mu_count != self._mu_count:
            self.get_logger().error(
                f"a mission of {mission.mu_count} MUs, and this assessor expects {self._mu_count}; ignored"
            )
            return
        self._publish(self._assessor.take_mission(mission))

    # Where something measures the net

    def _on_net(self, message: NetState) -> None:
        stamp_ns = nanoseconds(message.header.stamp)
        if not self._net_clock.take(stamp_ns).good:
            self._drop("net state", self._net_clock.why(stamp_ns))
            return
        self._waiting.append(message)
        self._assess_waiting()

    def _on_debris(self, data: bytes) -> None:
        debris = self._debris
        if debris.take(data):
            if debris.data is data:
                self._track.append((debris.stamp_ns, debris.position, debris.velocity))
            self._assess_waiting()

    def _assess_waiting(self) -> None:
        """Assess every net state for which it is known where the debris was."""
        while self._waiting and self._debris.position is not None:
            stamp_ns = nanoseconds(self._waiting[0].header.stamp)
            if 0 <= self._debris.stamp_ns < stamp_ns:
                return  # the debris' odometry of that time is still to come
            while len(self._track) > 1 and self._track[1][0] <= stamp_ns:
                self._track.popleft()
            debris = self._track[0][1:] if self._track else (self._debris.position, self._debris.velocity)
            try:
                sample = self._sample(self._waiting.popleft(), stamp_ns, *debris)
            except MessageError as error:
                self._drop("net state", str(error))
                continue
            self._publish(self._assessor.take_sample(sample))

    def _sample(self, message: NetState, stamp_ns: int, position: Vector, velocity: Vector) -> NetSample:
        arrays = [
            np.frombuffer(flat, np.float32)
            for flat in (message.knot_positions, message.knot_velocities, message.mu_positions, message.mu_velocities)
        ]
        knots = 3 * message.rows * message.columns
        expected = [knots, knots, 3 * self._mu_count, 3 * self._mu_count]
        if knots == 0 or [len(flat) for flat in arrays] != expected:
            raise MessageError(
                f"arrays of {[len(flat) for flat in arrays]} numbers; allowed: {expected} "
                f"for {message.rows} x {message.columns} knots and {self._mu_count} MUs"
            )
        center = coordinates(message.center_of_mass)
        center_all = coordinates(message.center_of_mass_all)
        if not finite(*center) or not all(np.isfinite(flat).all() for flat in arrays):
            raise MessageError("not finite")
        knot_positions, knot_velocities, mu_positions, mu_velocities = (flat.reshape(-1, 3) for flat in arrays)
        return NetSample(
            stamp_ns,
            center,
            position,
            sum(message.locked),
            mu_positions,
            knot_positions,
            knot_velocities,
            mu_velocities,
            velocity,
            center_all if finite(*center_all) else None,
        )

    # Where nothing but the MUs is measured

    def _on_mu(self, mu: int, data: bytes) -> None:
        try:
            stamp_ns, position, _ = serialized_odometry_values(data)
        except MessageError as error:
            self._drop(f"odometry of MU {mu}", str(error))
            return
        if not finite(*position):
            self._drop(f"odometry of MU {mu}", "not finite")
            return
        tick = self._swarm.update(mu, stamp_ns, position)
        if tick is None or self._debris.position is None:
            return
        mission = self._assessor.mission
        if mission.closing and tick.stamp_ns >= mission.closing_ns:
            self._pairs.update(self._swarm.positions)
        positions = np.array([self._swarm.positions[mu] for mu in range(1, self._mu_count + 1)], np.float32)
        sample = NetSample(tick.stamp_ns, tick.position, self._debris.position, len(self._pairs.docked), positions)
        self._publish(self._assessor.take_sample(sample))

    def _drop(self, what: str, why: str) -> None:
        self._dropped += 1
        self.get_logger().warning(f"{what} dropped: {why} ({self._dropped} dropped so far)", throttle_duration_sec=1.0)

    def _publish(self, assessments: list[Assessment]) -> None:
        for assessment in assessments:
            self._publisher.publish(self._message(assessment))
            if assessment.prediction_failure:
                self.get_logger().warning(f"no prediction: {assessment.prediction_failure}")
            if assessment.verdict:
                self.get_logger().info(assessment.verdict)

    def _message(self, a: Assessment) -> CaptureAssessment:
        layout = design(self._mu_count)
        message = CaptureAssessment(
            stage=int(a.stage),
            cqi=a.cqi,
            cqi_all=a.cqi_all,
            hull_volume=a.hull_volume,
            hull_area=a.hull_area,
            mouth_area=a.mouth_area,
            net_debris_distance=a.net_debris_distance,
            locked_pairs=a.locked_pairs,
            max_locked_pairs=layout.max_locked_pairs,
            required_locked_pairs=layout.required_locked_pairs,
            source=a.source,
            captured=a.captured,
            verdict=a.verdict,
            cqi_error=a.cqi_error,
            locked_pairs_error=a.locked_pairs_error,
        )
        set_stamp(message.header.stamp, a.stamp_ns)
        message.header.frame_id = topics.FRAME
        if a.prediction is not None:
            message.prediction_valid = True
            message.predicted_cqi = float(a.prediction.cqi)
            message.predicted_locked_pairs = float(a.prediction.locked_pairs)
            message.predicted_capture_probability = float(a.prediction.capture_probability)
            message.predictor = self._predictor_name
        return message


def main(args: list[str] | None = None) -> int:
    """Run the node; see :func:`tethernet_control.ros.executor.run` for the exit status."""
    return executor.run(AssessorNode, args)


if __name__ == "__main__":
    raise SystemExit(main())
