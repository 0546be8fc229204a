# Written by `make stubs` from the .msg files; see typings/README.md.
from collections.abc import Iterable
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from std_msgs.msg import Header

class Point:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    x: float
    y: float
    z: float
    def __init__(
        self,
        *,
        x: float = ...,
        y: float = ...,
        z: float = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class Pose:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    position: Point
    orientation: Quaternion
    def __init__(
        self,
        *,
        position: Point = ...,
        orientation: Quaternion = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class PoseWithCovariance:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    pose: Pose
    @property
    def covariance(self) -> npt.NDArray[np.float64]: ...
    @covariance.setter
    def covariance(self, value: npt.NDArray[np.float64] | Iterable[float]) -> None: ...
    def __init__(
        self,
        *,
        pose: Pose = ...,
        covariance: npt.NDArray[np.float64] | Iterable[float] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class Quaternion:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    x: float
    y: float
    z: float
    w: float
    def __init__(
        self,
        *,
        x: float = ...,
        y: float = ...,
        z: float = ...,
        w: float = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class Transform:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    translation: Vector3
    rotation: Quaternion
    def __init__(
        self,
        *,
        translation: Vector3 = ...,
        rotation: Quaternion = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class TransformStamped:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    child_frame_id: str
    transform: Transform
    def __init__(
        self,
        *,
        header: Header = ...,
        child_frame_id: str = ...,
        transform: Transform = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class Twist:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    linear: Vector3
    angular: Vector3
    def __init__(
        self,
        *,
        linear: Vector3 = ...,
        angular: Vector3 = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class TwistWithCovariance:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    twist: Twist
    @property
    def covariance(self) -> npt.NDArray[np.float64]: ...
    @covariance.setter
    def covariance(self, value: npt.NDArray[np.float64] | Iterable[float]) -> None: ...
    def __init__(
        self,
        *,
        twist: Twist = ...,
        covariance: npt.NDArray[np.float64] | Iterable[float] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class Vector3:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    x: float
    y: float
    z: float
    def __init__(
        self,
        *,
        x: float = ...,
        y: float = ...,
        z: float = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class Wrench:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    force: Vector3
    torque: Vector3
    def __init__(
        self,
        *,
        force: Vector3 = ...,
        torque: Vector3 = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class WrenchStamped:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    wrench: Wrench
    def __init__(
        self,
        *,
        header: Header = ...,
        wrench: Wrench = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
