"""What the command has loaded by the time that it forks the nodes: threads are not forked."""

import subprocess
import sys

from tethernet_core.quiet_start import ONE_THREAD

CODE = """
import os, sys
os.environ.update(dict.fromkeys({threads!r}, "1"))
from pathlib import Path
from tethernet_bringup.mission import arguments, conductor, supervisor
from tethernet_bringup.mission.parameters import resolve
from tethernet_bringup.mission.processes import mission_processes, prepare_forking
from tethernet_bringup.mission.run_folder import make_run_folder
setup = resolve(arguments.parse(["--mus", "8", "--output", {folder!r}]))
folder = make_run_folder({folder!r}, setup.system.name, 1)
folder.system.write_text(setup.system.to_yaml())
prepare_forking(folder)
print(len(os.listdir("/proc/self/task")), *sorted({{"rclpy", "numba", "scipy"}} & set(sys.modules)))
from tethernet_core.system import load_system
print(load_system(str(folder.system)) is load_system(str(folder.system)), load_system(str(folder.system)).digest)
print(setup.system.digest)
"""


def test_the_command_has_one_thread_and_no_middleware_when_it_forks_the_nodes(tmp_path):
    code = CODE.format(threads=ONE_THREAD, folder=str(tmp_path))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120.0, check=True)
    loaded, kept, digest = done.stdout.splitlines()
    assert loaded == "1"
    assert kept == f"True {digest}", "the nodes find the description that the command has read"
