"""What a person sees of a mission: one live line on a terminal, plain lines now and then elsewhere."""

from __future__ import annotations

import math
import os
import shutil
import time
from typing import TYPE_CHECKING, TextIO

from tethernet_bringup.mission.outcome import FlightRecord
from tethernet_core.mission import Phase
from tethernet_core.unknown import answer

if TYPE_CHECKING:
    from tethernet_msgs.msg import CaptureAssessment

_LIVE_PERIOD_S = 0.2
_PHASE_TEXT = {
    Phase.ARMED: "armed",
    Phase.DEPLOYING: "launch",
    Phase.CLOSING: "trigger",
    Phase.COMPLETE: "end of the capture",
    Phase.MISSED: "missed",
    Phase.ABORTED: "aborted",
    Phase.HOLDING: "hold test",
}
_WHAT_HAPPENS = {
    Phase.DEPLOYING: {"flown": ": the units pull the net open", "ejected": ": the net is ejected"},
    Phase.CLOSING: {
        "docking": ": the units close the net", "winch": ": winches close the net", "none": ": nothing closes the net",
    },
}  # fmt: skip


class Display:
    """Prints the progress of a mission. A reader that goes away does not disturb the mission."""

    def __init__(self, stream: TextIO, report_period_s: float, live: bool | None = None):
        """Args:
        stream: where to print.
        report_period_s: mission time between two plain lines [s].
        live: whether the last line may be overwritten; by default, whether ``stream`` is a terminal that can do it.
        """
        self._stream = stream
        self._period = report_period_s
        self._live = stream.isatty() and os.environ.get("TERM") != "dumb" if live is None else live
        self._shown = 0.0
        self._open_line = False
        self._gone = False
        self._next_report_s = 0.0
        self._phase: Phase | None = None
        self._told_verdict = False

    def note(self, text: str) -> None:
        """A line, or several, to stay."""
        self._write(("\r\x1b[K" if self._open_line else "") + text + "\n")
        self._open_line = False

    def live(self, text: str) -> None:
        """A line that the next one overwrites; nothing where there is no terminal."""
        now = time.monotonic()
        if self._live and now - self._shown >= _LIVE_PERIOD_S:
            self._shown = now
            self._overwrite(text)

    def flight(self, record: FlightRecord) -> None:
        """Show where the mission stands, as often as it helps."""
        if record.phase != self._phase:
            self._phase = record.phase
            if record.phase in _PHASE_TEXT:
                self.note(_phase_line(record))
        if record.phase == Phase.HOLDING and record.final is not None and not self._told_verdict:
            self._told_verdict = True  # of other missions it is the last thing that is said
            self.note(f"{record.time_s or 0.0:6.1f} s  {record.final.verdict}")
        if not record.launched or record.phase.over:
            return
        if self._live:
            self.live(flight_line(record))
        elif record.time_s is not None and record.time_s >= self._next_report_s:
            self._next_report_s = (math.floor(record.time_s / self._period) + 1) * self._period
            self.note(flight_line(record))

    def _overwrite(self, text: str) -> None:
        width = shutil.get_terminal_size().columns - 1
        self._write("\r\x1b[K" + text[:width])
        self._open_line = True

    def _write(self, text: str) -> None:
        if self._gone:
            return
        try:
            self._stream.write(text)
            self._stream.flush()
        except (OSError, ValueError):  # the reader is gone; the mission matters more
            self._gone = True


def flight_line(record: FlightRecord) -> str:
    """Time, phase, distance, tracking error, fuel, locked pairs in one line that fits into 80 columns."""
    statuses, progress = record.statuses.values(), record.progress
    parts = [f"{record.time_s or 0.0:6.1f} s", f"{record.phase.name:<9}"]
    if progress is not None:
        parts.append(f"distance {_figure(progress.net_debris_distance, 5, 2)} m")
    if record.phase == Phase.HOLDING:
        parts += _holding(progress)
    elif record.system.units:
        parts.append(f"error {_figure(max((s.tracking_error for s in statuses), default=math.nan), 4, 2)} m")
        parts.append(f"fuel {sum(s.fuel for s in statuses):5.3f} kg")
    if progress is not None and progress.max_locked_pairs:
        parts.append(f"pairs {progress.locked_pairs}/{progress.max_locked_pairs}")
    if record.lost_controllers:
        parts.append("lost: " + ", ".join(f"MU {mu}" for mu in sorted(record.lost_controllers)))
    return "  ".join(parts)


def _holding(progress: CaptureAssessment | None) -> list[str]:
    """How the debris is held just now, as far as it is known."""
    inside = None if progress is None else answer(progress, "enclosed")
    share = math.nan if progress is None else progress.max_load_share
    parts = [] if inside is None else ["enclosed" if inside else "not enclosed"]
    return parts + ([f"load {100.0 * share:.1f} %"] if math.isfinite(share) else [])


def _phase_line(record: FlightRecord) -> str:
    text = _PHASE_TEXT[record.phase]
    what = _WHAT_HAPPENS.get(record.phase, {})
    if record.phase == Phase.CLOSING:
        text += what[record.system.closing.kind]
    elif what:
        text += what[record.system.launch.kind if record.system.units else "ejected"]
    if record.phase == Phase.HOLDING:
        text += f": {record.hold_s:g} s, "
        text += f"the chaser tows with {record.tow_n:g} N" if record.tow_n else "the chaser coasts"
    elif record.phase == Phase.COMPLETE and record.hold_s:
        text = "end of the hold test"
    if record.phase in (Phase.MISSED, Phase.ABORTED) and record.reason:
        text += f": {record.reason}"
    when = f"{record.time_s:6.1f} s" if record.time_s is not None else " " * 8
    return f"{when}  {text}"


def _figure(value: float, width: int, digits: int) -> str:
    return f"{value:{width}.{digits}f}" if math.isfinite(value) else "-".rjust(width)
