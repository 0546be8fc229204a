"""The threads of a net, whatever their representation: which kernel serves is settled when a step is compiled."""

from __future__ import annotations

from typing import Any

from numba.core import types
from numba.extending import overload

from tethernet_sim.kernels import edge_list, grid
from tethernet_sim.kernels.options import INLINED, KERNEL

_KERNELS = {grid.Grid: grid, edge_list.EdgeList: edge_list}


def workspace(net: Any, width: int) -> Any:
    """Work space for the threads of one scenario; compiled code only."""
    raise NotImplementedError


def apply(net: Any, work: Any, pos: Any, vel: Any, kick: Any, time_step: float) -> None:
    """Change the nodes' velocities by one step under the net's threads; compiled code only.

    Args:
        net: grid.Grid or edge_list.EdgeList.
        work: its work space.
        pos: of the nodes [m], (3, width).
        vel: of the nodes [m/s], (3, width); updated.
        kick: velocity per force in one step [s/kg], (N,).
        time_step: [s].
    """
    raise NotImplementedError


def _module_of(net: Any) -> Any:
    kind: Any = net  # instance_class is what named tuples have; numba's annotations do not know it
    return _KERNELS.get(kind.instance_class) if isinstance(net, types.BaseNamedTuple) else None


@overload(workspace, jit_options=KERNEL)
def _workspace(net, width):
    module = _module_of(net)
    if module is None:
        return None
    serve = module.workspace

    def implementation(net, width):
        return serve(net, width)

    return implementation


@overload(apply, jit_options=INLINED)
def _apply(net, work, pos, vel, kick, time_step):
    module = _module_of(net)
    if module is None:
        return None
    serve = module.apply

    def implementation(net, work, pos, vel, kick, time_step):
        serve(net, work, pos, vel, kick, time_step)

    return implementation
