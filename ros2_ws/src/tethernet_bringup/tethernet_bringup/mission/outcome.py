"""What became of a mission: the numbers of ``outcome.json`` and the exit status.

Without ROS: messages are only read here, by their fields' names.
"""

from __future__ import annotations

import enum
import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tethernet_core.atomic_file import write_text
from tethernet_core.mission import Mission, Phase, seconds_between
from tethernet_core.mission_gate import MissionGate
from tethernet_core.system import System
from tethernet_core.unknown import answer

if TYPE_CHECKING:
    from builtin_interfaces.msg import Time

    from tethernet_msgs.msg import CaptureAssessment, MissionState, MuStatus, SimStatus

FILE_NAME = "outcome.json"


class ExitStatus(enum.IntEnum):
    """What ``run_mission.py`` ends with."""

    CAPTURED = 0
    FAULT = 1
    USAGE = 2
    NOT_CAPTURED = 3
    INTERRUPTED = 130
    TERMINATED = 143


@dataclass
class FlightRecord:
    """What was seen of a flight; None or empty where nothing was seen."""

    system: System
    """What is flown."""
    seed: int
    policy: str
    commit: str = "unknown"
    state: MissionState | None = None
    """Newest tethernet_msgs/MissionState."""
    launch_ns: int | None = None
    """Launch time [ns], from the first state that has one."""
    progress: CaptureAssessment | None = None
    """Newest tethernet_msgs/CaptureAssessment of any stage."""
    trigger: CaptureAssessment | None = None
    """The assessment at the start of closing."""
    final: CaptureAssessment | None = None
    """The assessment with the verdict."""
    hold: CaptureAssessment | None = None
    """The assessment of the hold test."""
    statuses: dict[int, MuStatus] = field(default_factory=dict)
    """Newest tethernet_msgs/MuStatus by MU."""
    sim: SimStatus | None = None
    """Newest tethernet_msgs/SimStatus."""
    start_s: float | None = None
    """From the command's start to launch [s]."""
    wall_time_s: float | None = None
    """From launch to the verdict, or to the end of it all [s], wall clock."""
    memory_mb: float | None = None
    """Largest sum over all processes, proportional set size [MB]."""
    messages: dict[str, int] = field(default_factory=dict)
    """Recorded messages by topic."""
    lost_controllers: set[int] = field(default_factory=set)
    """MUs whose controller died."""
    warnings: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    interrupted_by: str = ""
    """Name of the signal that ended the mission early."""

    def __post_init__(self) -> None:
        self._gate = MissionGate(Mission(self.system.unit_count))

    @property
    def phase(self) -> Phase:
        """Where the mission stands."""
        return Phase(self.state.phase) if self.state is not None else Phase.WAITING

    @property
    def reason(self) -> str:
        """Why the mission was missed or aborted, or who did not confirm; empty where nothing is said."""
        return self.state.reason if self.state is not None else ""

    @property
    def why_aborted(self) -> str:
        """The reason of an abort, in words where nothing is said."""
        return self.reason or "no reason was given"

    @property
    def launched(self) -> bool:
        """True once a launch time is known."""
        return self.launch_ns is not None

    @property
    def hold_s(self) -> float:
        """Length of the hold test that was asked for [s]; 0: none."""
        return float(self.state.hold_duration) if self.state is not None else 0.0

    @property
    def tow_n(self) -> float:
        """Tension that the chaser was to tow with in it [N]."""
        return float(self.state.tow) if self.state is not None else 0.0

    @property
    def all_judged(self) -> bool:
        """Whether the verdict is there, and where a hold test was asked for, that on the hold too."""
        return self.final is not None and (self.hold_s == 0.0 or self.hold is not None)

    @property
    def hold_cut_short(self) -> bool:
        """Whether the mission ended, by hand or by a fault, before the hold test was over that was asked for."""
        return bool(self.interrupted_by or self.faults) and self.hold_s > 0.0 and self.hold is None

    def forget_what_was_heard(self) -> None:
        """Go back to what this command knows of itself, where what it has heard cannot be made sense of."""
        self.state = self.progress = self.trigger = self.final = self.hold = self.sim = None
        self.statuses = {}

    def take_state(self, state: MissionState) -> None:
        """Take over a state of the mission, where it counts; see :class:`MissionGate`."""
        if state.phase > max(Phase):
            return
        phase, count = Phase(state.phase), self.system.unit_count
        heard = Mission(count, phase=phase, sequence=state.sequence, mission_id=state.mission_id)
        if not self._gate.take(heard) and not self._gate.is_present(heard):
            return
        self.state = state
        if self.launch_ns is None and (phase.under_way or phase in (Phase.COMPLETE, Phase.MISSED)):
            self.launch_ns = nanoseconds(state.launch_time)

    @property
    def newest_ns(self) -> int | None:
        """Newest stamp that anybody has told [ns]."""
        told = [message for message in (*self.statuses.values(), self.progress, self.sim) if message is not None]
        return max((nanoseconds(message.header.stamp) for message in told), default=None)

    @property
    def time_s(self) -> float | None:
        """Mission time: since launch [s]."""
        if self.launch_ns is None or not self.launched or self.newest_ns is None:
            return None
        return max(0.0, seconds_between(self.launch_ns, self.newest_ns))

    def hears_odometry(self, mu: int) -> bool:
        """Whether this MU's controller has taken odometry: its account bears the stamp of the newest."""
        status = self.statuses.get(mu)
        return status is not None and nanoseconds(status.header.stamp) > 0

    @property
    def common_ns(self) -> int | None:
        """Stamp that half of the controllers have reached [ns]: no single clock gone wrong moves it; without units, the
        newest stamp.
        """
        if not self.system.units:
            return self.newest_ns
        stamps = sorted(nanoseconds(status.header.stamp) for status in self.statuses.values())
        return stamps[(len(stamps) - 1) // 2] if stamps else None

    @property
    def most_flown_s(self) -> float | None:
        """Mission time that half of the controllers have reached, or where there are none, anything has: since launch
        [s].
        """
        if self.launch_ns is None or self.common_ns is None:
            return None
        return seconds_between(self.launch_ns, self.common_ns)


def nanoseconds(stamp: Time) -> int:
    """A builtin_interfaces/Time as one number [ns]."""
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def build(record: FlightRecord) -> dict[str, Any]:
    """The content of ``outcome.json``; null stands for what is not known or was not measured.

    ``captured`` is what the exit status says: true with 0, and false with every other.
    """
    status = exit_status(record)
    final, trigger = record.final, record.trigger
    closing = record.state is not None and nanoseconds(record.state.closing_time) > 0
    late = sum(record.sim.late_commands) if record.sim is not None else 0
    own = [record.statuses[mu] for mu in _mus(record) if mu in record.statuses]
    gaps = sum(status.deadline_misses for status in own)
    judged = final is not None or record.phase in (Phase.HOLDING, Phase.COMPLETE, Phase.MISSED)
    trigger_time = _time(record, "closing_time") if closing else None
    end_time = _time(record, "end_time") if judged else None
    tested = record.state is not None and nanoseconds(record.state.hold_end_time) > 0
    newest = record.hold if record.hold is not None else final
    content = {
        "captured": status == ExitStatus.CAPTURED,
        "exit_status": int(status),
        "verdict": verdict(record),
        "capture_verdict": final.verdict if final is not None else None,
        "cqi": _number(final, "cqi"),
        "cqi_all": _number(final, "cqi_all"),
        "mcqi": _number(final, "mcqi"),
        "enclosed": answer(final, "enclosed"),
        "locked_pairs": int(final.locked_pairs) if final is not None else None,
        "held": answer(record.hold, "held"),
        "hold_verdict": hold_verdict(record),
        "hold_end_time_s": _time(record, "hold_end_time") if record.hold is not None and tested else None,
        "hold_s": record.hold_s,
        "tow_n": record.tow_n,
        "max_load_share": _number(newest, "max_load_share"),
        "max_contact_force_n": _number(newest, "max_contact_force"),
        "trigger_time_s": trigger_time,
        "end_time_s": end_time,
        "fuel_kg": _per_mu(record, "fuel"),
        "fuel_at_trigger_kg": _per_mu(record, "fuel_at_trigger"),
        "mouth_area_m2": _number(trigger, "mouth_area"),
        "net_debris_distance_m": _number(final, "net_debris_distance"),
        "max_tracking_error_m": max(filter(math.isfinite, (s.max_tracking_error for s in own)), default=None),
        "wall_time_s": _rounded(record.wall_time_s),
        "real_time_factor": _real_time_factor(record),
        "messages": dict(sorted(record.messages.items())),
        "deadline_misses": late + gaps,
        "seed": record.seed,
        "mus": record.system.unit_count,
        "system": record.system.name,
        "system_digest": record.system.digest,
        "policy": record.policy,
        "prediction": _prediction(record),
        "commit": record.commit,
        "phase": record.phase.name,
        "flown_s": record.time_s,
        "assessed_from": final.source if final is not None else None,
        "aiming_sources": [record.statuses[mu].aiming_source if mu in record.statuses else None for mu in _mus(record)],
        "late_commands": late,
        "odometry_gaps": gaps,
        "rejected_odometry": sum(status.rejected_odometry for status in own),
        "rejected_commands": sum(record.sim.rejected_commands) if record.sim is not None else 0,
        "clipped_commands": sum(record.sim.clipped_commands) if record.sim is not None else 0,
        "latency_p50_ms": _milliseconds(record.sim, "latency_p50"),
        "latency_p99_ms": _milliseconds(record.sim, "latency_p99"),
        "latency_max_ms": _milliseconds(record.sim, "latency_max"),
        "start_s": _rounded(record.start_s),
        "memory_mb": _rounded(record.memory_mb),
        "lost_controllers": sorted(record.lost_controllers),
        "warnings": list(record.warnings),
        "faults": list(record.faults),
    }
    return _finite(content)


def _finite(value: Any) -> Any:
    """The same with null for every number that JSON does not have."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _prediction(record: FlightRecord) -> dict[str, Any] | None:
    """What a surrogate expected at the trigger, and by how much the end differs (exact minus predicted)."""
    told = [message for message in (record.final, record.trigger) if message is not None and message.prediction_valid]
    if not told:
        return None
    message = told[0]
    return {
        "predictor": message.predictor,
        "cqi": _number(message, "predicted_cqi"),
        "locked_pairs": _number(message, "predicted_locked_pairs"),
        "capture_probability": _number(message, "predicted_capture_probability"),
        "cqi_error": _number(message, "cqi_error"),
        "locked_pairs_error": _number(message, "locked_pairs_error"),
    }


def verdict(record: FlightRecord) -> str:
    """One sentence: what became of the mission. A verdict that was made before the hold test was cut short stays in
    it.
    """
    cut_short = ""
    if record.final is not None and record.hold_cut_short:
        cut_short = f"the hold test was not over ({record.final.verdict})"
    if record.faults:
        return "; ".join(filter(None, (record.faults[0], cut_short)))
    if record.final is not None and not cut_short:
        return record.final.verdict
    if record.interrupted_by:
        when = f"{record.time_s:.1f} s after launch" if record.time_s is not None else "before launch"
        return f"ended by {record.interrupted_by} {when}: {cut_short or 'no verdict'}"
    if record.phase == Phase.ABORTED:
        return f"aborted: {record.why_aborted}"
    return "no verdict"


def hold_verdict(record: FlightRecord) -> str | None:
    """One sentence: what became of the hold test; None where none was asked for, or the mission did not get so far."""
    return record.hold.hold_verdict if record.hold is not None else None


def exit_status(record: FlightRecord) -> ExitStatus:
    """What the command's exit status says of this flight."""
    if record.faults:
        return ExitStatus.FAULT
    if record.final is not None and not record.hold_cut_short:
        return ExitStatus.CAPTURED if record.final.captured else ExitStatus.NOT_CAPTURED
    if record.interrupted_by:
        return ExitStatus.TERMINATED if record.interrupted_by == "SIGTERM" else ExitStatus.INTERRUPTED
    return ExitStatus.FAULT


def write(folder: Path, content: dict[str, Any]) -> Path:
    """Write ``outcome.json`` whole or not at all.

    Args:
        folder: the run's folder.
        content: from :func:`build`.

    Raises:
        OSError: when the folder cannot be written to.
    """
    path = folder / FILE_NAME
    write_text(path, json.dumps(content, indent=2, allow_nan=False) + "\n")
    return path


def _mus(record: FlightRecord) -> range:
    return range(1, record.system.unit_count + 1)


def _per_mu(record: FlightRecord, name: str) -> list[float | None]:
    return [_number(record.statuses.get(mu), name) for mu in _mus(record)]


def _number(message: object, name: str) -> float | None:
    value = getattr(message, name) if message is not None else math.nan
    return float(value) if math.isfinite(value) else None


def _milliseconds(message: object, name: str) -> float | None:
    value = _number(message, name)
    return None if value is None else round(value * 1e3, 3)


def _time(record: FlightRecord, name: str) -> float | None:
    if record.launch_ns is None:
        return None
    return seconds_between(record.launch_ns, nanoseconds(getattr(record.state, name)))


def _real_time_factor(record: FlightRecord) -> float | None:
    if not record.wall_time_s or record.time_s is None:
        return None
    return _rounded(record.time_s / record.wall_time_s)


def _rounded(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, 3)
