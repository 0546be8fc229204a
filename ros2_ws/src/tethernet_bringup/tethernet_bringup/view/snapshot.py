"""What a mission looks like at one moment: all that is drawn, whatever it was learnt from."""

from __future__ import annotations

import dataclasses
import threading
from dataclasses import dataclass, field

import numpy as np

UNKNOWN = float("nan")


@dataclass(frozen=True)
class Pose:
    """Where a body is, frame launch."""

    position: np.ndarray
    """Of its centre of mass [m], shape (3,)."""
    attitude: np.ndarray
    """Unit quaternion x y z w, body to launch, shape (4,)."""


@dataclass(frozen=True)
class Event:
    """Something that is told in words."""

    time_ns: int
    """Since launch, 0 before it [ns]."""
    text: str
    warning: bool = False
    """Whether it is bad news."""


@dataclass(frozen=True)
class Snapshot:
    """One moment of a mission with M units and a net of N nodes. Frame launch; NaN is what is not known."""

    time_ns: int
    """Since launch, 0 before it [ns]."""
    units: np.ndarray
    """Positions of the units [m], shape (M, 3)."""
    thrusts: np.ndarray
    """Commanded forces [N], shape (M, 3)."""
    aiming_points: np.ndarray
    """That the units fly to until closing [m], shape (M, 3); none after that, shape (0, 3)."""
    tracking_errors: np.ndarray
    """Of each unit [m], shape (M,)."""
    fuel: np.ndarray
    """Used by each unit [kg], shape (M,)."""
    closing_points: np.ndarray
    """Where units meet, each place once [m], shape (K, 3); none before closing."""
    knots: np.ndarray | None = None
    """Positions of the net's nodes [m], shape (N, 3); None where nothing measures the net."""
    locked: np.ndarray | None = None
    """Which closing pairs hold, in their order round the mouth, shape (R,), bool; likewise."""
    debris: Pose | None = None
    chaser: Pose | None = None
    planned_debris: np.ndarray | None = None
    """Where the planner takes the debris to be [m], shape (3,); where nothing measures it, this is all there is."""
    distance: float = UNKNOWN
    """Between the centres of mass of net and debris [m]."""
    cqi: float = UNKNOWN
    """Capture Quality Index [-]."""
    locked_pairs: float = UNKNOWN
    events: tuple[Event, ...] = field(default=())
    """What has happened since the snapshot before."""

    def after(self, missed: Snapshot) -> Snapshot:
        """This one with the events of one that was never looked at: pictures may be left out, words not."""
        return dataclasses.replace(self, events=missed.events + self.events)


class Newest:
    """Hands snapshots from the thread that makes them to the one that draws them: a queue of one, which drops.

    Whoever draws may stand still for as long as it likes; who puts never waits, and the memory that is taken stays one
    snapshot and what has happened in words.
    """

    def __init__(self) -> None:
        self._waiting: Snapshot | None = None
        self._closed = False
        self._news = threading.Condition()
        self.dropped = 0
        """Snapshots that newer ones have replaced before they were taken."""

    def put(self, snapshot: Snapshot) -> None:
        """Leave a snapshot to be drawn, in the place of one that was not taken."""
        with self._news:
            if self._waiting is not None:
                self.dropped += 1
                snapshot = snapshot.after(self._waiting)
            self._waiting = snapshot
            self._news.notify()

    def close(self) -> None:
        """Nothing more will come; what waits is still given."""
        with self._news:
            self._closed = True
            self._news.notify()

    def take(self) -> Snapshot | None:
        """Wait for the newest snapshot; None once it is closed and empty."""
        with self._news:
            self._news.wait_for(lambda: self._waiting is not None or self._closed)
            snapshot, self._waiting = self._waiting, None
            return snapshot
