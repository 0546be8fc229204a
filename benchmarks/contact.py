"""CPU time of whole missions whose threads touch, against knots alone: ``python -m benchmarks.contact [--smoke]``.

How is told in benchmarks/contact_cost.py.
"""

from __future__ import annotations

import sys
from typing import Any

from tethernet_sim.settings import KNOTS, THREADS

from .contact_cost import SYSTEMS, begin, compare, two_settings
from .figures import conclude


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark. Returns 0."""
    smoke, turns = begin("contact", __doc__.splitlines()[0], argv)
    figures: dict[str, Any] = {}
    for name in SYSTEMS:
        figures |= compare(name, two_settings(name, "contact", (KNOTS, THREADS), smoke), ("whole", "capture"), turns)
    conclude("contact", {"turns": turns} | figures)
    return 0


if __name__ == "__main__":
    sys.exit(main())
