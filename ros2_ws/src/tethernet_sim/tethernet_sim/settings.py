"""The numbers of the physical model and of a scenario, with their sources.

[P] the paper, [D] derived from the paper's numbers, [A] assumed where the paper is silent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from tethernet_core.parameters import ParameterError, parameter
from tethernet_core.settings import ControlParameters
from tethernet_core.system import System
from tethernet_core.unit_norm import is_unit

_CONFIG = Path(__file__).parent / "config"


NONE, KNOTS, THREADS = "none", "knots", "threads"
"""What of the net touches the debris, or the net itself."""


@dataclass(frozen=True)
class PhysicsParameters:
    """The physical model."""

    FILE: ClassVar[Path] = _CONFIG / "physics.yaml"

    time_step_s: float = parameter(
        "Step of the semi-implicit Euler integration; what is stable follows from masses, stiffness and damping "
        "(stability.py)",
        unit="s",
        low=1e-6,
        high=1e-3,
    )
    fold_factor: float = parameter("Size of the folded net relative to the flat one [A]", low=0.001, high=1.0)
    start_distance_m: float = parameter(
        "The folded net lies so far in front of the launch point [A]", unit="m", low=0.0, high=20.0
    )
    contact: str = parameter(
        "What of the net touches the debris: knots alone, or threads too",
        choices=(KNOTS, THREADS),
    )
    knot_radius_m: float = parameter("Contact radius of a knot [A]", unit="m", low=0.0, high=0.5)
    contact_stiffness_n_m: float = parameter(
        "Compliant normal contact of a knot, with all its threads where those touch too [A]",
        unit="N/m", low=0.0, high=1e6,
    )  # fmt: skip
    contact_damping_ratio: float = parameter(
        "Damping of the normal contact of a knot, with all its threads where those touch too, of its own mass [A]",
        low=0.0,
        high=1.0,
    )
    friction_coefficient: float = parameter(
        "mu of the scaled-box friction, in each tangential direction [A]", low=0.0, high=2.0
    )
    net_contact: str = parameter(
        "What of the net touches the net: nothing, threads pass through threads; or threads", choices=(NONE, THREADS)
    )
    net_contact_distance_m: float = parameter(
        "Threads of the net touch each other when their axes are so near; more than the two radii, so that none is "
        "through in a step [A]",
        unit="m", low=1e-4, high=0.05,
    )  # fmt: skip
    net_contact_stiffness_n_m: float = parameter(
        "Compliant normal contact of two threads of the net; its damping by its stiffness is that of the threads [A]",
        unit="N/m", low=1.0, high=1e6,
    )  # fmt: skip
    joint_stiffness_n_m: float = parameter(
        "Stiffness of a docked or locked pair's joint [A]", unit="N/m", low=1.0, high=2e4
    )
    joint_damping_ratio: float = parameter(
        "Damping of a joint along its line, of the reduced mass of its pair [A]", low=0.0, high=1.0
    )
    external_coupling_rad_s: float = parameter(
        "Bandwidth of the spring and damper that draw an external MU's stand-in in the net after its odometry [A]",
        unit="rad/s", low=0.1, high=50.0,
    )  # fmt: skip


def check_together(physics: PhysicsParameters, control: ControlParameters) -> None:
    """Make sure that parameters of several kinds fit together.

    Raises:
        ParameterError: for a control period that is not a multiple of the time step.
    """
    steps = round(control.control_period_s / physics.time_step_s)
    if abs(steps * physics.time_step_s - control.control_period_s) > 1e-9 * control.control_period_s:
        more = math.ceil(control.control_period_s / physics.time_step_s)
        raise ParameterError(
            f"PhysicsParameters.time_step_s = {physics.time_step_s:g} does not divide the control period of "
            f"{control.control_period_s:g} s; allowed for instance: {control.control_period_s / more!r}"
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
    markers_every: int = parameter("Control ticks between two pictures, markers and points", low=1, high=100000)


@dataclass(frozen=True)
class ScenarioParameters:
    """What is flown. The debris' long axis is its body z axis."""

    FILE: ClassVar[Path] = _CONFIG / "scenario.yaml"

    system: str = parameter("What is flown: name of a shipped system, or path of a description")
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
        "Numbers of the units whose odometry comes from a driver outside the simulator, separated by spaces"
    )

    def __post_init__(self) -> None:
        for name, size in (("debris_position", 3), ("debris_attitude", 4), ("debris_rate", 3)):
            if len(getattr(self, name)) != size:
                raise ParameterError(
                    f"ScenarioParameters.{name} has {len(getattr(self, name))} numbers; allowed: {size}"
                )
        norm = math.sqrt(sum(q * q for q in self.debris_attitude))
        if not is_unit(norm):
            raise ParameterError(
                f"ScenarioParameters.debris_attitude has norm {norm:g}; allowed: a unit quaternion x y z w"
            )
        self._external()

    def external_units(self, system: System) -> tuple[int, ...]:
        """Numbers of the external units, sorted.

        Args:
            system: whose units they are.

        Raises:
            ParameterError: for a unit that the system does not have.
        """
        numbers = self._external()
        if not set(numbers) <= set(range(1, system.unit_count + 1)):
            allowed = f"numbers from 1 to {system.unit_count}" if system.units else "none, it has no units"
            raise ParameterError(
                f"ScenarioParameters.external_mus = {self.external_mus!r} of system {system.name}; allowed: {allowed}"
            )
        return numbers

    def _external(self) -> tuple[int, ...]:
        try:
            return tuple(sorted({int(word) for word in self.external_mus.split()}))
        except ValueError as error:
            raise ParameterError(
                f"ScenarioParameters.external_mus = {self.external_mus!r}; allowed: numbers with spaces between"
            ) from error
