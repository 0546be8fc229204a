"""Names of frames, topics and services: the only place where they are written down."""

FRAME = "launch"
"""Inertial frame: origin at the net's launch point on the chaser, debris towards -z."""

CLOCK = "/clock"
MISSION_STATE = "/mission/state"
PLANNER_HEARTBEAT = "/planner/heartbeat"
PLAN_AIMING_POINTS = "/planner/plan_aiming_points"
START = "/planner/start"
ABORT = "/planner/abort"
DEBRIS_ODOMETRY = "/debris/odom"
CHASER_ODOMETRY = "/chaser/odom"
NET_STATE = "/net/state"
NET_MARKERS = "/net/markers"
NET_POINTS = "/net/points"
TF = "/tf"
DIAGNOSTICS = "/diagnostics"
SIM_STATUS = "/sim/status"
CAPTURE_ASSESSMENT = "/capture/assessment"


def mu_frame(mu: int) -> str:
    """Child frame of unit ``mu``, from 1."""
    return f"mu{mu}"


def mu_odometry(mu: int) -> str:
    """Topic of the unit's measured position and velocity (nav_msgs/Odometry)."""
    return f"/mu{mu}/odom"


def mu_thrust(mu: int) -> str:
    """Topic of the unit's thrust command (geometry_msgs/WrenchStamped)."""
    return f"/mu{mu}/thrust"


def mu_status(mu: int) -> str:
    """Topic of the controller's account of itself (tethernet_msgs/MuStatus)."""
    return f"/mu{mu}/status"
