"""The simulated world: a batch of scenarios, flown one control period at a time."""

from __future__ import annotations

import math

import numpy as np

from tethernet_core.bounds import FARTHEST_M, FASTEST_M_S, FASTEST_RAD_S
from tethernet_core.rotation import matrix, turned
from tethernet_core.settings import ControlParameters
from tethernet_core.system import System
from tethernet_sim import towing
from tethernet_sim.debris import body_rate, inertia_tensor
from tethernet_sim.engine import Commands, Engine, engine_for
from tethernet_sim.memory import check_memory
from tethernet_sim.model import Model, build_model
from tethernet_sim.settings import PhysicsParameters, check_together
from tethernet_sim.stability import check_stable
from tethernet_sim.state import ATTITUDE, CHASER, DEBRIS, MOMENTUM, POSITION, VELOCITY, State, initial_state


def divergence(elapsed_s: float) -> str:
    """What is said of a simulation that has broken down so long after launch [s]."""
    return f"the simulation diverged {elapsed_s:.2f} s after launch"


class World:
    """B scenarios of one system, from the folded net to the closed mouth.

    Not modelled: orbital dynamics (the motion lasts a minute), attitude of the MUs, contact of units with net, of
    threads with the chaser and, but as an option, of net with net, friction of units with each other and of anything
    with the chaser.
    """

    def __init__(
        self,
        system: System,
        debris_position: np.ndarray,
        debris_attitude: np.ndarray,
        debris_rate: np.ndarray,
        physics: PhysicsParameters,
        control: ControlParameters,
    ):
        """Args:
            system: the hardware.
            debris_position: centre of mass [m], shape (B, 3), frame launch.
            debris_attitude: unit quaternions x y z w, body to launch, shape (B, 4).
            debris_rate: angular rate in the body frame [rad/s], shape (B, 3).
            physics: time step, contact, joints, how the net is folded.
            control: gives the control period.

        Raises:
            ParameterError: for a time step that is unstable, parameters that do not fit together, or more scenarios
                than fit into the memory.
        """
        check_together(physics, control)
        check_stable(system, physics)
        self.system = system
        self.physics = physics
        mu_count = system.unit_count
        self.model: Model = build_model(system, physics)
        check_memory(self.model, len(debris_position), system.name)
        self.steps = round(control.control_period_s / physics.time_step_s)
        self.state: State = initial_state(self.model, system, physics, debris_position, debris_attitude, debris_rate)
        batch = self.state.batch
        self.external = np.zeros((batch, mu_count), bool)
        """MUs whose stand-ins follow a target instead of flying on thrust, shape (B, M)."""
        self.target_pos = np.zeros((batch, mu_count, 3))
        """Measured positions of external MUs at the beginning of the next period [m], shape (B, M, 3)."""
        self.target_vel = np.zeros((batch, mu_count, 3))
        """Their measured velocities [m/s], shape (B, M, 3)."""
        self.chaser_force = np.zeros((batch, 3))
        """Thrust of the chaser that tows [N], shape (B, 3), frame launch."""
        self.engine: Engine = engine_for(self.model)
        self._least_inertia = min(
            self.model.numbers.chaser_inertia, float(np.linalg.eigvalsh(inertia_tensor(self.model.debris))[0])
        )
        self._knot_weight = self.model.arrays.knot_mass / self.model.arrays.knot_mass.sum()

    def advance(self, thrust: np.ndarray, chosen: np.ndarray | None = None) -> None:
        """Fly one control period under constant thrust.

        Args:
            thrust: per scenario and MU [N], shape (B, M, 3).
            chosen: indices of the scenarios to fly; None for all.
        """
        commands = Commands(thrust, self.external, self.target_pos, self.target_vel, self.chaser_force)
        self.engine.advance(self.state, commands, self.steps * self.model.numbers.time_step, chosen)

    def tow(self, index: int, tension: float) -> None:
        """Let the chaser of one scenario thrust straight away from the debris, or brake, in the next period, so that
        the main tether becomes taut without a jerk and then carries the tension; see :mod:`~tethernet_sim.towing`.

        Args:
            index: of the scenario.
            tension: that the main tether is to carry [N]; 0: no thrust.
        """
        numbers, arrays, bodies = self.model.numbers, self.model.arrays, self.state.bodies[index]
        towed = float(arrays.knot_mass.sum() + arrays.mu_mass.sum()) + self.model.debris.mass
        away = bodies[CHASER, POSITION] - bodies[DEBRIS, POSITION]
        away /= max(float(np.linalg.norm(away)), 1e-9)
        rate = float((bodies[CHASER, VELOCITY] - bodies[DEBRIS, VELOCITY]) @ away)
        force = towing.thrust(tension, self.tether(index)[1], rate, numbers.chaser_mass, towed)
        self.chaser_force[index] = force * away

    def diverged(self, chosen: np.ndarray) -> np.ndarray:
        """Which simulations have broken down: a number is not finite, or no body can be so far off or so fast.

        Args:
            chosen: indices of the scenarios, shape (C,).

        Returns:
            One bool each, shape (C,).
        """
        s = self.state
        bodies = s.bodies[chosen]
        far = (s.knot_pos[chosen], s.mu_pos[chosen], bodies[:, :, POSITION])
        fast = (s.knot_vel[chosen], s.mu_vel[chosen], bodies[:, :, VELOCITY])
        sound = np.isfinite(bodies[:, :, ATTITUDE]).all(axis=(1, 2))
        for values, limit in (
            *((values, FARTHEST_M) for values in far),
            *((values, FASTEST_M_S) for values in fast),
            (bodies[:, :, MOMENTUM], FASTEST_RAD_S * self._least_inertia),
        ):
            sound &= (np.abs(values) <= limit).all(axis=(1, 2))  # NaN is not
        return ~sound

    def launch(self, index: int) -> None:
        """Eject the net of one scenario; nothing where units fly it out."""
        launch, nodes = self.system.launch, self.system.net.node_count
        for particle, velocity in zip(launch.particles, launch.velocities, strict=True):
            if particle < nodes:
                self.state.knot_vel[index, :, particle] = velocity
            else:
                self.state.mu_vel[index, particle - nodes] = velocity

    def begin_closing(self, index: int) -> None:
        """Lock the main tether, start the winches, enable docking in one scenario."""
        self.engine.begin_closing(self.state, index)

    def net_center(self, index: int) -> tuple[float, float, float]:
        """Centre of mass of the knots [m], frame launch: what the trigger looks at."""
        x, y, z = self.state.knot_pos[index] @ self._knot_weight
        return float(x), float(y), float(z)

    def net_center_all(self, index: int) -> tuple[float, float, float]:
        """Centre of mass of knots and MUs [m], frame launch."""
        arrays = self.model.arrays
        moment = self.state.knot_pos[index] @ arrays.knot_mass + arrays.mu_mass @ self.state.mu_pos[index]
        x, y, z = moment / (arrays.knot_mass.sum() + arrays.mu_mass.sum())
        return float(x), float(y), float(z)

    def debris_position(self, index: int) -> tuple[float, float, float]:
        """The debris' centre of mass [m], frame launch."""
        x, y, z = self.state.bodies[index, DEBRIS, POSITION]
        return float(x), float(y), float(z)

    def knots_as_published(self, index: int) -> np.ndarray:
        """Knot positions as /net/state carries them [m], float32, shape (N, 3)."""
        return np.ascontiguousarray(self.state.knot_pos[index].T, dtype=np.float32)

    def knot_velocities_as_published(self, index: int) -> np.ndarray:
        """Knot velocities as /net/state carries them [m/s], float32, shape (N, 3)."""
        return np.ascontiguousarray(self.state.knot_vel[index].T, dtype=np.float32)

    def mus_as_published(self, index: int) -> np.ndarray:
        """MU positions as /net/state carries them [m], float32, shape (M, 3)."""
        return self.state.mu_pos[index].astype(np.float32)

    def mu_velocities_as_published(self, index: int) -> np.ndarray:
        """MU velocities as /net/state carries them [m/s], float32, shape (M, 3)."""
        return self.state.mu_vel[index].astype(np.float32)

    def body_motion(self, index: int, body: int) -> tuple[list[float], list[float], list[float], list[float]]:
        """Motion of DEBRIS or CHASER as its odometry carries it: position [m], attitude (quaternion x y z w, body to
        launch), velocity [m/s] and angular rate [rad/s] in its own frame, as nav_msgs defines it.
        """
        # Single numbers: arrays of three take six times as long, and this is asked at every control tick.
        row = self.state.bodies[index, body].tolist()
        x, y, z, w = row[ATTITUDE]
        to_body = (-x, -y, -z, w)
        momentum = list(turned(to_body, row[MOMENTUM]))
        if body == DEBRIS:
            rate = body_rate(self.model.debris, np.array(momentum)).tolist()
        else:
            rate = [value / self.model.numbers.chaser_inertia for value in momentum]
        return row[POSITION], row[ATTITUDE], list(turned(to_body, row[VELOCITY])), rate

    def tether(self, index: int) -> tuple[float, float]:
        """Length of the main tether [m] (paid out; the locked length once closing has begun) and its tension [N],
        damping left out. Both are 0 without a tether.
        """
        s = self.state
        anchor = self.tether_anchor(index)
        center = self.model.numbers.center_node
        if center < 0:
            return 0.0, 0.0
        distance = math.dist(anchor, s.knot_pos[index, :, center].tolist())
        if not s.closing[index]:
            return distance, 0.0
        locked = float(s.tether_length[index])
        return locked, self.model.numbers.tether_stiffness * max(distance - locked, 0.0)

    def tether_anchor(self, index: int) -> tuple[float, float, float]:
        """The launch point on the chaser [m], frame launch."""
        chaser = self.state.bodies[index, CHASER]
        axis = matrix(chaser[ATTITUDE])[:, 2]  # the anchor lies on the body's z axis
        x, y, z = (chaser[POSITION] + self.model.numbers.tether_anchor * axis).tolist()
        return (x, y, z)
