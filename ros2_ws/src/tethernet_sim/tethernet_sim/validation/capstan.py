"""A thread round a cylinder: how much friction multiplies its tension (Euler, Eytelwein).

The contact is what ``physics`` chooses. The thread is a polygon. Where only its knots touch, each corner of the angle
delta multiplies the tension by (1 + mu tan(delta / 2)) / (1 - mu tan(delta / 2)), which is more than e^(mu delta);
where its threads touch, by less (:func:`polygon_ratio`). The coarser the net, the larger the difference.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from tethernet_core.parameters import load
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.validation.case import Case, Physics, Result, relative
from tethernet_sim.validation.stand import Stand, chain, net_system, threads_touch

RADIUS_M, LENGTH_M, FRICTION = 1.95, 11.1, 0.3
MESH_M, FINE_M = 1.0, 0.125
"""As the described nets have it, and so fine that the thread is nearly round."""
SLACK_SIDE_N = 2.0
DRAG_1_S, SPEED_M_S = 2.0, 0.05
SHARE = 0.005
COARSE_SHARE = {False: 0.03, True: 0.05}
"""By whether threads touch: what a polygon of six corners makes of e^(mu theta)."""


class Pulled(NamedTuple):
    """A thread that slides round the cylinder."""

    mesh_m: float
    """Length of its threads between two knots [m]."""
    ratio: float
    """Tension of the side that is drawn by that of the other [-]."""
    angle: float
    """By which the thread turns [rad]."""
    corners: int
    """Threads change their direction at so many nodes."""
    nodes: np.ndarray
    """[m], shape (N, 3)."""
    tensions: np.ndarray
    """[N], shape (T,)."""


def polygon_ratio(friction: float, angle: float, corners: int, threads: bool = False) -> float:
    """Tension ratio of a polygon, all of which slides.

    Args:
        friction: mu.
        angle: by which it turns in all [rad].
        corners: at so many knots.
        threads: its threads touch, each in the middle, and not its knots.

    With T the tension, N the normal force on each thread, lambda what a corner multiplies both by, t = tan(delta / 2)
    and x = (lambda - 1) / (lambda + 1), the balance of a knot that bears half of both contacts beside it is
    N / T = 2 t / (1 + mu t x) and x = mu N / (2 T + t N).
    """
    half = math.tan(0.5 * angle / corners)
    share = friction * half
    if threads:
        for _ in range(20):
            normal = 2.0 * half / (1.0 + friction * half * share)
            share = friction * normal / (2.0 + half * normal)
    return ((1.0 + share) / (1.0 - share)) ** corners


def pull(mesh_m: float, contacts: int, physics: Physics) -> Pulled:
    """Draw a thread of meshes round the cylinder until all of it slides.

    Args:
        mesh_m: length of a thread between two knots.
        contacts: knots that lie on the cylinder at the beginning.
        physics: parameters to replace.
    """
    thread = {"modulus_pa": 7e9 * mesh_m, "density_kg_m3": 1390.0, "radius_m": 0.0005, "damping_ratio": 0.1}
    parameters = {"time_step_s": min(1e-4, 1.6e-4 * mesh_m), "friction_coefficient": FRICTION, **physics}
    if threads_touch(parameters):  # and not the knots, which are as thick as the thread here
        parameters = {"knot_radius_m": thread["radius_m"], **parameters}
    radius = RADIUS_M + load(PhysicsParameters, parameters).knot_radius_m
    if threads_touch(parameters):  # the middle of a thread is nearer to the cylinder than its ends
        radius = max(radius, math.hypot(RADIUS_M + thread["radius_m"], 0.5 * mesh_m))
    turn = 2.0 * math.asin(0.5 * mesh_m / radius)
    angles = (np.arange(contacts) - 0.5 * (contacts - 1)) * turn + 0.5 * math.pi
    arc = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    # Straight on both sides, turned by the angle of a corner where they leave.
    tail = max(2, math.ceil(0.5 / mesh_m))
    steps = mesh_m * np.arange(1, tail + 1)[:, None]
    left, right = angles[-1] + 0.5 * turn, angles[0] - 0.5 * turn
    to_right = np.array([math.sin(right), -math.cos(right)])
    to_left = np.array([-math.sin(left), math.cos(left)])
    flat = np.concatenate([(arc[0] + steps * to_right)[::-1], arc, arc[-1] + steps * to_left])
    nodes = np.concatenate([flat, np.zeros((len(flat), 1))], axis=1)
    # All begin with the tension of the slack side.
    strain = SLACK_SIDE_N / (thread["modulus_pa"] * math.pi * thread["radius_m"] ** 2)
    rest = np.full(len(nodes) - 1, mesh_m / (1.0 + strain))
    system = net_system(
        nodes, chain(nodes), rest, thread=thread,
        shape={"kind": "cylinder", "radius_m": RADIUS_M, "length_m": LENGTH_M},
    )  # fmt: skip
    stand = Stand(system, parameters, held=(0,), drag_1_s=DRAG_1_S, debris_position=(0.0, 0.0, 0.0))
    stiffness = system.net.thread_stiffness[0]
    stand.force[:2, -1] = SLACK_SIDE_N * to_left
    expected = SLACK_SIDE_N * math.exp(FRICTION * contacts * turn)
    # Till every spring is stretched to the largest tension, and as much again for the contacts to give way.
    way = 2.0 * len(rest) * expected / stiffness
    stand.held_velocity[:2, 0] = SPEED_M_S * to_right
    ratios: list[float] = []
    stand.run(way / SPEED_M_S)
    stand.run(0.02, lambda *_: ratios.append(stand.tensions()[0] / stand.tensions()[-1]))
    spans = stand.position[:2, 1:] - stand.position[:2, :-1]
    directions = np.unwrap(np.arctan2(spans[1], spans[0]))
    turned = np.abs(np.diff(directions))
    return Pulled(
        mesh_m,
        float(np.mean(ratios)),
        float(abs(directions[-1] - directions[0])),
        int((turned > 0.2 * turn).sum()),
        stand.position.T.copy(),
        stand.tensions(),
    )


def run(physics: Physics) -> Result:
    """With the mesh of the described nets, and with a fine one."""
    coefficient = float(physics.get("friction_coefficient", FRICTION))
    coarse, fine = pull(MESH_M, 6, physics), pull(FINE_M, 48, physics)
    threads = threads_touch(physics)
    quantities = [
        relative(
            f"ratio, mesh {pulled.mesh_m:g} m, {math.degrees(pulled.angle):.1f} deg", "-", pulled.ratio,
            math.exp(coefficient * pulled.angle), share,
        )
        for pulled, share in ((fine, SHARE), (coarse, COARSE_SHARE[threads]))
    ]  # fmt: skip
    expected = polygon_ratio(coefficient, coarse.angle, coarse.corners, threads)
    name = f"the same against a polygon of {coarse.corners} corners"
    quantities.append(relative(name, "-", coarse.ratio, expected, SHARE))

    def draw(figure: Any) -> None:
        left, right = figure.subplots(1, 2)
        left.add_patch(_circle())
        for pulled, style in ((fine, "-"), (coarse, "o-")):
            left.plot(pulled.nodes[:, 0], pulled.nodes[:, 1], style, markersize=3)
        left.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="Thread round the cylinder")
        for pulled, style, name in ((fine, ".", f"mesh {FINE_M:g} m"), (coarse, "o", f"mesh {MESH_M:g} m")):
            spans = np.diff(pulled.nodes[:, :2], axis=0)
            direction = np.unwrap(np.arctan2(spans[:, 1], spans[:, 0]))
            right.plot(
                np.degrees(np.abs(direction - direction[-1])), pulled.tensions / pulled.tensions[-1], style, label=name
            )
        angle = np.linspace(0.0, fine.angle, 50)
        right.plot(np.degrees(angle), np.exp(coefficient * angle), "k:", label="e^(mu theta)")
        right.set(xlabel="angle from the slack side [deg]", ylabel="tension / slack side")
        right.set_title(f"mu = {coefficient:g}")
        right.grid(alpha=0.3)
        right.legend()

    return Result(tuple(quantities), draw)


def _circle() -> Any:
    from matplotlib.patches import Circle

    return Circle((0.0, 0.0), RADIUS_M, color="0.85")


CASE = Case("thread that slides round the cylinder", "Euler and Eytelwein, e^(mu theta)", run)
