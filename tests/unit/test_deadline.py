"""A process ends in time whatever hangs in it, and keeps its own exit status where nothing does."""

import subprocess
import sys

import pytest

HANGING = "ctypes.PyDLL(None).sleep(60)"  # holds the interpreter's lock: nothing in Python can run meanwhile


@pytest.mark.parametrize(
    ("inside", "wanted"),
    [(HANGING, 7), ("pass", 3), ("raise SystemExit(4)", 4)],
    ids=["hangs", "in time", "ends by itself"],
)
def test_exit_status(inside, wanted):
    code = f"import ctypes\nfrom tethernet_core.deadline import Deadline\nwith Deadline(0.3, 7):\n    {inside}\n"
    done = subprocess.run([sys.executable, "-c", f"{code}raise SystemExit(3)"], timeout=30, check=False)
    assert done.returncode == wanted


def test_a_deadline_that_was_met_leaves_nothing_behind():
    code = """if True:
        import time
        from tethernet_core.deadline import Deadline
        for _ in range(100):
            with Deadline(0.2, 7):
                pass
        time.sleep(0.5)
        raise SystemExit(3)
    """
    assert subprocess.run([sys.executable, "-c", code], timeout=30, check=False).returncode == 3
