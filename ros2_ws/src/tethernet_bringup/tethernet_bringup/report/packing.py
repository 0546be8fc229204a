"""Numbers over time as text of few bytes, for a page that unpacks them in the browser.

Every column is rounded to 16 bits, stored as the difference from the row before, low bytes before high bytes, and
deflated: neighbouring moments of a flight differ by little. ``viewer/tracks.js`` is the other direction.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np

LEVELS = 65534
"""Numbers from the smallest to the largest value; the one after the last stands for a missing value."""
MISSING = 65535
_BEYOND = 1e30
"""Nothing that was measured is so large."""
_EFFORT = 6  # 9 takes six times as long for 7 % less


def pack(rows: np.ndarray, *, period: int = 1, finest: float = 0.0) -> dict[str, Any]:
    """Pack rows of numbers.

    Args:
        rows: over time, shape (F, K); what is not finite, or beyond 1e30, counts as missing.
        period: columns repeat with this period (3: x y z x y z ...); each of a period has its own smallest value, and
            all have one step.
        finest: the step from one number to the next is at least this, in units of the rows; larger only where the
            values are too far apart for 16 bits.

    Returns:
        Ready for JSON.
    """
    rows = np.asarray(rows, float)
    count, columns = rows.shape
    grouped = rows.reshape(count, columns // period, period)
    known = np.abs(grouped) < _BEYOND
    low = np.where(known, grouped, np.inf).min(axis=(0, 1), initial=np.inf)
    high = np.where(known, grouped, -np.inf).max(axis=(0, 1), initial=-np.inf)
    low, high = np.where(np.isfinite(low), low, 0.0), np.where(np.isfinite(high), high, 0.0)
    step = max(float((high - low).max(initial=0.0)) / LEVELS, finest) or 1.0
    numbers = np.where(known, np.round((np.where(known, grouped, low) - low) / step), MISSING)
    words = numbers.astype(np.uint16).reshape(count, columns)
    changes = np.diff(words, axis=0, prepend=np.zeros((1, columns), np.uint16))  # modulo 2^16
    planes = np.concatenate([(changes & 0xFF).ravel(), (changes >> 8).ravel()]).astype(np.uint8)
    return {
        "rows": count,
        "columns": columns,
        "low": [float(value) for value in low],
        "step": step,
        "data": base64.b64encode(zlib.compress(planes.tobytes(), _EFFORT)).decode("ascii"),
    }


def unpack(packed: dict[str, Any]) -> np.ndarray:
    """The reverse of :func:`pack`, NaN where a value is missing; shape (F, K)."""
    count, columns = packed["rows"], packed["columns"]
    planes = np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), np.uint8).reshape(2, count, columns)
    changes = planes[0].astype(np.uint16) | (planes[1].astype(np.uint16) << 8)
    words = np.cumsum(changes, axis=0, dtype=np.uint16)
    low = np.resize(packed["low"], columns)
    return np.where(words == MISSING, np.nan, low + words * packed["step"])


def whole_numbers(values: np.ndarray) -> list[int]:
    """Small whole numbers as JSON holds them, row by row."""
    return [int(value) for value in np.asarray(values).ravel()]


def rounded(values: Sequence[float] | np.ndarray, digits: int = 4) -> list[float]:
    """Numbers with few digits, row by row."""
    return [round(float(value), digits) for value in np.asarray(values).ravel()]
