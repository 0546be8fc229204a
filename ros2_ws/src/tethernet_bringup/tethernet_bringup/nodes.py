"""The nodes of a mission: names, modules, and the parameters each one takes."""

from __future__ import annotations

SIM = "sim"
PLANNER = "planner"
ASSESSOR = "assessor"
RECORDER = "recorder"
VIEWER = "viewer"
MONITOR = "run_mission"


def controller(mu: int) -> str:
    """Name of the node that controls unit ``mu``, from 1."""
    return f"mu{mu}_controller"


def mu_of(node: str) -> int | None:
    """The unit that a node controls, None for any other node."""
    name = node.removesuffix("_controller")
    return int(name[2:]) if name != node and name[2:].isdigit() else None
