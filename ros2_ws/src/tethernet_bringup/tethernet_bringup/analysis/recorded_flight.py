"""A recorded mission as moments at equal steps, for a page that plays it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from tethernet_bringup.analysis.decoder import Decoder
from tethernet_bringup.analysis.mission_data import MissionData
from tethernet_bringup.analysis.series import Series
from tethernet_bringup.bags.reader import BagReader
from tethernet_bringup.report.flight import Flight
from tethernet_core.mission import Phase
from tethernet_core.system import MOST_UNITS
from tethernet_ros import topics

FINEST_S = 0.05
"""From moment to moment at least [s]; longer where the net has many knots or the flight is long."""
MOST_NUMBERS = 2_600_000
"""Coordinates of knots that a flight is read with."""
_FRESH_S = 1.0
"""Older than this, a position says nothing about the moment [s]."""
_NAMES = {Phase.HOLDING: "hold test", Phase.COMPLETE: "end"}
_IMPOSSIBLE = 1e6
"""Farther away nothing is [m]: a broken message."""


def recorded_flight(data: MissionData, bag: BagReader) -> Flight | None:
    """The flight, from launch to the last thing that is known of it; None where nothing was flown.

    Args:
        data: the mission.
        bag: where it was read from; read again for the net.

    Raises:
        BagError: when the bag cannot be read.
    """
    end_s = _end_s(data)
    if end_s <= 0.0:
        return None
    step_s = _step_s(data, end_s)
    moments = np.arange(int(end_s / step_s + 1e-6) + 1) * step_s
    system = data.system
    flight = Flight(
        title=data.facts.get("system") or (system.name if system else "mission"),
        system="flown",
        start_s=0.0,
        step_s=step_s,
        units=_units(data, moments),
        thrust=_thrust(data, moments),
        debris=_nearest(data, data.debris, moments),
        chaser=_nearest(data, data.chaser, moments),
        debris_place=None if len(data.debris) else data.planned_debris,
        aiming=_aiming(data),
        closing=_closing(data),
        phases=_phases(data),
    )
    if data.net_stamps:
        _add_net(flight, data, bag, moments)
    return flight


def _end_s(data: MissionData) -> float:
    """Until when anything moved [s after launch]."""
    tracks = [data.net, data.debris, *data.truth.values(), *(series.measured for series in data.mus.values())]
    stamps = [int(track.stamps.max()) for track in tracks if len(track)]
    if not stamps:
        return 0.0
    end_ns = max(stamps)
    if data.over_ns is not None:
        end_ns = min(end_ns, data.over_ns)
    return float(data.seconds(end_ns))


def _step_s(data: MissionData, end_s: float) -> float:
    knots = data.system.net.node_count if data.system else 1000
    fitting = end_s * 3 * knots / MOST_NUMBERS
    return FINEST_S * max(1, math.ceil(fitting / FINEST_S))


def _nearest(data: MissionData, series: Series, moments: np.ndarray) -> np.ndarray | None:
    """The row of a series that is nearest to each moment, NaN where none is near."""
    stamps, values = series.sorted()
    if not len(stamps):
        return None
    time_s = data.seconds(stamps)
    place = _places(time_s, moments)
    rows = values[place].copy()
    rows[np.abs(time_s[place] - moments) > _FRESH_S] = np.nan
    rows[(np.abs(rows) > _IMPOSSIBLE).any(axis=1)] = np.nan
    return rows


def _places(time_s: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Which of ascending times is nearest to each moment."""
    after = np.clip(np.searchsorted(time_s, moments), 0, len(time_s) - 1)
    before = np.clip(after - 1, 0, len(time_s) - 1)
    return np.where(np.abs(time_s[before] - moments) <= np.abs(time_s[after] - moments), before, after)


def _units(data: MissionData, moments: np.ndarray) -> np.ndarray | None:
    """Their true positions where somebody told them, else the measured ones."""
    return _together(data, moments, lambda mu: data.truth[mu] if mu in data.truth else data.mus[mu].measured)


