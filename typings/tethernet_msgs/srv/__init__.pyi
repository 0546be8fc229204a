# Written by `make stubs` from the .srv files; see typings/README.md.
from typing import Any, ClassVar, TypeAlias

from geometry_msgs.msg import Point

class PlanAimingPoints_Request:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    debris_position: Point
    mu_count: int
    policy: str
    def __init__(
        self,
        *,
        debris_position: Point = ...,
        mu_count: int = ...,
        policy: str = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class PlanAimingPoints_Response:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    success: bool
    message: str
    policy: str
    aiming_points: list[Point]
    def __init__(
        self,
        *,
        success: bool = ...,
        message: str = ...,
        policy: str = ...,
        aiming_points: list[Point] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class PlanAimingPoints:
    Request: TypeAlias = PlanAimingPoints_Request
    Response: TypeAlias = PlanAimingPoints_Response
