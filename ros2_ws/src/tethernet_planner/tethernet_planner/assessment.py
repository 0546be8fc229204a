"""When the capture is assessed, and how well it looks; without ROS."""

from __future__ import annotations

import dataclasses
import enum
import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tethernet_core.capture_quality import captured, deciding, hull_quality, mouth_area, verdict
from tethernet_core.enclosure import enclosed
from tethernet_core.hold import NOT_MEASURED, held, never_held, overload
from tethernet_core.mission import Mission, Phase
from tethernet_core.mission_gate import MissionGate
from tethernet_core.modified_quality import modified_quality
from tethernet_core.settings import ControlParameters
from tethernet_core.system import System
from tethernet_planner.inference.net_sample import FROM_MUS, FROM_NET, NetSample
from tethernet_planner.inference.prediction import Prediction, Predictor

_KEPT = 16
"""Samples kept for a mission state that comes later than the samples it speaks of."""

_PATIENCE_S = 1.0  # [s] wall time to wait for the sample of an end that the mission is past


class Stage(enum.IntEnum):
    """Stages; the numbers are those of tethernet_msgs/CaptureAssessment."""

    PROGRESS = 0
    TRIGGER = 1
    FINAL = 2
    HELD = 3


@dataclass(frozen=True)
class Assessment:
    """How well the debris is held; the fields of tethernet_msgs/CaptureAssessment."""

    stage: Stage
    stamp_ns: int
    cqi: float
    """[-], with the knots' centre of mass; NaN where nothing measures the net."""
    cqi_all: float
    """[-], with the MUs counted; NaN likewise."""
    hull_volume: float
    """[m^3], NaN likewise."""
    hull_area: float
    """[m^2], NaN likewise."""
    mouth_area: float
    """[m^2]."""
    net_debris_distance: float
    """[m]."""
    locked_pairs: int
    source: str
    captured: bool = False
    """Final stage only."""
    verdict: str = ""
    """Final stage only: one sentence."""
    mcqi: float = math.nan
    """[-]; NaN where net or debris' attitude are not measured; from the final stage on."""
    enclosed: bool | None = None
    """Whether the closed net goes round the whole debris; None likewise; from the start of closing on."""
    max_load_share: float = math.nan
    """Largest tension of any thread over its strength since launch [-]; NaN where it is not known."""
    max_contact_force_n: float = math.nan
    """Largest force of contact on the debris since launch [N]; likewise."""
    held: bool | None = None
    """Held stage only; None where that is not known."""
    hold_verdict: str = ""
    """Held stage only: one sentence."""
    prediction: Prediction | None = None
    """Where there is a surrogate: at the trigger, and at the end once more beside the exact values."""
    prediction_failure: str = ""
    """Trigger stage only: why the surrogate could not be asked."""

    @property
    def numbers(self) -> dict[str, float]:
        """All numbers that may not be known, by the names of the message's fields; NaN where they are not."""
        predicted = self.prediction or Prediction(math.nan, math.nan, math.nan)
        return {
            "cqi": self.cqi,
            "cqi_all": self.cqi_all,
            "mcqi": self.mcqi,
            "max_load_share": self.max_load_share,
            "max_contact_force": self.max_contact_force_n,
            "hull_volume": self.hull_volume,
            "hull_area": self.hull_area,
            "mouth_area": self.mouth_area,
            "net_debris_distance": self.net_debris_distance,
            "predicted_cqi": predicted.cqi,
            "predicted_locked_pairs": predicted.locked_pairs,
            "predicted_capture_probability": predicted.capture_probability,
            "cqi_error": self.cqi_error,
            "locked_pairs_error": self.locked_pairs_error,
        }

    @property
    def cqi_error(self) -> float:
        """Exact minus predicted CQI [-]; NaN before the end and without a prediction."""
        return self._error(self.cqi, "cqi")

    @property
    def locked_pairs_error(self) -> float:
        """Exact minus predicted locked pairs; NaN before the end and without a prediction."""
        return self._error(self.locked_pairs, "locked_pairs")

    def _error(self, exact: float, name: str) -> float:
        if self.stage != Stage.FINAL or self.prediction is None:
            return math.nan
        return exact - getattr(self.prediction, name)


