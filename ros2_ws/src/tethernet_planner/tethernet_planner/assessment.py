"""When the capture is assessed, and how well it looks; without ROS."""

from __future__ import annotations

import enum
import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from tethernet_core.capture_quality import captured, deciding, hull_quality, mouth_area, verdict
from tethernet_core.mission import Mission, Phase
from tethernet_core.mission_gate import MissionGate
from tethernet_core.settings import ControlParameters
from tethernet_core.system import System
from tethernet_planner.inference.net_sample import FROM_MUS, FROM_NET, NetSample
from tethernet_planner.inference.prediction import Prediction, Predictor

_KEPT = 16
"""Samples kept for a mission state that comes later than the samples it speaks of."""

_PATIENCE_S = 1.0  # [s] wall time to wait for the sample of the end after the mission is over


class Stage(enum.IntEnum):
    """Stages; the numbers are those of tethernet_msgs/CaptureAssessment."""

    PROGRESS = 0
    TRIGGER = 1
    FINAL = 2


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
    ``end_ns``. Mission states and samples may come in any order within some ticks.
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
        self._triggered = self._concluded = False
        self._over_since_s = math.inf

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
        if mission.phase in (Phase.COMPLETE, Phase.MISSED):
            self._over_since_s = self._clock()
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
        """The verdict on what was seen last, when the mission is over and no sample of its end has come.

        To be asked now and then.
        """
        if self._concluded or self._clock() - self._over_since_s < _PATIENCE_S:
            return []
        self._concluded = True
        if self._recent:
            return [self._assess(self._recent[-1], Stage.FINAL)]
        nothing = math.nan
        text, held = self._judge(nothing, 0, FROM_NET)
        unknown = (nothing,) * 6
        return [Assessment(Stage.FINAL, self.mission.end_ns, *unknown, 0, FROM_NET, held, text)]

    def _due_at(self, sample: NetSample) -> list[Assessment]:
        mission, due = self.mission, []
        if mission.closing and not self._triggered and sample.stamp_ns >= mission.closing_ns:
            self._triggered = True
            due.append(self._assess(sample, Stage.TRIGGER))
        ending = mission.phase in (Phase.CLOSING, Phase.COMPLETE, Phase.MISSED) and sample.stamp_ns >= mission.end_ns
        if ending and not self._concluded:
            self._concluded = True
            due.append(self._assess(sample, Stage.FINAL))
        return due

    def _progress_at(self, sample: NetSample) -> list[Assessment]:
        if self.mission.phase not in (Phase.DEPLOYING, Phase.CLOSING) or self._concluded:
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
        text, held = self._judge(decides, sample.locked_pairs, sample.source) if stage == Stage.FINAL else ("", False)
        failure = self._predict(sample) if stage == Stage.TRIGGER else ""
        prediction = None if stage == Stage.PROGRESS else self._prediction
        mouth = mouth_area(sample.mu_positions, self._system, sample.knot_positions)
        return Assessment(
            stage, sample.stamp_ns, cqi, cqi_all, volume, area, mouth, distance,
            sample.locked_pairs, sample.source, held, text, prediction, failure,
        )  # fmt: skip

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

    def _judge(self, cqi: float, locked_pairs: int, source: str) -> tuple[str, bool]:
        mission = self.mission
        missed = mission.reason if mission.phase == Phase.MISSED else ""
        text = verdict(cqi, locked_pairs, self._system, missed)
        if source == FROM_MUS and not missed and self._system.closing.kind == "winch":
            text += "; pairs that winches lock cannot be seen from the MUs"
        return text, not missed and captured(cqi, locked_pairs, self._system)
