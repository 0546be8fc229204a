"""The hexagonal net that hangs at its six corners: how it rests, and its first swing.

The set-up is the first of the rod networks of Huang et al., Applied Mechanics Reviews, doi 10.1115/1.4069025. The
reference numbers are not printed there: they are recomputations of that set-up, with springs that only pull and steps
so small that they no longer matter. The implicit step of 0.01 s that is published with it damps the swing: its lowest
point is -0.6605 m.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tethernet_core.system import load_system
from tethernet_sim.validation.case import Case, Physics, Quantity, Result, relative
from tethernet_sim.validation.stand import BASE, Stand

GRAVITY_M_S2 = 50.0
DRAG_1_S = 0.1
REST_DRAG_1_S = 6.0
"""Drag on the way to rest, which does not change it [1/s]."""
CENTER_M, LOWEST_M = -0.43501, -0.43579
LEAST_N, LARGEST_N, REACTION_N = 0.6308, 54.112, 565.487
SWING = {0.05: -0.0625, 0.10: -0.2494, 0.15: -0.5582, 0.20: -0.7311, 0.25: -0.373, 0.30: -0.0555}
"""Height of the centre [m] by time [s]."""
FIRST_MINIMUM_S, FIRST_MINIMUM_M = 0.1904, -0.7638
PUBLISHED_STEP_MINIMUM_M = -0.6605
SWING_SHARE = 0.005
REST_STEP_S, SWING_STEP_S = 4e-4, 2e-5
_REST_AFTER_S = 8.0


def _stand(physics: Physics, step_s: float, drag_1_s: float) -> Stand:
    system = load_system(BASE)
    return Stand(
        system,
        {"time_step_s": step_s, **physics},
        held=system.launch.particles,
        gravity=(0.0, 0.0, -GRAVITY_M_S2),
        drag_1_s=drag_1_s,
    )


def rest(physics: Physics) -> Result:
    """Let it come to rest."""
    stand = _stand(physics, REST_STEP_S, REST_DRAG_1_S)
    stand.run(_REST_AFTER_S)
    net, tension = stand.system.net, stand.tensions()
    weight = GRAVITY_M_S2 * stand.masses[stand.held].sum()
    reaction = weight - stand.pulls()[2, stand.held].sum()
    nodes, threads = stand.position.T.copy(), net.threads
    fastest = float(np.abs(stand.velocity).max())
    # Half of the last digit that is known of each.
    quantities = (
        Quantity("centre z", "m", float(nodes[net.center_node, 2]), CENTER_M, 5e-6),
        Quantity("lowest node z", "m", float(nodes[:, 2].min()), LOWEST_M, 5e-6),
        Quantity("smallest tension", "N", float(tension.min()), LEAST_N, 5e-5),
        Quantity("largest tension", "N", float(tension.max()), LARGEST_N, 5e-4),
        Quantity("vertical reaction", "N", float(reaction), REACTION_N, 5e-4),
        Quantity("slack springs", "-", float((tension <= 0.0).sum()), 0.0),
        Quantity("fastest node", "m/s", fastest, 0.0, 1e-6),
    )

    def draw(figure: Any) -> None:
        from mpl_toolkits.mplot3d.art3d import Line3DCollection  # type: ignore[import-untyped]  # has none

        panel = figure.add_subplot(projection="3d")
        lines = Line3DCollection(nodes[threads], cmap="viridis", linewidths=1.2)
        lines.set_array(tension)
        panel.add_collection3d(lines)
        panel.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-0.5, 0.05), xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
        panel.set_box_aspect((2, 2, 0.8), zoom=1.15)
        panel.view_init(elev=22, azim=-55)
        figure.colorbar(lines, ax=panel, label="tension [N]", shrink=0.6, pad=0.1)
        figure.suptitle("At rest, held at its six corners")

    return Result(quantities, draw)


def swing(physics: Physics) -> Result:
    """Let it go from the flat net."""
    stand = _stand(physics, SWING_STEP_S, DRAG_1_S)
    center = stand.system.net.center_node
    times, heights = [0.0], [0.0]

    def look(time_s: float, state: Any) -> None:
        times.append(time_s)
        heights.append(float(state.knot_pos[0, 2, center]))

    stand.run(max(SWING) + SWING_STEP_S, look)
    z, t = np.array(heights), np.array(times)
    lowest = int(z.argmin())
    at = {time_s: float(np.interp(time_s, t, z)) for time_s in SWING}
    depth = abs(FIRST_MINIMUM_M)
    quantities = (
        relative("first minimum z", "m", z[lowest], FIRST_MINIMUM_M, SWING_SHARE),
        relative("time of it", "s", t[lowest], FIRST_MINIMUM_S, SWING_SHARE),
        # On the steep parts a share of the height itself would ask for more than the digits that are known.
        *(
            Quantity(f"z at {time_s:.2f} s", "m", at[time_s], expected, SWING_SHARE * depth)
            for time_s, expected in SWING.items()
        ),
    )

    def draw(figure: Any) -> None:
        panel = figure.add_subplot()
        panel.plot(t, z, label="engine")
        panel.plot(list(SWING), list(SWING.values()), "o", label="recomputed set-up")
        panel.plot(FIRST_MINIMUM_S, FIRST_MINIMUM_M, "v", label="its first minimum")
        panel.axhline(PUBLISHED_STEP_MINIMUM_M, color="grey", linestyle=":", label="minimum with an implicit 0.01 s")
        panel.set(xlabel="time [s]", ylabel="z of the centre [m]", title="First swing of the net that was flat")
        panel.grid(alpha=0.3)
        panel.legend()

    return Result(quantities, draw)


_SOURCE = "recomputed set-up of Huang et al., doi 10.1115/1.4069025, rod network case 1"
REST = Case("hexagonal net at rest under its weight, corners held", _SOURCE, rest)
SWING_CASE = Case("first swing of the same net", _SOURCE, swing)
