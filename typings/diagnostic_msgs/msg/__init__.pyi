# Written by `make stubs` from the .msg files; see typings/README.md.
from typing import Any, ClassVar

from std_msgs.msg import Header

class DiagnosticArray:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    status: list[DiagnosticStatus]
    def __init__(
        self,
        *,
        header: Header = ...,
        status: list[DiagnosticStatus] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class DiagnosticStatus:
    OK: ClassVar[bytes]
    WARN: ClassVar[bytes]
    ERROR: ClassVar[bytes]
    STALE: ClassVar[bytes]
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    level: bytes
    name: str
    message: str
    hardware_id: str
    values: list[KeyValue]
    def __init__(
        self,
        *,
        level: bytes = ...,
        name: str = ...,
        message: str = ...,
        hardware_id: str = ...,
        values: list[KeyValue] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class KeyValue:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    key: str
    value: str
    def __init__(
        self,
        *,
        key: str = ...,
        value: str = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
