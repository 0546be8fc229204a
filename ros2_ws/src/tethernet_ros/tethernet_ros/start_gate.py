"""Where a node waits, with all imported that it needs, until it may join the graph.

Whoever starts the nodes of a mission first makes sure that no other mission is in the domain. Meanwhile they load what
they need, which takes them longer than that. A node that was started by itself does not wait.
"""

from __future__ import annotations

import os
import time

_END_S = 6.0
_gate: int | None = None


def close_gate(descriptor: int) -> None:
    """Let :func:`pass_gate` wait in this process.

    Args:
        descriptor: of a pipe: one byte lets one process in, its end none.
    """
    global _gate
    _gate = descriptor


def pass_gate() -> None:
    """Wait until this process may join the graph; where nobody is left to let it in, it ends here, with time for what
    watches over it to see to that in order.
    """
    global _gate
    if _gate is None:
        return
    descriptor, _gate = _gate, None
    let_in = os.read(descriptor, 1)
    os.close(descriptor)
    if not let_in:
        time.sleep(_END_S)
        os._exit(0)
