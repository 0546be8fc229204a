"""The whole scene at a few chosen moments: net, units, debris, chaser."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tethernet_bringup.analysis.decoder import Decoder
from tethernet_bringup.analysis.mission_data import MissionData
from tethernet_bringup.analysis.series import Series
from tethernet_bringup.bags.reader import BagReader
from tethernet_core.settings import NANOSECOND_S
from tethernet_ros import topics

EARLY_SHARE = 0.45
"""Early deployment is shown at this share of the time to the trigger: the net is half open then."""
_EARLY_AT_MOST_S = 12.0
_FRESH_NS = 1_000_000_000  # older than this, a position says nothing about the moment


@dataclass
class Snapshot:
    """One moment."""

    title: str
    time_s: float
    """Since launch [s]."""
    stamp_ns: int
    knots: np.ndarray | None = None  # (N, 3)
    """Knots of the net [m]; None where the net is not recorded."""
    mus: dict[int, np.ndarray] = field(default_factory=dict)
    """Positions by MU [m]."""
    trails: dict[int, np.ndarray] = field(default_factory=dict)
    """Path of each MU since launch, shape (n, 3) [m]; none after the trigger, where they would hide the net."""
    debris: np.ndarray | None = None  # (7,)
    """Position [m] and attitude x y z w."""
    debris_place: np.ndarray | None = None  # (3,)
    """Where the planner took the debris to be [m]; only where nobody recorded its motion."""
    chaser: np.ndarray | None = None  # (7,)
    locked: np.ndarray | None = None
    """Which closing pairs hold."""


def choose(data: MissionData) -> list[tuple[str, int]]:
    """Titles and times [ns] of the moments worth looking at: early deployment, trigger, verdict where a hold test
    follows, end.
    """
    begin, closing = data.origin_ns, data.closing_ns
    end = max(data.net_stamps) if data.net_stamps else data.end_ns
    if data.over_ns is not None:
        end = min(end, data.over_ns)
    until = closing if closing is not None else end
    early = begin + min(round((until - begin) * EARLY_SHARE), round(_EARLY_AT_MOST_S / NANOSECOND_S))
    moments = [("early deployment", early)]
    if closing is not None and closing <= end:
        moments.append(("trigger", closing))
    if data.judged_ns is not None and data.judged_ns <= end:
        moments += [("verdict", data.judged_ns), ("end of the hold test" if data.hold else "end", end)]
    else:
        moments.append(("end", end))
    return moments


def take(data: MissionData, bag: BagReader) -> list[Snapshot]:
    """Look at the chosen moments; reads the bag again for the net.

    Raises:
        BagError: when the bag cannot be read.
    """
    shots = []
    for title, stamp in choose(data):
        trails = {mu: _until(series, stamp) for mu, series in _paths(data).items()}
        shots.append(
            Snapshot(
                title=title,
                time_s=float(data.seconds(stamp)),
                stamp_ns=stamp,
                mus={mu: trail[-1] for mu, trail in trails.items() if len(trail)},
                trails={} if data.closing_ns is not None and stamp > data.closing_ns else trails,
                debris=_at(data.debris, stamp),
                debris_place=None if len(data.debris) else data.planned_debris,
                chaser=_at(data.chaser, stamp),
            )
        )
    if data.net_stamps:
        _add_nets(data, bag, shots)
    return shots


def _add_nets(data: MissionData, bag: BagReader, shots: list[Snapshot]) -> None:
    stamps = np.array(data.net_stamps, dtype=np.int64)
    wanted: dict[int, list[Snapshot]] = {}
    for shot in shots:
        wanted.setdefault(int(np.argmin(np.abs(stamps - shot.stamp_ns))), []).append(shot)
    decode = Decoder()
    for index, message in enumerate(bag.messages(lambda topic: topic == topics.NET_STATE)):
        if index not in wanted:
            continue
        try:
            net = decode(bag.topics[topics.NET_STATE].message_type, message.data)
            knots = np.asarray(net.knot_positions, dtype=float).reshape(-1, 3)
        except (ValueError, AttributeError):
            continue
        for shot in wanted[index]:
            shot.time_s = float(data.seconds(stamps[index]))
            shot.knots = knots if np.isfinite(knots).all() else None
            shot.locked = np.asarray(net.locked, dtype=bool)


def _paths(data: MissionData) -> dict[int, Series]:
    return {mu: data.truth.get(mu, series.measured) for mu, series in sorted(data.mus.items())} or data.truth


def _until(series: Series, stamp_ns: int) -> np.ndarray:
    stamps, values = series.sorted()
    return values[stamps <= stamp_ns]


def _at(series: Series, stamp_ns: int) -> np.ndarray | None:
    stamps, values = series.sorted()
    if not len(stamps):
        return None
    nearest = int(np.argmin(np.abs(stamps - stamp_ns)))
    return values[nearest] if abs(stamps[nearest] - stamp_ns) <= _FRESH_NS else None
