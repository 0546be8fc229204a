"""CPU time of whole missions whose net touches itself, and passes of thread through thread, against one that does not:
``python -m benchmarks.net_contact [--smoke]``.

How is told in benchmarks/contact_cost.py. Passes are counted in one mission of each, every millisecond
(benchmarks/thread_passes.py).
"""

from __future__ import annotations

import sys
from typing import Any

from tethernet_sim.fly import fly
from tethernet_sim.scenario import Scenario
from tethernet_sim.settings import NONE, THREADS

from .contact_cost import SYSTEMS, begin, compare, two_settings
from .figures import conclude
from .thread_passes import PassCounter


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark. Returns 0."""
    smoke, turns = begin("net_contact", __doc__.splitlines()[0], argv)
    figures: dict[str, Any] = {}
    for name in SYSTEMS:
        settings = two_settings(name, "net_contact", (NONE, THREADS), smoke)
        figures |= compare(name, settings, ("whole", "deployment", "capture"), turns)
        for contact in (NONE, THREADS):
            if smoke and name != SYSTEMS[0]:
                continue
            passes = PassCounter()
            fly(Scenario(name, seed=1), settings[contact], passes)
            figures |= {
                f"passes_deployment_{contact}_{name}": passes.deployment,
                f"passes_capture_{contact}_{name}": passes.capture,
            }
            print(
                f"{name}, net contact {contact}: passes of thread through thread: deployment {passes.deployment}, "
                f"capture {passes.capture}",
                flush=True,
            )
    conclude("net_contact", {"turns": turns} | figures)
    return 0


if __name__ == "__main__":
    sys.exit(main())