class CaptureAssessor:
    """Turns samples of the net and states of the mission into assessments at the right times.

    The trigger is assessed at the first sample not before ``closing_ns``, the end at the first one not before
    ``end_ns``, the end of a hold test at the first one not before ``hold_end_ns``. Mission states and samples may come
    in any order within some ticks.
    """

    def __init__(
        self,
        system: System,
        control: ControlParameters,
        progress_every: int,
        predictor: Predictor | None = None,
        clock: Callable[[], float] = time.monotonic,
    ):
        """Args:
        system: net, units, and what counts as captured.
        control: gives the control period.
        progress_every: control ticks between two progress reports.
        predictor: surrogate asked at the trigger, or None.
        clock: wall time [s].
        """
        self._gate = MissionGate(Mission(system.unit_count))
        self._system = system
        self._progress_ns = progress_every * control.period_ns
        self._predictor = predictor
        self._prediction: Prediction | None = None
        self._clock = clock
        self._recent: deque[NetSample] = deque(maxlen=_KEPT)
        self._last_progress = -1
        self._triggered = self._concluded = self._hold_concluded = False
        self._judged_since_s = self._over_since_s = math.inf
        self._locked: tuple[bool, ...] = ()

    @property
    def mission(self) -> Mission:
        """The newest state of the mission that counts."""
        return self._gate.mission

    def take_mission(self, mission: Mission) -> list[Assessment]:
        """Take over a newer state of the mission.

        Returns:
            Assessments that have become due at samples seen before, oldest first.
        """
        if not self._gate.take(mission):
            return []
        if mission.judged:
            self._judged_since_s = min(self._judged_since_s, self._clock())
        if mission.judged and mission.phase.over:
            self._over_since_s = min(self._over_since_s, self._clock())
        return [assessment for sample in self._recent for assessment in self._due_at(sample)]

    def take_sample(self, sample: NetSample) -> list[Assessment]:
        """Take the next sample.

        Returns:
            Assessments that are due at it.
        """
        self._recent.append(sample)
        due = self._due_at(sample)
        return due or self._progress_at(sample)

    def overdue(self) -> list[Assessment]:
        """The verdict on what was seen last, when the mission is past its end and no sample of that has come; the same
        for the end of a hold test.

        To be asked now and then.
        """
        now, due = self._clock(), []
        if not self._concluded and now - self._judged_since_s >= _PATIENCE_S:
            due += self._conclude(self._recent[-1] if self._recent else None)
        if self._concluded and self._hold_due and now - self._over_since_s >= _PATIENCE_S:
            due.append(self._conclude_hold(self._recent[-1] if self._recent else None))
        return due

    @property
    def _hold_due(self) -> bool:
        """Whether a hold test has begun of which it is not said yet what it came to."""
        return self.mission.hold_end_ns > 0 and not self._hold_concluded

    def _due_at(self, sample: NetSample) -> list[Assessment]:
        mission, due = self.mission, []
        if mission.closing and not self._triggered and sample.stamp_ns >= mission.closing_ns:
            self._triggered = True
            due.append(self._assess(sample, Stage.TRIGGER))
        ending = mission.phase == Phase.CLOSING or mission.judged
        if ending and sample.stamp_ns >= mission.end_ns and not self._concluded:
            due += self._conclude(sample)
        if self._concluded and self._hold_due and sample.stamp_ns >= mission.hold_end_ns:
            due.append(self._conclude_hold(sample))
        return due

    def _conclude(self, sample: NetSample | None) -> list[Assessment]:
        """The verdict, on nothing where no sample has ever come; where a mission was missed that was to be tested for
        holding, that too.
        """
        self._concluded = True
        self._locked = () if sample is None else sample.locked
        final = self._unmeasured(Stage.FINAL) if sample is None else self._assess(sample, Stage.FINAL)
        mission = self.mission
        if mission.phase != Phase.MISSED or mission.hold_s == 0.0:
            return [final]
        self._hold_concluded = True
        found = never_held(final.verdict)
        nothing_new = dataclasses.replace(final, stage=Stage.HELD, captured=False, verdict="", prediction=None)
        return [final, dataclasses.replace(nothing_new, held=found.held, hold_verdict=found.verdict)]

    def _conclude_hold(self, sample: NetSample | None) -> Assessment:
        """What the hold test came to."""
        self._hold_concluded = True
        if sample is None:
            return dataclasses.replace(self._unmeasured(Stage.HELD), hold_verdict=held(None, (), (), math.nan).verdict)
        seen = self._assess(sample, Stage.HELD)
        unknown = "nothing tells the debris' attitude" if sample.source == FROM_NET else NOT_MEASURED
        known = len(self._locked) == len(sample.locked)
        found = held(
            seen.enclosed, self._locked if known else (), sample.locked if known else (), sample.max_load_share, unknown
        )
        return dataclasses.replace(seen, held=found.held, hold_verdict=found.verdict)

    def _unmeasured(self, stage: Stage) -> Assessment:
        """What is said where no sample has ever come."""
        nothing, mission = math.nan, self.mission
        text, captured_ = self._judge(nothing, 0, FROM_NET, nothing) if stage == Stage.FINAL else ("", False)
        unknown = (nothing,) * 6
        stamp_ns = mission.end_ns if stage == Stage.FINAL else mission.hold_end_ns
        return Assessment(stage, stamp_ns, *unknown, 0, FROM_NET, captured_, text)

    def _progress_at(self, sample: NetSample) -> list[Assessment]:
        phase = self.mission.phase
        done = self._hold_concluded if phase == Phase.HOLDING else self._concluded
        if done or not phase.under_way:
            return []
        progress = (sample.stamp_ns - self.mission.launch_ns) // self._progress_ns
        if progress <= self._last_progress:
            return []
        self._last_progress = progress
        return [self._assess(sample, Stage.PROGRESS)]

    def _assess(self, sample: NetSample, stage: Stage) -> Assessment:
        cqi = cqi_all = volume = area = math.nan
        distance = math.dist(sample.center, sample.debris_position)
        if sample.source == FROM_NET:
            hull = hull_quality(
                sample.knot_positions, sample.mu_positions, sample.center, sample.debris_position, self._system,
                sample.center_all,
            )  # fmt: skip
            cqi, cqi_all, volume, area, distance = hull.cqi, hull.cqi_all, hull.volume, hull.area, hull.distance
        decides = deciding(cqi, cqi_all, self._system)
        text, good = "", False
        if stage == Stage.FINAL:
            text, good = self._judge(decides, sample.locked_pairs, sample.source, sample.max_load_share)
        mcqi, inside = self._enclosure(sample, stage)
        failure = self._predict(sample) if stage == Stage.TRIGGER else ""
        mouth = mouth_area(sample.mu_positions, self._system, sample.knot_positions)
        return Assessment(
            stage, sample.stamp_ns, cqi, cqi_all, volume, area, mouth, distance,
            sample.locked_pairs, sample.source, good, text, mcqi, inside,
            sample.max_load_share, sample.max_contact_force_n,
            prediction=self._prediction if stage in (Stage.TRIGGER, Stage.FINAL) else None,
            prediction_failure=failure,
        )  # fmt: skip

    def _enclosure(self, sample: NetSample, stage: Stage) -> tuple[float, bool | None]:
        """The MCQI and whether the debris is enclosed, where that is known and worth its time: the first costs 20 ms,
        the second one, and neither says anything of an open net.
        """
        attitude, mission = sample.debris_attitude, self.mission
        if sample.source == FROM_MUS or attitude is None or not (mission.closing or stage == Stage.FINAL):
            return math.nan, None
        where = (
            sample.knot_positions, sample.mu_positions, np.array(sample.debris_position), np.array(attitude),
            self._system,
        )  # fmt: skip
        late = stage in (Stage.FINAL, Stage.HELD) or mission.phase == Phase.HOLDING
        return modified_quality(*where) if late else math.nan, enclosed(*where)

    def _predict(self, sample: NetSample) -> str:
        """Ask the surrogate; returns why it could not be asked. Whatever is wrong with it, the verdict must come."""
        if self._predictor is None:
            return ""
        if sample.source == FROM_MUS:
            return "nothing measures the net"
        try:
            self._prediction = self._predictor.predict(sample)
        except Exception as error:
            return f"{type(error).__name__}: {error}"
        return ""

    def _judge(self, cqi: float, locked_pairs: int, source: str, load_share: float) -> tuple[str, bool]:
        mission = self.mission
        missed = mission.reason if mission.phase == Phase.MISSED else ""
        text = verdict(cqi, locked_pairs, self._system, missed) + overload(load_share)
        if source == FROM_MUS and not missed and self._system.closing.kind == "winch":
            text += "; pairs that winches lock cannot be seen from the MUs"
        return text, not missed and captured(cqi, locked_pairs, self._system)
