"""Packages that not every environment has, and how to get them."""

from __future__ import annotations

import importlib.util
import sys

from tethernet_core.errors import FaultError

PROFILES = {
    "cma": "learning",
    "gymnasium": "learning",
    "sklearn": "learning",
    "stable_baselines3": "learning",
    "tensorboard": "learning",
    "torch": "learning",
    "ray": "cluster",
    "rerun": "view",
    "rclpy": "mission",
    "tethernet_msgs": "mission",
    "tf2_msgs": "mission",
}
"""The profile of the set-up that installs a package, by the name that is imported."""


MAKE_TARGETS = {"mission": "make setup", "view": "make view"}
"""Commands that do the same as a profile."""


def require(*packages: str) -> None:
    """Make sure that packages can be imported, before anything is begun that needs them.

    Args:
        packages: keys of :data:`PROFILES`.

    Raises:
        FaultError: which are missing, and what installs them.
    """
    missing = [package for package in packages if not _is_there(package)]
    if missing:
        raise FaultError(_sentence(missing))


def explain_missing(error: ModuleNotFoundError) -> FaultError | None:
    """The same for an import that has failed; None where it is not one of these packages."""
    package = (error.name or "").partition(".")[0]
    return FaultError(_sentence([package])) if package in PROFILES else None


def _is_there(package: str) -> bool:
    if package in sys.modules:
        return sys.modules[package] is not None
    return importlib.util.find_spec(package) is not None


def _sentence(missing: list[str]) -> str:
    profiles = sorted({PROFILES[package] for package in missing})
    targets = [MAKE_TARGETS[profile] for profile in profiles if profile in MAKE_TARGETS]
    return (
        f"needs {', '.join(missing)}, not installed here; "
        f"python3 -m bootstrap {' '.join(profiles)} installs {'it' if len(missing) == 1 else 'them'}"
        + (f", and so does {' '.join(targets)}" if len(targets) == len(profiles) == 1 else "")
    )
