"""Fill numba's cache: `python -m tethernet_sim.warm_up [SYSTEM ...]`, once after set-up.

One process compiles, so that the processes of a mission, and the workers of a campaign, only load.
"""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import command_start

    command_start()

import sys
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from tethernet_core.command import command
from tethernet_sim.compiling import compiling_said

if TYPE_CHECKING:
    from tethernet_core.system import System
    from tethernet_sim.settings import PhysicsParameters


_CYLINDERS = ("zenit_4mu", "zenit_8mu", "hexagonal_6mu")
"""Both ways to close a net, both engines."""


@command
def main(systems: Sequence[str] = ()) -> int:
    """Compile every kernel that systems need by flying a second of each.

    Args:
        systems: their names; none: those that need all kernels for debris that is a cylinder.

    Returns:
        0.
    """
    from tethernet_sim.fly import Settings, fly
    from tethernet_sim.scenario import Scenario

    # A trigger at once and a short capture lead through closing and contact search too.
    for name in systems or _CYLINDERS:
        began = time.perf_counter()
        # A whole line: the set-up shows the newest one while it waits.
        print(f"compiling the physics of {name}", flush=True)
        settings = Settings.load(name, mission={"trigger_distance_m": 50.0, "capture_duration_s": 1.0})
        with compiling_said(lambda _: None):  # it has just been said of which system
            fly(Scenario(name), settings)
        print(f"compiled that of {name} in {time.perf_counter() - began:.1f} s", flush=True)
    return 0


def load_kernels(say: Callable[[str], None], system: System, physics: PhysicsParameters | None = None) -> None:
    """Load every kernel that a flight needs, and compile what numba's cache has not: about a minute.

    Args:
        say: see :func:`~tethernet_sim.compiling.compiling_said`. A watcher so knows that this process is not dead but
            busy.
        system: that is flown: another net may need another engine.
        physics: with which: contact of net with net has kernels of its own; default: the system's.
    """
    import numpy as np

    from tethernet_core.parameters import load
    from tethernet_core.settings import ControlParameters
    from tethernet_sim.loads import Loads
    from tethernet_sim.settings import PhysicsParameters, ScenarioParameters
    from tethernet_sim.world import World

    with compiling_said(say):
        scenario = load(ScenarioParameters)
        world = World(
            system,
            np.array([scenario.debris_position]),
            np.array([scenario.debris_attitude]),
            np.array([scenario.debris_rate]),
            physics=load(PhysicsParameters, system.parameters.get("physics")) if physics is None else physics,
            control=load(ControlParameters, system.parameters.get("control")),
        )
        world.begin_closing(0)
        world.advance(np.zeros_like(world.state.mu_pos))
        # Loads too: in flight a busy machine compiles them for longer than a watcher waits.
        Loads(world).look(np.zeros(1, int))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
