"""The threads of a net, whatever their representation: which kernel serves is settled when a step is compiled."""

from __future__ import annotations

from typing import Any

from tethernet_sim.kernels import dispatch, edge_list, grid
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


for _function, _options in ((workspace, KERNEL), (apply, INLINED)):
    dispatch.serve_by_module(_function, _KERNELS, _options)
