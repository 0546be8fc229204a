"""The folder of one run: its name, its parts, and whether it can be written to at all."""

from __future__ import annotations

import datetime
import os
import re
import shutil
import traceback
from dataclasses import dataclass
from pathlib import Path

from tethernet_core.command import is_bad_name
from tethernet_core.shown import shown

ROOMY_BYTES = 200_000_000
"""Less free space than this is worth a warning: a recording takes some tens of megabytes."""
_LONGEST_NAME = 60
"""[characters] of a system's name in that of a folder."""


class RunFolderError(Exception):
    """The output folder cannot be used: what was given and why."""

    usage = False
    """Whether the name itself cannot be meant."""


@dataclass(frozen=True)
class RunFolder:
    """Where one run is kept."""

    path: Path

    @property
    def bag(self) -> Path:
        """The recording; the recorder makes it."""
        return self.path / "bag"

    @property
    def logs(self) -> Path:
        """One log file per node."""
        return self.path / "logs"

    @property
    def parameters(self) -> Path:
        """All parameters used, as a ROS 2 parameter file; fit for ``--params``."""
        return self.path / "parameters.yaml"

    @property
    def system(self) -> Path:
        """The complete description of the system that is flown; fit for ``--system``."""
        return self.path / "system.yaml"

    @property
    def run_info(self) -> Path:
        """Facts about the run as JSON, for the recording."""
        return self.path / "run_info.json"

    def shortage(self) -> str:
        """A warning when there is little space left, else nothing."""
        free = shutil.disk_usage(self.path).free
        if free >= ROOMY_BYTES:
            return ""
        return f"only {free / 1e6:.0f} MB are free under {self.path}; a recording takes some tens of MB"


def make_run_folder(output: str, system: str, seed: int) -> RunFolder:
    """Make a new folder ``output/<UTC time>_<system>_seed<seed>``.

    Args:
        output: the folder for all runs.
        system: name of the system; what a folder's name should not have becomes an underscore.
        seed: of the sensor noise.

    Raises:
        RunFolderError: when it cannot be made.
    """
    now = datetime.datetime.now(datetime.UTC)
    stem = f"{now:%Y%m%dT%H%M%SZ}_{_plain(system)}_seed{seed}"
    parent = Path(output).expanduser().absolute()
    if not _is_utf8(parent):
        refusal = RunFolderError(
            f"--output {shown(output)}: the name of the folder, {shown(parent)}, is not in UTF-8, the only one that "
            "ROS 2 takes; allowed: a folder with a name in UTF-8, under a locale in UTF-8 such as LC_ALL=C.UTF-8"
        )
        refusal.usage = True
        raise refusal
    try:
        parent.mkdir(parents=True, exist_ok=True)
        for number in range(1, 1000):
            folder = RunFolder(parent / (stem if number == 1 else f"{stem}_{number}"))
            try:
                folder.path.mkdir()
            except FileExistsError:
                continue
            folder.logs.mkdir()
            return folder
    except OSError as error:
        refusal = RunFolderError(
            f"--output {shown(output)}: cannot make a run's folder there: {error.strerror or error}; "
            "allowed: a folder that you may write to"
        )
        refusal.usage = is_bad_name(error)
        raise refusal from error
    raise RunFolderError(f"--output {shown(output)}: a thousand runs named {stem} are there already")


def _plain(name: str) -> str:
    return re.sub(r"[^\w.-]", "_", name, flags=re.ASCII)[:_LONGEST_NAME].lstrip(".") or "system"


def _is_utf8(path: Path) -> bool:
    """Whether parameters, which are UTF-8, can name this path as the file system does."""
    try:
        return str(path).encode("utf-8") == os.fsencode(path)
    except UnicodeEncodeError:
        return False


def keep_traceback(error: Exception, logs: Path) -> str:
    """Keep what a developer needs of an error that nobody has foreseen.

    Args:
        error: caught.
        logs: folder of the run's logs.

    Returns:
        The error in one line for the user, with the place of the traceback.
    """
    told = f"{type(error).__name__}: {shown(error)}"
    log = logs / "run_mission.log"
    try:
        with log.open("a", encoding="utf-8", errors="backslashreplace") as file:
            file.writelines(traceback.format_exception(error))
    except OSError as unwritten:
        return f"{told} (its traceback cannot be written to {log}: {unwritten.strerror})"
    return f"{told} (traceback in {log})"
