# Written by `make stubs` from the .srv files; see typings/README.md.
from typing import Any, ClassVar, TypeAlias

from rcl_interfaces.msg import ListParametersResult, Parameter, ParameterDescriptor, ParameterValue, SetParametersResult

class DescribeParameters_Request:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    names: list[str]
    def __init__(
        self,
        *,
        names: list[str] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class DescribeParameters_Response:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    descriptors: list[ParameterDescriptor]
    def __init__(
        self,
        *,
        descriptors: list[ParameterDescriptor] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class DescribeParameters:
    Request: TypeAlias = DescribeParameters_Request
    Response: TypeAlias = DescribeParameters_Response


class GetParameters_Request:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    names: list[str]
    def __init__(
        self,
        *,
        names: list[str] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class GetParameters_Response:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    values: list[ParameterValue]
    def __init__(
        self,
        *,
        values: list[ParameterValue] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class GetParameters:
    Request: TypeAlias = GetParameters_Request
    Response: TypeAlias = GetParameters_Response


class ListParameters_Request:
    DEPTH_RECURSIVE: ClassVar[int]
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    prefixes: list[str]
    depth: int
    def __init__(
        self,
        *,
        prefixes: list[str] = ...,
        depth: int = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class ListParameters_Response:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    result: ListParametersResult
    def __init__(
        self,
        *,
        result: ListParametersResult = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class ListParameters:
    Request: TypeAlias = ListParameters_Request
    Response: TypeAlias = ListParameters_Response


class SetParameters_Request:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    parameters: list[Parameter]
    def __init__(
        self,
        *,
        parameters: list[Parameter] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class SetParameters_Response:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    results: list[SetParametersResult]
    def __init__(
        self,
        *,
        results: list[SetParametersResult] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class SetParameters:
    Request: TypeAlias = SetParameters_Request
    Response: TypeAlias = SetParameters_Response
