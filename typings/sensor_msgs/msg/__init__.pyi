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


class PointCloud2:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    height: int
    width: int
    fields: list[PointField]
    is_bigendian: bool
    point_step: int
    row_step: int
    @property
    def data(self) -> array[int]: ...
    @data.setter
    def data(self, value: Iterable[int]) -> None: ...
    is_dense: bool
    def __init__(
        self,
        *,
        header: Header = ...,
        height: int = ...,
        width: int = ...,
        fields: list[PointField] = ...,
        is_bigendian: bool = ...,
        point_step: int = ...,
        row_step: int = ...,
        data: Iterable[int] = ...,
        is_dense: bool = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class PointField:
    INT8: ClassVar[int]
    UINT8: ClassVar[int]
    INT16: ClassVar[int]
    UINT16: ClassVar[int]
    INT32: ClassVar[int]
    UINT32: ClassVar[int]
    FLOAT32: ClassVar[int]
    FLOAT64: ClassVar[int]
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    name: str
    offset: int
    datatype: int
    count: int
    def __init__(
        self,
        *,
        name: str = ...,
        offset: int = ...,
        datatype: int = ...,
        count: int = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