def _thrust(data: MissionData, moments: np.ndarray) -> np.ndarray | None:
    return _together(data, moments, lambda mu: data.mus[mu].thrust if mu in data.mus else Series(3))


def _together(data: MissionData, moments: np.ndarray, series_of: Callable[[int], Series]) -> np.ndarray | None:
    known = [mu for mu in {*data.mus, *data.truth} if 1 <= mu <= MOST_UNITS]  # a topic with a higher number is nobody's
    tracks = np.full((len(moments), max(known, default=0), 3), np.nan)
    for mu in known:
        rows = _nearest(data, series_of(mu), moments)
        if rows is not None:
            tracks[:, mu - 1] = rows
    return tracks if np.isfinite(tracks).any() else None


def _aiming(data: MissionData) -> np.ndarray | None:
    """Where the units were sent to; None where not all of them said it."""
    points = []
    for mu in range(1, data.mu_count + 1):
        point = getattr(getattr(data.mus.get(mu), "status", None), "aiming_point", None)
        if point is None:
            return None
        points.append((point.x, point.y, point.z))
    found = np.array(points).reshape(-1, 3)
    usable = len(found) and np.isfinite(found).all() and found.any() and (np.abs(found) < _IMPOSSIBLE).all()
    return found if usable else None


def _closing(data: MissionData) -> list[tuple[float, np.ndarray]]:
    """Closing points, each set with the time from which on it holds."""
    found: list[tuple[float, np.ndarray]] = []
    for state in data.states:
        points = np.array([(p.x, p.y, p.z) for p in getattr(state, "closing_points", ())]).reshape(-1, 3)
        if not len(points) or not (np.abs(points) < _IMPOSSIBLE).all():
            continue
        stamp = state.points_time if hasattr(state, "points_time") else state.header.stamp
        time_s = float(data.seconds(stamp.sec * 1_000_000_000 + stamp.nanosec))
        if not found or not np.array_equal(found[-1][1], points):
            found.append((time_s, points))
    return found


def _phases(data: MissionData) -> list[tuple[str, float]]:
    """From the launch on."""
    return [
        (_NAMES.get(change.phase, change.phase.name.lower()), float(data.seconds(change.time_ns)))
        for change in data.phases
        if change.phase not in (Phase.WAITING, Phase.ARMED)
    ]


def _add_net(flight: Flight, data: MissionData, bag: BagReader, moments: np.ndarray) -> None:
    """Read knots and locked pairs of the messages that are nearest to the moments."""
    stamps = np.array(data.net_stamps, dtype=np.int64)
    order = np.argsort(stamps, kind="stable")
    time_s = data.seconds(stamps[order])
    places = _places(time_s, moments)
    fresh = np.abs(time_s[places] - moments) <= _FRESH_S
    wanted: dict[int, list[int]] = {}
    for near in np.flatnonzero(fresh).tolist():
        wanted.setdefault(int(order[places[near]]), []).append(near)
    decode = Decoder()
    for index, message in enumerate(bag.messages(lambda topic: topic == topics.NET_STATE)):
        if index not in wanted:
            continue
        try:
            net = decode(bag.topics[topics.NET_STATE].message_type, message.data)
            knots = np.asarray(net.knot_positions, dtype=float).reshape(-1, 3)
            locked = np.asarray(net.locked, dtype=float)
        except (ValueError, AttributeError):
            continue
        if flight.knots is None:
            flight.knots = np.full((len(moments), len(knots), 3), np.nan)
            flight.locked = np.full((len(moments), len(locked)), np.nan)
        if knots.shape != flight.knots.shape[1:] or not (np.abs(knots) < _IMPOSSIBLE).all():
            continue
        for moment in wanted[index]:
            flight.knots[moment] = knots
            if flight.locked is not None and len(locked) == flight.locked.shape[1]:
                flight.locked[moment] = locked
