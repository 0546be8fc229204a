"""Where things are. All from this file's own place, so that any working folder does."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PYTHON_PACKAGES = (
    "tethernet_core", "tethernet_ros", "tethernet_control", "tethernet_planner", "tethernet_sim", "tethernet_learning",
    "tethernet_bringup",
)  # fmt: skip
MESSAGE_PACKAGES = ("tethernet_msgs", "tf2_msgs")


@dataclass(frozen=True)
class Places:
    """Files and folders of one environment."""

    root: Path
    """The repository."""
    venv: Path
    """The environment. Beside it lie its lock and its log, so that they outlive it."""
    on_system_python: bool = False
    """Whether the environment also sees the packages of the Python that it was made with."""

    @property
    def python(self) -> Path:
        return self.venv / "bin" / "python"

    @property
    def state(self) -> Path:
        return self.venv / "setup.json"

    @property
    def lock(self) -> Path:
        return self.venv.with_name(self.venv.name + ".lock")

    @property
    def log(self) -> Path:
        return self.venv.with_name(self.venv.name + ".log")

    @property
    def build(self) -> Path:
        """Scratch folder of the messages' build."""
        return self.venv / "build"

    @property
    def requirements(self) -> Path:
        return self.root / "requirements"

    @property
    def sources(self) -> Path:
        return self.root / "ros2_ws" / "src"

    @property
    def message_sources(self) -> tuple[Path, ...]:
        """Folders of the message packages, in the order of MESSAGE_PACKAGES."""
        return self.sources / "tethernet_msgs", self.root / "ros2_ws" / "fallback" / "tf2_msgs"

    @property
    def ros2cli(self) -> Path:
        """What the stock ros2 command lacks where ROS 2 comes from wheels."""
        return self.root / "ros2_ws" / "fallback" / "ros2cli_wheels"

    @property
    def ros2cli_wheels(self) -> Path:
        """The stock ros2 command as it was built; outlives the environment."""
        return self.venv.with_name(self.venv.name + ".ros2cli")

    @property
    def warm_up(self) -> Path:
        """The module that compiles the numba kernels."""
        return self.sources / "tethernet_sim" / "tethernet_sim" / "warm_up.py"


def venv_places() -> Places:
    """The environment with ROS 2 from wheels: ``.venv``, or the folder that TETHERNET_VENV names."""
    return Places(ROOT, Path(os.environ.get("TETHERNET_VENV") or ROOT / ".venv").absolute())


def ros_places() -> Places:
    """On top of a machine's own ROS 2: the libraries that it does not bring."""
    return Places(ROOT, ROOT / ".venv.ros", on_system_python=True)
