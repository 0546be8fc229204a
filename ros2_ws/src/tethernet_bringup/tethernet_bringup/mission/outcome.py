"""What became of a mission: the numbers of ``outcome.json``, the exit status, the text a person reads.

Without ROS: messages are only read here, by their fields' names.
"""

from __future__ import annotations

import enum
import json
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tethernet_core.aiming import FALLBACK
from tethernet_core.atomic_file import write_text
from tethernet_core.mission import Mission, Phase, seconds_between
from tethernet_core.mission_gate import MissionGate
from tethernet_core.system import System

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

    def forget_what_was_heard(self) -> None:
        """Go back to what this command knows of itself, where what it has heard cannot be made sense of."""
        self.state = self.progress = self.trigger = self.final = self.sim = None
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
        if self.launch_ns is None and Phase.DEPLOYING <= state.phase < Phase.ABORTED:
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
    ended = record.phase in (Phase.COMPLETE, Phase.MISSED)
    trigger_time = _time(record, "closing_time") if closing else None
    end_time = _time(record, "end_time") if ended else None
    content = {
        "captured": status == ExitStatus.CAPTURED,
        "exit_status": int(status),
        "verdict": verdict(record),
        "cqi": _number(final, "cqi"),
        "cqi_all": _number(final, "cqi_all"),
        "locked_pairs": int(final.locked_pairs) if final is not None else None,
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
    """One sentence: what became of the mission."""
    if record.faults:
        return record.faults[0]
    if record.final is not None:
        return record.final.verdict
    if record.interrupted_by:
        when = f"{record.time_s:.1f} s after launch" if record.time_s is not None else "before launch"
        return f"ended by {record.interrupted_by} {when}: no verdict"
    if record.phase == Phase.ABORTED:
        return f"aborted: {record.why_aborted}"
    return "no verdict"


def exit_status(record: FlightRecord) -> ExitStatus:
    """What the command's exit status says of this flight."""
    if record.faults:
        return ExitStatus.FAULT
    if record.final is not None:
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


def describe(record: FlightRecord, content: dict[str, Any], folder: Path, analyse_command: str) -> list[str]:
    """The block of lines that ends the mission on the terminal."""
    lines = ["", f"  {_headline(record)}   {content['verdict']}", ""]
    lines += [f"    {name:<18} {text}" for name, text in _rows(record, content)]
    for title, entries in (("faults", record.faults[1:]), ("warnings", record.warnings)):
        if entries:
            lines.append(f"    {title}")
            lines += [f"      {entry}" for entry in entries]
    lines += ["", f"    {'recording':<18} {folder / 'bag'}", f"    {'outcome':<18} {folder / FILE_NAME}"]
    lines += [f"    {'logs':<18} {folder / 'logs'}", f"    {'look at it with':<18} {analyse_command}", ""]
    return lines


def _headline(record: FlightRecord) -> str:
    status, final = exit_status(record), record.final
    if status == ExitStatus.NOT_CAPTURED and final is not None and not math.isfinite(final.cqi):
        return "DOCKED" if final.locked_pairs >= final.required_locked_pairs else "NOT DOCKED"
    words = {ExitStatus.CAPTURED: "CAPTURED", ExitStatus.NOT_CAPTURED: "NOT CAPTURED", ExitStatus.FAULT: "FAULT"}
    return words.get(status, "ENDED EARLY")


def _rows(record: FlightRecord, content: dict[str, Any]) -> Iterable[tuple[str, str]]:
    final = record.final
    if final is not None:
        if final.max_locked_pairs:
            need = f"{final.locked_pairs} of {final.max_locked_pairs} ({final.required_locked_pairs} needed)"
            yield "locked pairs", need
        yield "CQI", f"{content['cqi']:.3f}" if content["cqi"] is not None else "could not be measured"
        if content["cqi_all"] is not None:
            yield "with units counted", f"{content['cqi_all']:.3f}"
    expected = content["prediction"]
    if expected is not None:
        likely = f"captured with {100.0 * expected['capture_probability']:.0f} %"
        yield "predicted", f"{expected['locked_pairs']:.1f} pairs, CQI {expected['cqi']:.2f}, {likely}"
    fallen_back = [mu for mu, source in enumerate(content["aiming_sources"], 1) if source == FALLBACK]
    if fallen_back:
        yield "nominal points", "in the place of the policy's: " + ", ".join(f"MU {mu}" for mu in fallen_back)
    yield "trigger", _seconds(content["trigger_time_s"], "after launch")
    yield "end", _seconds(content["end_time_s"] or content["flown_s"], "after launch")
    fuel = {mu: value for mu, value in enumerate(content["fuel_kg"], 1) if value is not None}
    if fuel:
        worst = max(fuel, key=fuel.__getitem__)
        yield "fuel", f"{sum(fuel.values()):.3f} kg in all, most by MU {worst}: {fuel[worst]:.3f} kg"
    if content["max_tracking_error_m"] is not None:
        yield "tracking error", f"{content['max_tracking_error_m']:.2f} m at most"
    if content["mouth_area_m2"] is not None:
        yield "mouth at trigger", f"{content['mouth_area_m2']:.0f} m^2"
    if content["wall_time_s"] is not None and content["real_time_factor"] is not None:
        yield "wall time", f"{content['wall_time_s']:.1f} s ({content['real_time_factor']:.2f} x real time)"
    yield "deadlines missed", str(content["deadline_misses"])
    if content["messages"]:
        yield "recorded", f"{sum(content['messages'].values())} messages on {len(content['messages'])} topics"
    if record.lost_controllers:
        yield "lost controllers", ", ".join(f"MU {mu}" for mu in sorted(record.lost_controllers))


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


def _seconds(value: float | None, what: str) -> str:
    return "did not come" if value is None else f"{value:.2f} s {what}"
