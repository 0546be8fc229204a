"""The numbers of the physical model and of a scenario, with their sources.

[P] the paper, [D] derived from the paper's numbers, [A] assumed where the paper is silent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from tethernet_core.layout import DESIGNS, KNOT_ROWS
from tethernet_core.parameters import ParameterError, parameter
from tethernet_core.settings import ControlParameters, MissionParameters

_CONFIG = Path(__file__).parent / "config"

MESH_M = 1.0
"""Length of a mesh that the closing plan's reach and the mouth are made for [m]."""


@dataclass(frozen=True)
class PhysicsParameters:
    """The physical model."""

    FILE: ClassVar[Path] = _CONFIG / "physics.yaml"

    time_step_s: float = parameter(
        "Step of the semi-implicit Euler integration; what is stable follows from masses, stiffness and damping "
        "(stability.py): 1.003e-4 s with the default values",
        unit="s",
        low=1e-6,
        high=1e-3,
    )
    mesh_m: float = parameter(
        "Length of a thread between two knots [D: 23 x 23 knots, 22 m side]; 1 only, because closing plan and mouth "
        "count on a net of 22 m",
        unit="m",
        low=0.1,
        high=10.0,
    )
    thread_radius_m: float = parameter("Radius of a thread [A: usual for Technora nets]", unit="m", low=1e-5, high=1e-2)
    thread_modulus_pa: float = parameter(
        "Young's modulus of Technora [A: datasheet value]", unit="Pa", low=1e6, high=1e12
    )
    thread_density_kg_m3: float = parameter(
        "Density of Technora [A: datasheet value]", unit="kg/m^3", low=100.0, high=1e4
    )
    thread_damping_ratio: float = parameter(
        "zeta in c = 2 zeta sqrt(k m) [A: usual in this literature]", low=0.0, high=1.0
    )
    fold_factor: float = parameter("Size of the folded net relative to the flat one [A]", low=0.001, high=1.0)
    start_distance_m: float = parameter(
        "The folded net lies so far in front of the launch point [A]", unit="m", low=0.0, high=20.0
    )
    mu_mass_kg: float = parameter("Mass of an MU [P]", unit="kg", low=0.1, high=100.0)
    mu_radius_m: float = parameter(
        "Contact radius of an MU [A: half the long side of the 0.1 x 0.1 x 0.2 m box]", unit="m", low=0.0, high=1.0
    )
    knot_radius_m: float = parameter("Contact radius of a knot [A]", unit="m", low=0.0, high=0.5)
    debris_mass_kg: float = parameter("Mass of the Zenit-2 second stage [P]", unit="kg", low=1.0, high=1e6)
    debris_radius_m: float = parameter(
        "Radius of the debris' cylinder, L_c of the paper [P]", unit="m", low=0.1, high=10.0
    )
    debris_length_m: float = parameter(
        "Length of the debris' cylinder [D: such a cylinder's surface is 159.9 m^2, the paper's number]",
        unit="m",
        low=0.1,
        high=50.0,
    )
    chaser_mass_kg: float = parameter("Mass of the chaser [P]", unit="kg", low=1.0, high=1e6)
    chaser_side_m: float = parameter("Side of the chaser's cube [P]", unit="m", low=0.1, high=20.0)
    tether_stiffness_n_m: float = parameter("Stiffness of the locked main tether [A]", unit="N/m", low=0.0, high=1e5)
    tether_damping_n_s_m: float = parameter(
        "Damping of the locked main tether [A: near critical for the central knot, the lightest body it moves]",
        unit="N s/m",
        low=0.0,
        high=10.0,
    )
    contact_stiffness_n_m: float = parameter("Compliant normal contact [A]", unit="N/m", low=0.0, high=1e5)
    contact_damping_ratio: float = parameter(
        "Damping of the normal contact, of each point's own mass [A]", low=0.0, high=1.0
    )
    friction_coefficient: float = parameter(
        "mu of the scaled-box friction, in each tangential direction [A]", low=0.0, high=2.0
    )
    winch_speed_m_s: float = parameter(
        "4 MUs: each winch takes its threads in so fast, as long as they pull less than it can; 0: it holds them [A]",
        unit="m/s",
        low=0.0,
        high=10.0,
    )
    winch_tension_n: float = parameter(
        "4 MUs: largest tension of a closing thread; at more the winch slips [A]", unit="N", low=0.0, high=500.0
    )
    winch_stiffness_n_m: float = parameter(
        "4 MUs: stiffness of the closing thread of one side [A: E A / 22 m of the net's thread is 2500]",
        unit="N/m",
        low=1.0,
        high=2e4,
    )
    joint_stiffness_n_m: float = parameter(
        "Stiffness of a docked or locked pair's joint [A]", unit="N/m", low=1.0, high=2e4
    )
    joint_damping_ratio: float = parameter(
        "Damping of a joint along its line, of the reduced mass of its pair [A]", low=0.0, high=1.0
    )
    joint_draw_in_m_s: float = parameter(
        "8 MUs: a docked pair is drawn together so fast, to length 0 [P: 0; A: by a motor, at this speed]; 0: it stays",
        unit="m/s",
        low=0.0,
        high=10.0,
    )
    joint_pull_n: float = parameter(
        "8 MUs: the motor that draws a docked pair together pulls no harder; where it would have to, it stands still "
        "and holds [A]",
        unit="N", low=0.0, high=500.0,
    )  # fmt: skip
    external_coupling_rad_s: float = parameter(
        "Bandwidth of the spring and damper that draw an external MU's stand-in in the net after its odometry [A]",
        unit="rad/s", low=0.1, high=50.0,
    )  # fmt: skip

    def __post_init__(self) -> None:
        if self.mesh_m != MESH_M:
            raise ParameterError(
                f"PhysicsParameters.mesh_m = {self.mesh_m:g}: the closing plan and the mouth count on a net of "
                f"{KNOT_ROWS - 1} m, {KNOT_ROWS} knots {MESH_M:g} m apart; allowed: {MESH_M:g} m"
            )
        from tethernet_sim.stability import largest_step_of  # numpy behind it takes longer than all else here

        largest = largest_step_of(self)
        if self.time_step_s > largest:
            raise ParameterError(
                f"PhysicsParameters.time_step_s = {self.time_step_s:g}: unstable with these masses, stiffnesses and "
                f"dampings; allowed: at most {math.floor(largest * 1e9) * 1e-9:.5g} s, a whole part of the control "
                "period"
            )

    @property
    def thread_stiffness_n_m(self) -> float:
        """k = E A / l of one mesh-long thread [N/m]; the MU's threads have the same k and c [A]."""
        return self.thread_modulus_pa * self._thread_area_m2 / self.mesh_m

    @property
    def thread_mass_kg(self) -> float:
        """Mass of one mesh-long thread [kg]."""
        return self.thread_density_kg_m3 * self._thread_area_m2 * self.mesh_m

    @property
    def thread_damping_n_s_m(self) -> float:
        """c = 2 zeta sqrt(k m_thread) [N s/m]."""
        return 2.0 * self.thread_damping_ratio * math.sqrt(self.thread_stiffness_n_m * self.thread_mass_kg)

    @property
    def _thread_area_m2(self) -> float:
        return math.pi * self.thread_radius_m**2


