"""Messages that tell of the world. Each object serializes its message once and writes over it at every control tick."""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from tethernet_core.settings import ControlParameters
from tethernet_core.system import System
from tethernet_ros import topics
from tethernet_ros.net_state import blank_net_state
from tethernet_ros.template import Template
from tethernet_sim.loads import Loads
from tethernet_sim.state import ATTITUDE, CHASER, DEBRIS, POSITION
from tethernet_sim.world import World

UNKNOWN_VARIANCE = 1e6
"""Variance of what is not measured: a unit's attitude [rad^2] and angular rate [rad^2/s^2]."""


class UnitOdometry:
    """A unit's measured position and velocity."""

    def __init__(self, mu: int, control: ControlParameters):
        """Args:
        mu: number of the unit.
        control: says how exactly they are measured.
        """
        message = Odometry()
        message.header.frame_id = topics.FRAME
        message.child_frame_id = topics.mu_frame(mu)
        message.pose.covariance[:] = _diagonal(control.position_sigma_m**2, UNKNOWN_VARIANCE)
        message.twist.covariance[:] = _diagonal(control.velocity_sigma_m_s**2, UNKNOWN_VARIANCE)
        self._template = Template(message)
        self._position = self._template.doubles("pose.pose.position.x", 3)
        self._velocity = self._template.doubles("twist.twist.linear.x", 3)

    def fill(self, stamp_ns: int, position: np.ndarray, velocity: np.ndarray) -> Template:
        """The message for a measured position [m] and velocity [m/s]; the child's axes are those of frame launch."""
        self._template.stamp(stamp_ns)
        self._position[:] = position
        self._velocity[:] = velocity
        return self._template


class BodyOdometry:
    """True motion of debris or chaser."""

    def __init__(self, body: int, frame: str):
        """Args:
        body: DEBRIS or CHASER.
        frame: its child frame.
        """
        self._body = body
        message = Odometry()
        message.header.frame_id = topics.FRAME
        message.child_frame_id = frame
        self._template = Template(message)
        self._pose = self._template.doubles("pose.pose.position.x", 7)
        self._twist = self._template.doubles("twist.twist.linear.x", 6)

    def fill(self, stamp_ns: int, world: World) -> Template:
        """The message for the body's present motion; the twist is in its own frame, as nav_msgs defines it."""
        position, attitude, linear, angular = world.body_motion(0, self._body)
        self._template.stamp(stamp_ns)
        self._pose[:] = [*position, *attitude]
        self._twist[:] = [*linear, *angular]
        return self._template


class NetStateMessage:
    """The whole net."""

    def __init__(self, system: System):
        """Args:
        system: whose net it is.
        """
        message = blank_net_state(system)
        message.center_of_mass_all_valid = message.contact_force_valid = True
        template = self._template = Template(message)
        self._center = template.doubles("center_of_mass.x", 3)
        self._center_all = template.doubles("center_of_mass_all.x", 3)
        self._knots, self._knot_velocities, self._mus, self._mu_velocities = (
            template.floats(f"{name}[0]", len(getattr(message, name))).reshape(-1, 3)
            for name in ("knot_positions", "knot_velocities", "mu_positions", "mu_velocities")
        )
        self._locked = template.flags("locked[0]", len(message.locked))
        self._tether = template.doubles("tether_length", 2)
        self._share_known, self._shares = template.flags("load_share_valid", 1), template.doubles("load_share", 2)
        self._contact = template.doubles("contact_force", 2)

    def fill(self, stamp_ns: int, world: World, loads: Loads) -> Template:
        """The message for the net's present state and its loads."""
        self._template.stamp(stamp_ns)
        self._center[:] = world.net_center(0)
        self._center_all[:] = world.net_center_all(0)
        self._knots[:] = world.knots_as_published(0)
        self._knot_velocities[:] = world.knot_velocities_as_published(0)
        self._mus[:] = world.mus_as_published(0)
        self._mu_velocities[:] = world.mu_velocities_as_published(0)
        self._locked[:] = world.state.locked[0]
        self._tether[:] = world.tether(0)
        self._contact[:] = loads.contact_now_n(0), loads.contact_n(0)
        share, largest = loads.share_now(0), loads.share(0)
        self._share_known[:] = known = not math.isnan(largest)
        self._shares[:] = (share, largest) if known else 0.0  # no message carries NaN
        return self._template


class Transforms:
    """/tf: where units, net centre, debris and chaser are."""

    def __init__(self, mu_count: int):
        """Args:
        mu_count: number of units.
        """
        frames = [topics.mu_frame(mu) for mu in range(1, mu_count + 1)] + ["net", "debris", "chaser"]
        message = TFMessage(transforms=[TransformStamped(child_frame_id=frame) for frame in frames])
        for transform in message.transforms:
            transform.header.frame_id = topics.FRAME
        template = self._template = Template(message)
        self._places = [template.doubles(f"transforms[{i}].transform.translation.x", 3) for i in range(len(frames))]
        self._turns = [template.doubles(f"transforms[{len(frames) - 2 + i}].transform.rotation.x", 4) for i in range(2)]

    def fill(self, stamp_ns: int, world: World) -> Template:
        """The message for the present state."""
        bodies = world.state.bodies[0]
        self._template.stamp(stamp_ns)
        places = (*world.state.mu_pos[0], world.net_center(0), bodies[DEBRIS, POSITION], bodies[CHASER, POSITION])
        for view, place in zip(self._places, places, strict=True):
            view[:] = place
        for view, body in zip(self._turns, (DEBRIS, CHASER), strict=True):
            view[:] = bodies[body, ATTITUDE]
        return self._template


class ClockMessage:
    """/clock."""

    def __init__(self) -> None:
        self._template = Template(Clock())

    def fill(self, stamp_ns: int) -> Template:
        """The message for a time [ns]."""
        self._template.stamp(stamp_ns)
        return self._template


def _diagonal(linear: float, angular: float) -> np.ndarray:
    return np.diag([linear] * 3 + [angular] * 3).ravel()
