# Written by `make stubs` from the .srv files; see typings/README.md.
from typing import Any, ClassVar, TypeAlias

class Trigger_Request:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    def __init__(self) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class Trigger_Response:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    success: bool
    message: str
    def __init__(
        self,
        *,
        success: bool = ...,
        message: str = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class Trigger:
    Request: TypeAlias = Trigger_Request
    Response: TypeAlias = Trigger_Response