def check_together(physics: PhysicsParameters, mission: MissionParameters, control: ControlParameters) -> None:
    """Make sure that parameters of several kinds fit together.

    Raises:
        ParameterError: for a control period that is not a multiple of the time step, or a debris of another size than
            the closing is planned for.
    """
    steps = round(control.control_period_s / physics.time_step_s)
    if abs(steps * physics.time_step_s - control.control_period_s) > 1e-9 * control.control_period_s:
        more = math.ceil(control.control_period_s / physics.time_step_s)
        raise ParameterError(
            f"PhysicsParameters.time_step_s = {physics.time_step_s:g} does not divide the control period of "
            f"{control.control_period_s:g} s; allowed for instance: {control.control_period_s / more!r}"
        )
    for body, target in (("debris_radius_m", "target_radius_m"), ("debris_length_m", "target_length_m")):
        if getattr(physics, body) != getattr(mission, target):
            raise ParameterError(
                f"PhysicsParameters.{body} = {getattr(physics, body):g}, but the closing is planned for "
                f"MissionParameters.{target} = {getattr(mission, target):g}; allowed: the same value for both"
            )


@dataclass(frozen=True)
class SimNodeParameters:
    """How the simulator's node runs."""

    FILE: ClassVar[Path] = _CONFIG / "sim_node.yaml"

    answer_timeout_s: float = parameter(
        "Lock-step: wall time to wait for the answers to a control tick; who has not answered by then counts as lost "
        "and is not waited for until it answers again",
        unit="s", low=0.01, high=600.0,
    )  # fmt: skip
    sim_status_every: int = parameter("Control ticks between two status messages", low=1, high=100000)
    markers_every: int = parameter("Control ticks between two pictures for RViz", low=1, high=100000)


