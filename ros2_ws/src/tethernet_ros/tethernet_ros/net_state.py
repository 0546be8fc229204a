"""A net's state, read straight from the bytes of the message: see :mod:`.serialized` for why.

Two nodes read it at every control tick. A net of 529 knots takes 25 microseconds to become a message in Python, which
copies all its numbers; here they stay where they are.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from rclpy.serialization import serialize_message

from tethernet_core.bounds import FARTHEST_M, FASTEST_M_S
from tethernet_core.system import System
from tethernet_msgs.msg import NetState
from tethernet_ros.conversions import Vector
from tethernet_ros.field_checks import one_of
from tethernet_ros.serialized import check_bounds, check_frame, decoded
from tethernet_ros.template import Layout
from tethernet_ros.topics import FRAME
from tethernet_ros.well_formed import MessageError, check_stamp

_STAMP = struct.Struct("<iI")
_POINT = struct.Struct("<3d")
_PAIR = struct.Struct("<2d")
_ARRAYS = {
    "knot_positions": FARTHEST_M, "knot_velocities": FASTEST_M_S, "mu_positions": FARTHEST_M,
    "mu_velocities": FASTEST_M_S,
}  # fmt: skip
"""The limit of each array's numbers [m], [m/s]."""
_FLAGS = ("center_of_mass_all_valid", "load_share_valid", "contact_force_valid")


class NetMeasurement(NamedTuple):
    """What a net state says; all in frame launch, unit 1 and node 1 of the net first."""

    stamp_ns: int
    """[ns]."""
    center: Vector
    """Centre of mass of the knots [m]."""
    center_all: Vector | None
    """Centre of mass of knots and units [m]; None where it is not known."""
    knot_positions: npt.NDArray[np.float32]
    """[m], float32, shape (N, 3)."""
    knot_velocities: npt.NDArray[np.float32]
    """[m/s], likewise."""
    mu_positions: npt.NDArray[np.float32]
    """[m], float32, shape (M, 3)."""
    mu_velocities: npt.NDArray[np.float32]
    """[m/s], likewise."""
    locked: list[bool]
    """One for each closing pair, in their order round the mouth."""
    max_load_share: float
    """Largest tension of any thread over its strength since launch [-]; NaN where it is not known."""
    max_contact_force: float
    """Largest force of contact on the debris since launch [N]; likewise."""


def blank_net_state(system: System) -> NetState:
    """The message that tells of a system's net, all numbers zero.

    Args:
        system: whose net it is.
    """
    net, mus = system.net, system.unit_count
    rows, columns = (0, 0) if net.grid is None else (net.grid.rows, net.grid.columns)
    message = NetState(rows=rows, columns=columns)
    message.header.frame_id = FRAME
    message.knot_positions, message.knot_velocities = [0.0] * (3 * net.node_count), [0.0] * (3 * net.node_count)
    message.mu_positions, message.mu_velocities = [0.0] * (3 * mus), [0.0] * (3 * mus)
    message.locked = [False] * system.closing.max_locked_pairs
    return message


