"""An MU whose odometry fails for a while: the controller bridges the true gap with the thrust that truly acted."""

import math

import numpy as np
import pytest

from tethernet_control import law
from tethernet_control.controller import MuController
from tethernet_core.mission import Mission, arm, launch
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters
from tethernet_core.system import load_system
from tethernet_sim.lockstep import CommandBuffer

CONTROL = load(ControlParameters)
PERIOD, T = CONTROL.period_ns, CONTROL.control_period_s
GAPS_S = (0.3, 0.35, 0.5, 1.0, 2.0, 5.0)
UNIT = load_system("zenit_8mu").units[0]


class Flight:
    """A free MU with exact integration of what the simulator's book of commands lets act, and its controller."""

    def __init__(self, seed=1):
        self.random = np.random.default_rng(seed)
        self.controller = MuController(1, CONTROL, UNIT)
        self.controller.take_mission(launch(arm(Mission(8), (0.0, 0.0, -50.0), "nominal"), 0))
        self.controller.aim((-12.0, -12.0, -50.0), "nominal")
        self.book = CommandBuffer(CONTROL, UNIT)
        self.place, self.speed = np.array([-0.55, -0.55, -1.5]), np.zeros(3)
        self.tick, self.fuel = 0, 0.0

    def fly(self, ticks, measured=True, pull=(0.0, 0.0, 0.0)):
        for _ in range(ticks):
            now = self.tick * PERIOD
            if measured:
                sample = (
                    self.place + self.random.normal(0.0, CONTROL.position_sigma_m, 3),
                    self.speed + self.random.normal(0.0, CONTROL.velocity_sigma_m_s, 3),
                )
                thrust = self.controller.on_odometry(now, *(values.tolist() for values in sample))
                self.book.take(now, thrust, now)
            acting = self.book.thrust(now)
            self.fuel += law.fuel_used(acting, T, UNIT.specific_impulse_s, CONTROL.standard_gravity_m_s2)
            acceleration = (np.array(acting) + pull) / UNIT.mass_kg
            self.place = self.place + T * self.speed + 0.5 * T * T * acceleration
            self.speed = self.speed + T * acceleration
            self.tick += 1

    def error(self):
        """Of the estimate at the newest sample, before the truth moved on."""
        return math.dist(self.controller._state[:3], self.place)


@pytest.mark.parametrize("gap_s", GAPS_S)
@pytest.mark.parametrize("begin", [10, 300])
def test_a_gap_is_bridged_by_the_thrust_that_acted(gap_s, begin):
    """From tick 10 the MU is still being got up to speed at 2.5 N: what is held of that, and for how long, matters."""
    flight = Flight()
    flight.fly(begin)
    assert begin > 10 or max(map(abs, flight.controller._thrust)) > 2.0
    flight.fly(round(gap_s / T) - 1, measured=False)
    place = flight.place
    flight.fly(1)
    statistics = flight.controller.statistics
    assert statistics.deadline_misses == round(gap_s / T) - 1
    assert statistics.outliers == 0, "a good sample after a gap is no outlier"
    assert math.dist(flight.controller._state[:3], place) < 5.0 * CONTROL.position_sigma_m
    flight.fly(40)
    assert statistics.outliers == 0
    # What the controller has on account is what acted, but for the period that has just begun.
    last = law.fuel_used(
        flight.book.thrust((flight.tick - 1) * PERIOD), T, UNIT.specific_impulse_s, CONTROL.standard_gravity_m_s2
    )
    assert statistics.fuel_kg == pytest.approx(flight.fuel - last, rel=1e-9)


@pytest.mark.parametrize("gap_s", GAPS_S)
def test_a_gap_on_the_line_costs_no_thrust(gap_s):
    whole, broken = Flight(), Flight()
    whole.fly(300)
    broken.fly(300)
    whole.fly(round(gap_s / T) + 20)
    broken.fly(round(gap_s / T) - 1, measured=False)
    broken.fly(21)
    assert broken.controller.statistics.saturated == whole.controller.statistics.saturated
    assert broken.fuel == pytest.approx(whole.fuel, abs=0.001)


def test_the_estimate_admits_how_little_a_long_gap_leaves_known():
    """A steady pull that begins in the gap: unknown to the filter, and within what its covariance allows."""
    flight = Flight()
    flight.fly(300)
    settled = flight.controller.statistics.position_sigma_m
    flight.fly(59, measured=False, pull=(0.1, 0.0, -0.1))
    flight.fly(1, pull=(0.1, 0.0, -0.1))
    assert flight.controller.statistics.outliers == 0
    assert flight.controller.statistics.position_sigma_m > 1.5 * settled
