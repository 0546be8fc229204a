"""What processes used of the processor, as the benchmarks see it."""

from __future__ import annotations

import subprocess
import sys
import time

from benchmarks.processes import CpuSampler

WORK = """
import subprocess, sys, time
code = "import time; end = time.process_time() + 0.5\\nwhile time.process_time() < end: pass"
subprocess.run([sys.executable, "-c", code, "__node:=worker"], check=True)
print("worked", flush=True)
sys.stdin.readline()
"""


def test_what_a_process_used_is_not_forgotten_when_it_ends():
    with subprocess.Popen([sys.executable, "-c", WORK], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as command:
        with CpuSampler(command.pid, period_s=0.02) as sampler:
            assert command.stdout.readline() == b"worked\n"
            time.sleep(0.2)  # some looks at a family without the worker
            used = sampler.between(sampler.began, time.monotonic())
        command.communicate(b"\n")
    assert command.returncode == 0
    assert used["worker"] > 0.3
    assert set(used) >= {"command", "worker"}
