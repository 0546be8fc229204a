# Written by `make stubs` from the .msg files; see typings/README.md.
from array import array
from collections.abc import Iterable
from typing import Any, ClassVar

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from std_msgs.msg import Header

class CaptureAssessment:
    PROGRESS: ClassVar[int]
    TRIGGER: ClassVar[int]
    FINAL: ClassVar[int]
    HELD: ClassVar[int]
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    stage: int
    hull_valid: bool
    cqi: float
    hull_volume: float
    hull_area: float
    cqi_all_valid: bool
    cqi_all: float
    mcqi_valid: bool
    mcqi: float
    enclosed_valid: bool
    enclosed: bool
    load_share_valid: bool
    max_load_share: float
    contact_force_valid: bool
    max_contact_force: float
    distance_valid: bool
    mouth_area: float
    net_debris_distance: float
    locked_pairs: int
    max_locked_pairs: int
    required_locked_pairs: int
    source: str
    captured: bool
    verdict: str
    held_valid: bool
    held: bool
    hold_verdict: str
    prediction_valid: bool
    predicted_cqi: float
    predicted_locked_pairs: float
    predicted_capture_probability: float
    predictor: str
    cqi_error_valid: bool
    cqi_error: float
    locked_pairs_error_valid: bool
    locked_pairs_error: float
    def __init__(
        self,
        *,
        header: Header = ...,
        stage: int = ...,
        hull_valid: bool = ...,
        cqi: float = ...,
        hull_volume: float = ...,
        hull_area: float = ...,
        cqi_all_valid: bool = ...,
        cqi_all: float = ...,
        mcqi_valid: bool = ...,
        mcqi: float = ...,
        enclosed_valid: bool = ...,
        enclosed: bool = ...,
        load_share_valid: bool = ...,
        max_load_share: float = ...,
        contact_force_valid: bool = ...,
        max_contact_force: float = ...,
        distance_valid: bool = ...,
        mouth_area: float = ...,
        net_debris_distance: float = ...,
        locked_pairs: int = ...,
        max_locked_pairs: int = ...,
        required_locked_pairs: int = ...,
        source: str = ...,
        captured: bool = ...,
        verdict: str = ...,
        held_valid: bool = ...,
        held: bool = ...,
        hold_verdict: str = ...,
        prediction_valid: bool = ...,
        predicted_cqi: float = ...,
        predicted_locked_pairs: float = ...,
        predicted_capture_probability: float = ...,
        predictor: str = ...,
        cqi_error_valid: bool = ...,
        cqi_error: float = ...,
        locked_pairs_error_valid: bool = ...,
        locked_pairs_error: float = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class MissionState:
    WAITING: ClassVar[int]
    ARMED: ClassVar[int]
    DEPLOYING: ClassVar[int]
    CLOSING: ClassVar[int]
    COMPLETE: ClassVar[int]
    MISSED: ClassVar[int]
    ABORTED: ClassVar[int]
    HOLDING: ClassVar[int]
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    phase: int
    sequence: int
    mission_id: int
    confirmed: bool
    mu_count: int
    policy: str
    launch_time: Time
    closing_time: Time
    end_time: Time
    debris_position: Point
    closing_points: list[Point]
    points_time: Time
    closing_duration: float
    docked_times: list[Time]
    hold_duration: float
    tow: float
    hold_time: Time
    hold_end_time: Time
    reason: str
    def __init__(
        self,
        *,
        header: Header = ...,
        phase: int = ...,
        sequence: int = ...,
        mission_id: int = ...,
        confirmed: bool = ...,
        mu_count: int = ...,
        policy: str = ...,
        launch_time: Time = ...,
        closing_time: Time = ...,
        end_time: Time = ...,
        debris_position: Point = ...,
        closing_points: list[Point] = ...,
        points_time: Time = ...,
        closing_duration: float = ...,
        docked_times: list[Time] = ...,
        hold_duration: float = ...,
        tow: float = ...,
        hold_time: Time = ...,
        hold_end_time: Time = ...,
        reason: str = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class MuStatus:
    IDLE: ClassVar[int]
    DEPLOYING: ClassVar[int]
    CLOSING: ClassVar[int]
    OFF: ClassVar[int]
    NO_ODOMETRY: ClassVar[int]
    NO_PLANNER: ClassVar[int]
    EMPTY: ClassVar[int]
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    mu: int
    mode: int
    mission_sequence: int
    aiming_point: Point
    aiming_source: str
    desired_position: Point
    tracking_error: float
    max_tracking_error: float
    fuel: float
    fuel_at_trigger: float
    propellant: float
    commands: int
    saturated: int
    rejected_odometry: int
    rejected_messages: int
    clock_jumps: int
    refused_states: int
    deadline_misses: int
    outliers: int
    position_sigma: float
    velocity_sigma: float
    def __init__(
        self,
        *,
        header: Header = ...,
        mu: int = ...,
        mode: int = ...,
        mission_sequence: int = ...,
        aiming_point: Point = ...,
        aiming_source: str = ...,
        desired_position: Point = ...,
        tracking_error: float = ...,
        max_tracking_error: float = ...,
        fuel: float = ...,
        fuel_at_trigger: float = ...,
        propellant: float = ...,
        commands: int = ...,
        saturated: int = ...,
        rejected_odometry: int = ...,
        rejected_messages: int = ...,
        clock_jumps: int = ...,
        refused_states: int = ...,
        deadline_misses: int = ...,
        outliers: int = ...,
        position_sigma: float = ...,
        velocity_sigma: float = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class NetState:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    center_of_mass: Point
    center_of_mass_all_valid: bool
    center_of_mass_all: Point
    rows: int
    columns: int
    @property
    def knot_positions(self) -> array[float]: ...
    @knot_positions.setter
    def knot_positions(self, value: Iterable[float]) -> None: ...
    @property
    def knot_velocities(self) -> array[float]: ...
    @knot_velocities.setter
    def knot_velocities(self, value: Iterable[float]) -> None: ...
    @property
    def mu_positions(self) -> array[float]: ...
    @mu_positions.setter
    def mu_positions(self, value: Iterable[float]) -> None: ...
    @property
    def mu_velocities(self) -> array[float]: ...
    @mu_velocities.setter
    def mu_velocities(self, value: Iterable[float]) -> None: ...
    locked: list[bool]
    tether_length: float
    tether_tension: float
    load_share_valid: bool
    load_share: float
    max_load_share: float
    contact_force_valid: bool
    contact_force: float
    max_contact_force: float
    def __init__(
        self,
        *,
        header: Header = ...,
        center_of_mass: Point = ...,
        center_of_mass_all_valid: bool = ...,
        center_of_mass_all: Point = ...,
        rows: int = ...,
        columns: int = ...,
        knot_positions: Iterable[float] = ...,
        knot_velocities: Iterable[float] = ...,
        mu_positions: Iterable[float] = ...,
        mu_velocities: Iterable[float] = ...,
        locked: list[bool] = ...,
        tether_length: float = ...,
        tether_tension: float = ...,
        load_share_valid: bool = ...,
        load_share: float = ...,
        max_load_share: float = ...,
        contact_force_valid: bool = ...,
        contact_force: float = ...,
        max_contact_force: float = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class SimStatus:
    SLOT_TYPES: ClassVar[tuple[Any, ...]]
    header: Header
    tick: int
    finished: bool
    fault: str
    real_time_factor: float
    @property
    def late_commands(self) -> array[int]: ...
    @late_commands.setter
    def late_commands(self, value: Iterable[int]) -> None: ...
    @property
    def rejected_commands(self) -> array[int]: ...
    @rejected_commands.setter
    def rejected_commands(self, value: Iterable[int]) -> None: ...
    @property
    def clipped_commands(self) -> array[int]: ...
    @clipped_commands.setter
    def clipped_commands(self, value: Iterable[int]) -> None: ...
    @property
    def zeroed_commands(self) -> array[int]: ...
    @zeroed_commands.setter
    def zeroed_commands(self, value: Iterable[int]) -> None: ...
    @property
    def lost_controllers(self) -> array[int]: ...
    @lost_controllers.setter
    def lost_controllers(self, value: Iterable[int]) -> None: ...
    latency_p50: float
    latency_p99: float
    latency_max: float
    @property
    def applied_fuel(self) -> array[float]: ...
    @applied_fuel.setter
    def applied_fuel(self, value: Iterable[float]) -> None: ...
    def __init__(
        self,
        *,
        header: Header = ...,
        tick: int = ...,
        finished: bool = ...,
        fault: str = ...,
        real_time_factor: float = ...,
        late_commands: Iterable[int] = ...,
        rejected_commands: Iterable[int] = ...,
        clipped_commands: Iterable[int] = ...,
        zeroed_commands: Iterable[int] = ...,
        lost_controllers: Iterable[int] = ...,
        latency_p50: float = ...,
        latency_p99: float = ...,
        latency_max: float = ...,
        applied_fuel: Iterable[float] = ...,
    ) -> None: ...
    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...
