# Written by `make stubs` from the .msg files; see typings/README.md.
from array import array
from collections.abc import Iterable
from typing import Any, ClassVar

from std_msgs.msg import Header

class CompressedImage:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    format: str
    @property
    def data(self) -> array[int]: ...
    @data.setter
    def data(self, value: Iterable[int]) -> None: ...
    def __init__(
        self,
        *,
        header: Header = ...,
        format: str = ...,
        data: Iterable[int] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