class NetStateReader:
    """Reads serialized net states of one system."""

    def __init__(self, system: System):
        """Args:
        system: whose net it must be.
        """
        self._system = system
        self._blank = blank = blank_net_state(system)
        self._example: bytes = serialize_message(blank)
        layout = Layout(blank)
        at = self._at = layout.offsets
        self._counts = {name: len(getattr(blank, name)) for name in _ARRAYS}
        self._flags = [at[name] for name in _FLAGS]
        locked = at["locked[0]"] if blank.locked else 0
        self._locked = slice(locked, locked + len(blank.locked))
        # What must be as in the example: byte order, frame, lengths of arrays; rows and columns lie side by side.
        self._shape = [slice(0, 2), *layout.shape, slice(at["rows"], at["rows"] + 4)]

    def read(self, data: bytes) -> NetMeasurement:
        """What a message says.

        Raises:
            MessageError: for another frame or net, a stamp that is no time, numbers that are not finite or cannot be,
                or bytes that are no net state.
        """
        if not self._fits(data):
            data = self._fitted(data)
        at = self._at
        center, center_all = (
            _POINT.unpack_from(data, at[name]) for name in ("center_of_mass.x", "center_of_mass_all.x")
        )
        check_bounds(center, FARTHEST_M, "center_of_mass", "m")
        check_bounds(center_all, FARTHEST_M, "center_of_mass_all", "m")
        check_bounds((*_PAIR.unpack_from(data, at["tether_length"]), 0.0), FARTHEST_M, "tether", "m and N")
        share, most = _PAIR.unpack_from(data, at["load_share"])
        force, hardest = _PAIR.unpack_from(data, at["contact_force"])
        for name, value in (
            ("load_share", share), ("max_load_share", most), ("contact_force", force), ("max_contact_force", hardest),
        ):  # fmt: skip
            if not 0.0 <= value < math.inf:  # also catches NaN
                raise MessageError(f"{name} is {value:g}; allowed: finite, 0 and more")
        center_known, share_known, force_known = (data[flag] != 0 for flag in self._flags)
        with np.errstate(over="ignore", invalid="ignore"):  # such numbers are refused, and nobody warned of them
            knots, knot_velocities, mus, mu_velocities = (
                self._rows(data, name, limit) for name, limit in _ARRAYS.items()
            )
        return NetMeasurement(
            check_stamp(*_STAMP.unpack_from(data, at["header.stamp.sec"])),
            center,
            center_all if center_known else None,
            knots,
            knot_velocities,
            mus,
            mu_velocities,
            [value != 0 for value in data[self._locked]],
            most if share_known else math.nan,
            hardest if force_known else math.nan,
        )

    def _fits(self, data: bytes) -> bool:
        """Whether the bytes are a message of the system's net, in frame launch, as this machine writes it."""
        example = self._example
        return (
            len(data) == len(example)
            and all(data[part] == example[part] for part in self._shape)
            and max(data[flag] for flag in self._flags) <= 1
            and max(data[self._locked], default=0) <= 1
        )

    def _fitted(self, data: bytes) -> bytes:
        """The same message as this machine writes it.

        Raises:
            MessageError: for another frame or net, or bytes that are no net state.
        """
        message, blank = decoded(data, NetState), self._blank
        check_frame(message.header.frame_id, NetState)
        if (message.rows, message.columns) != (blank.rows, blank.columns):
            raise MessageError(
                f"{message.rows} rows and {message.columns} columns; allowed: {blank.rows} and {blank.columns}, "
                f"as system {self._system.name} has"
            )
        one_of("the number of locked", len(message.locked), (len(blank.locked),))
        for name, count in self._counts.items():
            if len(getattr(message, name)) != count:
                raise MessageError(f"{name} has {len(getattr(message, name))} numbers; allowed: {count}")
        fitted: bytes = serialize_message(message)
        return fitted

    def _rows(self, data: bytes, name: str, limit: float) -> npt.NDArray[np.float32]:
        """A flat array of the message as x y z rows, shape (N, 3).

        Raises:
            MessageError: for numbers that are not finite, or beyond the limit.
        """
        count = self._counts[name]
        flat = np.frombuffer(data, np.float32, count, self._at[f"{name}[0]"]) if count else np.zeros(0, np.float32)
        # The usual case in one pass: no number is larger than the root of the sum of all squares. NaN and what has
        # overflowed are below nothing.
        if not float(np.dot(flat, flat)) < 0.5 * limit * limit:
            largest = np.abs(flat).max(initial=0.0)  # NaN where one is
            if not largest <= limit:  # also catches NaN
                raise MessageError(f"{name} reaches {largest:g}; allowed: finite, within {limit:g}")
        return flat.reshape(-1, 3)
