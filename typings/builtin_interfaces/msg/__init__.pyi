# Written by `make stubs` from the .msg files; see typings/README.md.
from typing import Any, ClassVar

class Duration:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    sec: int
    nanosec: int
    def __init__(
        self,
        *,
        sec: int = ...,
        nanosec: int = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class Time:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    sec: int
    nanosec: int
    def __init__(
        self,
        *,
        sec: int = ...,
        nanosec: int = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
