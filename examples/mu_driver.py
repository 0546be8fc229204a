"""Example driver of a real Maneuverable Unit: stands where your hardware will stand.

It keeps the driver contract (ros2_ws/src/tethernet_control/README.md) and knows nothing else of this project:
/muN/odom out, /muN/thrust in. Replace :class:`DoubleIntegrator` by your MU's thrusters and navigation, keep the rest.

Fly MU 3 of a simulated mission (two terminals, same ROS_DOMAIN_ID)::

    python examples/mu_driver.py --mu 3 --clock sim
    python run_mission.py --external-mu 3

Without ``--clock sim`` the driver steps on its own clock at 20 Hz, as a real MU does.
"""

from __future__ import annotations

import argparse
import math
import os
import random
import signal
import sys
import threading
import time

import rclpy
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.utilities import remove_ros_args
from rosgraph_msgs.msg import Clock

PERIOD_NS = 50_000_000  # [ns] 20 Hz
WATCHDOG_PERIODS = 5
THRUST_LIMIT_N = 5.1  # [N] per axis: what the thrusters can give
FRAME = "launch"

_SECOND_NS = 1_000_000_000
_THRUST_PATIENCE_S = 0.04  # [s] on the simulator's clock: how long a step waits for the answer to the last odometry
_QOS = QoSProfile(
    history=QoSHistoryPolicy.KEEP_LAST,
    depth=10,
    reliability=QoSReliabilityPolicy.RELIABLE,
    durability=QoSDurabilityPolicy.VOLATILE,
)

# Where the folded net holds the MUs before launch: at 5 % of the flat net's size, 1.5 m in front of the chaser.
_FOLDED_M, _DISTANCE_M = 0.55, 1.5
_SIDES = {1: (-1, -1), 2: (1, -1), 3: (-1, 1), 4: (1, 1), 5: (0, -1), 6: (1, 0), 7: (-1, 0), 8: (0, 1)}


class DoubleIntegrator:
    """The stand-in for hardware: a mass that thrust accelerates, and a sensor with noise."""

    def __init__(self, position: list[float], mass_kg: float, sigma: float, seed: int):
        """Args:
        position: at the start [m].
        mass_kg: of the MU [kg].
        sigma: standard deviation of the measured position [m] and velocity [m/s], per axis.
        seed: of the noise.
        """
        self._position, self._velocity = list(position), [0.0, 0.0, 0.0]
        self._mass_kg, self._sigma = mass_kg, sigma
        self._random = random.Random(seed)

    def move(self, thrust: tuple[float, float, float], duration_s: float) -> None:
        """Fly with a constant thrust [N]."""
        for axis, force in enumerate(thrust):
            acceleration = force / self._mass_kg
            self._position[axis] += (self._velocity[axis] + 0.5 * acceleration * duration_s) * duration_s
            self._velocity[axis] += acceleration * duration_s

    def measure(self) -> tuple[list[float], list[float]]:
        """Position [m] and velocity [m/s] as the sensors tell them."""
        noise = self._random.gauss
        return (
            [value + noise(0.0, self._sigma) for value in self._position],
            [value + noise(0.0, self._sigma) for value in self._velocity],
        )


