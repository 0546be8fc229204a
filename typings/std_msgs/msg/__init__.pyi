# Written by `make stubs` from the .msg files; see typings/README.md.
from typing import Any, ClassVar

from builtin_interfaces.msg import Time

class ColorRGBA:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    r: float
    g: float
    b: float
    a: float
    def __init__(
        self,
        *,
        r: float = ...,
        g: float = ...,
        b: float = ...,
        a: float = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class Header:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    stamp: Time
    frame_id: str
    def __init__(
        self,
        *,
        stamp: Time = ...,
        frame_id: str = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class String:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    data: str
    def __init__(
        self,
        *,
        data: str = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
