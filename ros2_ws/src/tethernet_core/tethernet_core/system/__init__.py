"""Descriptions of systems: net, units, closing, launch, debris, chaser, read from data and checked before they fly."""

from .errors import DescriptionError
from .loading import PARAMETER_SECTIONS, check_system, keep_system, load_system, shipped_systems, system_from_text
from .parts import Aiming, Capture, Chaser, Closing, Debris, Grid, Launch, Net, PointMass, Tether, Thread, Unit
from .sections import MOST_UNITS
from .system import System

__all__ = [
    "MOST_UNITS", "PARAMETER_SECTIONS", "Aiming", "Capture", "Chaser", "Closing", "Debris", "DescriptionError", "Grid",
    "Launch", "Net", "PointMass", "System", "Tether", "Thread", "Unit", "check_system", "keep_system", "load_system",
    "shipped_systems", "system_from_text",
]  # fmt: skip
