"""A passive net that is ejected and opens: the four figures by which the literature compares such nets.

After Shan, Guo and Gill, Acta Astronautica 132 (2017), doi 10.1016/j.actaastro.2017.01.001: the largest area of the
net's mouth, the time from ejection to it (deployment time), the way of the net until then (travelling distance), and
how long the mouth stays wide open (effective period). Open means here: at least OPEN_SHARE of the largest area.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tethernet_core.capture_quality import mouth_area
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters
from tethernet_core.system import load_system
from tethernet_sim.settings import PhysicsParameters
from tethernet_sim.validation.case import Case, Physics, Quantity, Result, relative
from tethernet_sim.world import World

SYSTEM = "passive_5m"
OPEN_SHARE = 0.8
DURATION_S = 4.0
DEBRIS_M = -400.0
"""Where the debris is: out of the way."""


def run(physics: Physics) -> Result:
    """Eject the net, and let it fly past its largest mouth."""
    system = load_system(SYSTEM)
    own = {**system.parameters.get("physics", {}), **physics}
    control = load(ControlParameters, dict(system.parameters.get("control", {})))
    world = World(
        system, np.array([[0.0, 0.0, DEBRIS_M]]), np.array([[0.0, 0.0, 0.0, 1.0]]), np.zeros((1, 3)),
        load(PhysicsParameters, own), control,
    )  # fmt: skip
    world.launch(0)
    masses = system.net.node_masses
    speed = float(world.state.knot_vel[0, 2] @ masses) / float(masses.sum())
    begin = world.net_center(0)[2]
    thrust = np.zeros((1, 0, 3))
    t, area, way = [], [], []

    def look(time_s: float) -> None:
        t.append(time_s)
        area.append(mouth_area(world.mus_as_published(0), system, world.state.knot_pos[0].T))
        way.append(begin - world.net_center(0)[2])

    look(0.0)
    for tick in range(round(DURATION_S / control.control_period_s)):
        world.advance(thrust)
        look((tick + 1) * control.control_period_s)
    times, areas, ways = np.array(t), np.array(area), np.array(way)
    # The first opening: till the mouth is smaller than the open share for the first time after its top.
    wide = areas >= OPEN_SHARE * areas.max()
    top = int(areas.argmax())
    first = top - int(np.argmin(wide[: top + 1][::-1])) + 1
    after = np.flatnonzero(~wide[top:])
    last = top + int(after[0]) - 1 if len(after) else len(wide) - 1
    flat = mouth_area(np.zeros((0, 3)), system, system.net.nodes)
    quantities = (
        Quantity("largest mouth area", "m^2", float(areas.max())),
        Quantity("the same by the flat net's", "-", float(areas.max()) / flat, 1.0, 0.05),
        Quantity("deployment time", "s", float(times[top])),
        relative("travelling distance", "m", ways[top], -speed * times[top], 1e-6),
        Quantity(f"effective period, above {OPEN_SHARE:.0%}", "s", float(times[last] - times[first])),
    )

    def draw(figure: Any) -> None:
        panel = figure.add_subplot()
        panel.plot(times, areas)
        panel.axhline(flat, color="0.5", linestyle=":", label="flat net")
        panel.axhline(OPEN_SHARE * areas.max(), color="C1", linestyle="--", label=f"{OPEN_SHARE:.0%} of the largest")
        panel.axvspan(times[first], times[last], alpha=0.15, label="effective period")
        panel.plot(times[top], areas[top], "v", label="deployed")
        panel.set(xlabel="time since ejection [s]", ylabel="mouth area [m^2]", title=f"{system.name} without a debris")
        panel.grid(alpha=0.3)
        panel.legend()

    return Result(quantities, draw)


CASE = Case("ejected net: the literature's four figures", "conservation of momentum; else reported", run)
