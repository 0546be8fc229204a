"""Entries of /diagnostics."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from tethernet_ros.conversions import set_stamp

OK, WARN, ERROR, STALE = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR, DiagnosticStatus.STALE


def entry(name: str, level: bytes, message: str, **values: object) -> DiagnosticStatus:
    """One entry.

    Args:
        name: of what is diagnosed.
        level: OK, WARN, ERROR or STALE.
        message: the state in a few words.
        values: shown as a table.
    """
    return DiagnosticStatus(
        name=name,
        level=level,
        message=message,
        values=[KeyValue(key=key, value=_text(value)) for key, value in values.items()],
    )


def array(stamp_ns: int, entries: list[DiagnosticStatus]) -> DiagnosticArray:
    """All entries of one time [ns]."""
    message = DiagnosticArray(status=entries)
    set_stamp(message.header.stamp, stamp_ns)
    return message


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