class MuDriver(Node):
    """Publishes odometry, obeys thrust."""

    def __init__(self, mu: int, hardware: DoubleIntegrator, sigma: float, on_simulated_clock: bool):
        super().__init__(f"mu{mu}_driver")
        self._hardware = hardware
        self._time_ns: int | None = None
        self._wanted_ns: int | None = None
        self._thrust = (0.0, 0.0, 0.0)
        self._thrust_ns = -WATCHDOG_PERIODS * PERIOD_NS
        self._odometry = _odometry_with_variances(mu, sigma)
        self._publisher = self.create_publisher(Odometry, f"/mu{mu}/odom", _QOS)
        self.create_subscription(WrenchStamped, f"/mu{mu}/thrust", self._on_thrust, _QOS)
        wall = RosClock(clock_type=ClockType.STEADY_TIME)
        if on_simulated_clock:
            self.create_subscription(Clock, "/clock", self._on_clock, _QOS)
            self._patience = self.create_timer(_THRUST_PATIENCE_S, self._step_anyway, clock=wall)
            self._patience.cancel()
        else:
            self._begin_ns = time.time_ns()
            self._begin_s = time.monotonic()
            self._steps = 0
            self.create_timer(PERIOD_NS / _SECOND_NS, self._on_own_clock, clock=wall)

    def _on_thrust(self, message: WrenchStamped) -> None:
        force, stamp = message.wrench.force, message.header.stamp
        thrust = (force.x, force.y, force.z)
        stamp_ns = stamp.sec * _SECOND_NS + stamp.nanosec
        if not all(map(math.isfinite, thrust)):
            self.get_logger().warning("thrust is not finite: dropped", throttle_duration_sec=1.0)
            return
        if stamp_ns < self._thrust_ns:
            return  # older than what is being done
        self._thrust_ns = stamp_ns
        x, y, z = (max(-THRUST_LIMIT_N, min(THRUST_LIMIT_N, value)) for value in thrust)
        self._thrust = (x, y, z)
        if self._wanted_ns is not None and self._answered:
            self._step_to(self._wanted_ns)

    @property
    def _answered(self) -> bool:
        """The newest thrust answers the newest odometry."""
        return self._time_ns is None or self._thrust_ns >= self._time_ns

    def _on_clock(self, message: Clock) -> None:
        """The simulator has come to a new control tick: follow it, with the thrust that answers the last one."""
        now_ns = message.clock.sec * _SECOND_NS + message.clock.nanosec
        if self._time_ns is not None and now_ns <= self._time_ns:
            return
        if self._wanted_ns is not None:
            self._step_to(self._wanted_ns)  # the simulator did not wait either
        self._wanted_ns = now_ns
        if self._answered:
            self._step_to(now_ns)
        else:
            self._patience.reset()

    def _step_anyway(self) -> None:
        if self._wanted_ns is not None:
            self._step_to(self._wanted_ns)

    def _on_own_clock(self) -> None:
        """Make all steps that are due; stamps stay on the grid whatever the timer's jitter."""
        elapsed_ns = int((time.monotonic() - self._begin_s) * _SECOND_NS)
        while self._steps * PERIOD_NS <= elapsed_ns:
            self._step_to(self._begin_ns + self._steps * PERIOD_NS)
            self._steps += 1

    def _step_to(self, now_ns: int) -> None:
        """Fly to this time and tell where that led."""
        self._wanted_ns = None
        if self._time_ns is not None:
            fresh = now_ns - self._thrust_ns <= WATCHDOG_PERIODS * PERIOD_NS
            self._hardware.move(self._thrust if fresh else (0.0, 0.0, 0.0), (now_ns - self._time_ns) / _SECOND_NS)
        self._time_ns = now_ns
        position, velocity = self._hardware.measure()
        message = self._odometry
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(now_ns, _SECOND_NS)
        place, speed = message.pose.pose.position, message.twist.twist.linear
        place.x, place.y, place.z = position
        speed.x, speed.y, speed.z = velocity
        self._publisher.publish(message)


def _odometry_with_variances(mu: int, sigma: float) -> Odometry:
    """Everything in the message that stays the same: frames, attitude, covariances."""
    message = Odometry()
    message.header.frame_id, message.child_frame_id = FRAME, f"mu{mu}"
    message.pose.pose.orientation.w = 1.0
    for axis in range(6):
        # Position and velocity as they are; attitude and angular rate are not measured, and ROS says so with a large
        # variance.
        variance = sigma * sigma if axis < 3 else 1e6
        message.pose.covariance[7 * axis] = message.twist.covariance[7 * axis] = variance
    return message


def _arguments(args: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Example driver of an MU: /muN/odom out, /muN/thrust in.")
    parser.add_argument("--mu", type=int, required=True, choices=range(1, 9), help="number of the MU")
    clock_help = "own: 20 Hz on this machine's clock; sim: one step per /clock message"
    parser.add_argument("--clock", choices=("own", "sim"), default="own", help=clock_help)
    parser.add_argument("--start", type=float, nargs=3, metavar=("X", "Y", "Z"), help="[m] default: in the folded net")
    parser.add_argument("--mass", type=float, default=2.5, help="[kg] default 2.5")
    parser.add_argument("--sigma", type=float, default=0.1 / 3.0, help="[m, m/s] of the sensor noise, default 0.0333")
    parser.add_argument("--seed", type=int, default=0, help="of the sensor noise")
    options = parser.parse_args(args)
    if not options.mass > 0.0 or not options.sigma >= 0.0:
        parser.error(f"mass {options.mass} and sigma {options.sigma}: the mass must be above 0, sigma at least 0")
    if options.start is None:
        x, y = _SIDES[options.mu]
        options.start = [x * _FOLDED_M, y * _FOLDED_M, -_DISTANCE_M]
    return options


_started = threading.Event()
"""rclpy listens to the signals."""


def _leave_before_start(_number: int, _frame: object) -> None:
    if not _started.is_set():
        os._exit(0)  # nothing to clean up yet


def main() -> int:
    """Run the driver until SIGINT or SIGTERM."""
    options = _arguments(remove_ros_args(sys.argv)[1:])
    # rclpy shuts down on both signals by itself; any exception that Python raises for them would come in the middle of
    # its work, or of the clean-up below.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _leave_before_start)
    rclpy.init(args=sys.argv)
    _started.set()
    hardware = DoubleIntegrator(options.start, options.mass, options.sigma, 100 * options.seed + options.mu)
    node = None
    try:
        node = MuDriver(options.mu, hardware, options.sigma, options.clock == "sim")
        rclpy.spin(node)
    except ExternalShutdownException:
        pass
    except Exception:
        if rclpy.ok():
            raise  # a fault; otherwise a publisher that the shutdown took away
    finally:
        # All is done; should the middleware hang when this process leaves the graph, SIGALRM ends it.
        signal.setitimer(signal.ITIMER_REAL, 5.0)
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