@dataclass(frozen=True)
class ScenarioParameters:
    """What is flown. The debris' long axis is its body z axis."""

    FILE: ClassVar[Path] = _CONFIG / "scenario.yaml"

    mu_count: int = parameter("Maneuverable units: 4 (winches close the net) or 8 (the MUs dock)", low=4, high=8)
    debris_position: tuple[float, ...] = parameter(
        "Debris' centre of mass, x y z, frame launch", unit="m", low=-1000.0, high=1000.0
    )
    debris_attitude: tuple[float, ...] = parameter(
        "Unit quaternion x y z w, debris body to launch; default: long axis along (1, 1, 0), the net's diagonal [A]",
        low=-1.0,
        high=1.0,
    )
    debris_rate: tuple[float, ...] = parameter(
        "Debris' angular rate x y z, body frame", unit="rad/s", low=-10.0, high=10.0
    )
    seed: int = parameter("Seed of the sensor noise", low=0, high=2**63 - 1)
    pace: str = parameter(
        "realtime: 20 Hz wall clock; lockstep: as fast as all commands arrive", choices=("realtime", "lockstep")
    )
    external_mus: str = parameter(
        "Numbers of the MUs whose odometry comes from a driver outside the simulator, separated by spaces"
    )

    def __post_init__(self) -> None:
        if self.mu_count not in DESIGNS:
            raise ParameterError(f"ScenarioParameters.mu_count = {self.mu_count}: no such design; allowed: 4 or 8")
        for name, size in (("debris_position", 3), ("debris_attitude", 4), ("debris_rate", 3)):
            if len(getattr(self, name)) != size:
                raise ParameterError(
                    f"ScenarioParameters.{name} has {len(getattr(self, name))} numbers; allowed: {size}"
                )
        norm = math.sqrt(sum(q * q for q in self.debris_attitude))
        if abs(norm - 1.0) > 1e-6:
            raise ParameterError(
                f"ScenarioParameters.debris_attitude has norm {norm:g}; allowed: a unit quaternion x y z w"
            )
        _ = self.external

    @property
    def external(self) -> tuple[int, ...]:
        """The external MUs' numbers, sorted."""
        try:
            numbers = {int(word) for word in self.external_mus.split()}
        except ValueError:
            numbers = {-1}
        if not numbers <= set(range(1, self.mu_count + 1)):
            raise ParameterError(
                f"ScenarioParameters.external_mus = {self.external_mus!r}; "
                f"allowed: numbers from 1 to {self.mu_count} separated by spaces"
            )
        return tuple(sorted(numbers))
