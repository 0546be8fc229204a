"""A Rerun recording, open towards a file or a server."""

from __future__ import annotations

import contextlib
import os
from typing import TYPE_CHECKING, NoReturn

from tethernet_core.errors import FaultError

if TYPE_CHECKING:
    import rerun

APPLICATION = "tethernet"
SERVER = "rerun+http://"
"""What the address of a server begins with; anything else is a file."""


def open_recording(output: str, name: str) -> rerun.RecordingStream:
    """Begin a recording.

    Args:
        output: address of a server, or path of a file, which is written over.
        name: shown for it.

    Raises:
        FaultError: when the file cannot be made.
    """
    import rerun

    # It would wait, at the end of the process, for a server that does not listen any more.
    rerun.unregister_shutdown()
    recording = rerun.RecordingStream(APPLICATION)
    try:
        if output.startswith(SERVER):
            recording.connect_grpc(output)
        else:
            recording.save(output)
    except Exception as error:  # Rerun's own errors have no common class
        raise FaultError(f"cannot write to {output}: {error}") from error
    recording.send_recording_name(name)
    return recording


def close(recording: rerun.RecordingStream, output: str) -> None:
    """Send and write what is left, and end the recording.

    Args:
        recording: that is open.
        output: where to, as in :func:`open_recording`.

    Raises:
        FaultError: when what is shown does not arrive: the disk is full, the window was closed.
    """
    try:
        recording.flush()
    except Exception as error:
        raise FaultError(f"not all of it has reached {output}: {error}") from error
    finally:
        with contextlib.suppress(Exception):
            recording.disconnect()


def leave_now(status: int) -> NoReturn:
    """End this process at once, where a thread of Rerun's waits for something that does not come."""
    os._exit(status)
