"""Our engine against an independent model of the same net, built from MuJoCo's parts: ``benchmarks/mujoco_net.py``.

Two correct codes with the same equations, step and integrator differ by rounding alone while the motion is regular. A
slack net is chaotic: from about 1.4 s on the differences grow, to millimetres for the MUs, which the control holds, and
to decimetres for the net's centre. So the bounds are tight for the first second and those of two correct codes
afterwards.
"""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is the peer; requirements/bench.txt has it")

from benchmarks.deployment import DURATION_S, Deployment, fly_engine, fly_mujoco

TIME_STEP_S = 1e-4
REGULAR_TICKS = 20
"""Control ticks of the first second."""
ROUNDING_M = 1e-12
"""The coordinates reach 12 m, where a double's last bit is 2e-15 m; measured: 3.4e-15 m."""
MU_BOUND_M = 0.010
CENTER_BOUND_M = 0.3


def deploy(mu_count: int, duration_s: float) -> tuple[Deployment, Deployment]:
    ours = fly_engine(mu_count, duration_s, TIME_STEP_S)
    peer = fly_mujoco(mu_count, duration_s, time_step_s=TIME_STEP_S, integrator="Euler", threads="callback")
    assert ours.contacts == 0, "the peer has no debris to touch"
    assert len(ours.mu_pos) == len(peer.mu_pos) == round(duration_s / 0.05)
    return ours, peer


def first_second(flown: Deployment) -> Deployment:
    return Deployment(flown.mu_pos[:REGULAR_TICKS], flown.net_center[:REGULAR_TICKS], 0.0, 1.0, 0)


def check(mu_count: int, duration_s: float) -> None:
    ours, peer = deploy(mu_count, duration_s)
    assert np.ptp(ours.mu_pos, axis=0).max() > 1.0, "nothing flew"
    mu, center = first_second(ours).errors(first_second(peer))
    assert mu < ROUNDING_M
    assert center < ROUNDING_M
    mu, center = ours.errors(peer)
    assert mu < MU_BOUND_M
    assert center < CENTER_BOUND_M


@pytest.mark.parametrize("mu_count", [4, 8])
def test_a_deployment_agrees_to_rounding_at_first_and_then_within_millimetres(mu_count):
    check(mu_count, 4.0)


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("mu_count", [4, 8])
def test_a_whole_deployment_agrees_within_ten_millimetres(mu_count):
    check(mu_count, DURATION_S)


@pytest.mark.parametrize("time_step_s", [0.0, -1e-4, 3e-3, 0.1, float("nan")])
def test_the_peer_refuses_a_step_that_does_not_divide_the_control_period(time_step_s):
    with pytest.raises(ValueError, match="divides the control period"):
        fly_mujoco(duration_s=0.05, time_step_s=time_step_s, integrator="Euler", threads="actuator")


def test_a_diverging_peer_is_no_reference():
    with pytest.raises(ArithmeticError, match="diverged"):
        fly_mujoco(duration_s=5.0, time_step_s=1e-3, integrator="Euler", threads="actuator")
