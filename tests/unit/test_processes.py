"""Which processes a mission has, and how they share the cores."""

import pytest

from tethernet_bringup.mission import arguments
from tethernet_bringup.mission.parameters import resolve
from tethernet_bringup.mission.processes import mission_processes
from tethernet_bringup.mission.run_folder import make_run_folder
from tethernet_bringup.nodes import PLANNER, SIM


@pytest.mark.parametrize("pace", ["lockstep", "realtime"])
def test_in_lockstep_nobody_interrupts_those_whom_a_tick_waits_for_last(pace, tmp_path):
    setup = resolve(arguments.parse(["--mus", "8", "--pace", pace, "--output", str(tmp_path)]))
    processes = mission_processes(setup, make_run_folder(tmp_path, setup.system.name, 1))
    assert len(processes) == 12
    assert {node.name for node in processes if not node.batch} == (
        {SIM, PLANNER} if pace == "lockstep" else {node.name for node in processes}
    )
