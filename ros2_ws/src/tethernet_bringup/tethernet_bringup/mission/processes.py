"""The processes of a mission and their command lines."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Mapping

from tethernet_bringup.mission.parameters import MissionSetup
from tethernet_bringup.mission.run_folder import RunFolder
from tethernet_bringup.mission.supervisor import NodeProcess
from tethernet_bringup.nodes import ASSESSOR, PLANNER, RECORDER, SIM, VIEWER, controller
from tethernet_core.system import keep_system

_SHARED = (
    "rosidl_generator_py", "numpy.ma", "asyncio", "importlib.metadata", "uuid",
    "builtin_interfaces.msg", "diagnostic_msgs.msg", "geometry_msgs.msg", "nav_msgs.msg", "rcl_interfaces.msg",
    "rcl_interfaces.srv", "rosgraph_msgs.msg", "std_msgs.msg", "std_srvs.srv", "tf2_msgs.msg", "visualization_msgs.msg",
    "tethernet_msgs.msg", "tethernet_msgs.srv", "tethernet_control.controller", "tethernet_planner.sequencer",
    "tethernet_planner.assessment", "tethernet_ros.well_formed",
)  # fmt: skip
"""Modules that several nodes need, or this command later; none loads the middleware."""


def prepare_forking(folder: RunFolder) -> None:
    """Import and load what the nodes need, before they are forked: see :mod:`tethernet_bringup.mission.child`.

    Args:
        folder: where the run is kept; its description of the system exists.
    """
    for module in _SHARED:
        importlib.import_module(module)
    inspect.getmodule(inspect.currentframe())  # looks up the files of all modules, as the first log line of a node does
    keep_system(str(folder.system))


def mission_processes(
    setup: MissionSetup, folder: RunFolder, viewer: Mapping[str, str] | None = None
) -> tuple[NodeProcess, ...]:
    """The processes in the order in which they are started: the slowest first.

    In lock-step everybody waits for the simulator, and the simulator for everybody. It tells all units of a tick, one
    after the other: were each to interrupt it as soon as it is told, two cores would change hands some hundred times
    in a tick. So all but the two that a tick waits for last, simulator and planner, are batch processes there.

    Args:
        setup: what is flown.
        folder: where the run is kept; its parameter file exists.
        viewer: environment variables in which the viewer differs from the others; None: the mission is not shown.
    """
    common = ("--params-file", str(folder.parameters), "--disable-external-lib-logs")

    def ros(name: str, *more: str) -> tuple[str, ...]:
        return ("--ros-args", "-r", f"__node:={name}", *common, *more)

    lockstep = setup.scenario.pace == "lockstep"
    processes = []
    if setup.simulated:
        processes.append(NodeProcess(SIM, "tethernet_sim.ros.sim_node", arguments=ros(SIM)))
    processes += [
        NodeProcess(ASSESSOR, "tethernet_planner.assessor_node", batch=lockstep, arguments=ros(ASSESSOR)),
        NodeProcess(
            RECORDER, "tethernet_bringup.recorder.recorder_node", last=True, batch=lockstep, arguments=ros(RECORDER)
        ),
        NodeProcess(PLANNER, "tethernet_planner.planner_node", arguments=ros(PLANNER)),
    ]
    # In lock-step a slow machine halts the mission's time too: no reason for a controller to think its odometry lost.
    factor = 20.0 if lockstep else 1.0
    for mu in range(1, setup.system.unit_count + 1):
        name = controller(mu)
        processes.append(
            NodeProcess(
                name,
                "tethernet_control.controller_node",
                essential=False,
                batch=lockstep,
                arguments=ros(name, "-p", f"mu:={mu}", "-p", f"watchdog_wall_factor:={factor}"),
            )
        )
    if viewer is not None:
        module = "tethernet_bringup.view.viewer_node"
        processes.append(
            NodeProcess(VIEWER, module, essential=False, bystander=True, environment=viewer, arguments=ros(VIEWER))
        )
    return tuple(processes)
