"""A mission that is shown while it is flown, as the command sees it: where to, and what becomes of it at the end."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from tethernet_bringup.view.arguments import FILE, WEB, view_target

if TYPE_CHECKING:
    from tethernet_bringup.view.application import Application

LOG_NAME = "rerun.log"


class Speaker(Protocol):
    """Whatever tells the user."""

    def note(self, text: str) -> None: ...


class Stopper(Protocol):
    """Whatever knows of the user's Ctrl-C."""

    name: str
    """The signal that came; empty before."""


class View:
    """What ``--view`` asks for."""

    def __init__(self, word: str):
        """Make sure that it can be done; nothing is begun.

        Args:
            word: of the command line, checked.

        Raises:
            FaultError: when Rerun is not installed.
            InputError: where there is no display for a window.
        """
        from tethernet_bringup.view import application

        self._target = view_target(word)
        application.check(self._target)
        self._application: Application | None = None

    @property
    def told(self) -> str:
        """Where to look, for the user."""
        if self._target.kind == FILE:
            return f"view: recorded to {self._target.path}"
        if self._application is not None and self._target.kind == WEB:
            return f"view: {self._application.page}"
        return "view: in Rerun's window"

    def begin(self, memory_mb: int, logs: Path) -> str:
        """Open the window or the server; what sends it pictures waits for it, not this process.

        Args:
            memory_mb: most memory for pictures [MB].
            logs: folder for what it prints.

        Returns:
            Where the viewer's node shows the mission: an address, or the path of a file.

        Raises:
            FaultError: when it cannot be started.
        """
        if self._target.kind == FILE:
            return str(self._target.path)
        from tethernet_bringup.view.application import Application

        self._application = Application(self._target.kind, memory_mb, logs / LOG_NAME)
        return self._application.address

    def leave(self, display: Speaker, interrupts: Stopper) -> None:
        """The mission is over and told: a window stays open without us, a server until Ctrl-C.

        Args:
            display: tells the user.
            interrupts: a mission that was interrupted ends at once.
        """
        if self._application is None:
            return
        if self._application.failed:
            display.note(f"view: Rerun ended in flight, see {LOG_NAME} in the logs")
        if self._target.kind != WEB:
            return
        if not interrupts.name and self._application.running:
            display.note(f"view: stays at {self._application.page} until Ctrl-C")
            self._application.stay(lambda: bool(interrupts.name))
        self._application.stop()
