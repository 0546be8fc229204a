"""The simulator loads the kernels of the flight that its command line names."""

from __future__ import annotations

import pytest

from tethernet_core.system import load_system
from tethernet_sim.ros import kernel_loading
from tethernet_sim.settings import NONE, THREADS


@pytest.mark.parametrize("way", ["word", "file of all nodes", "file of its own"])
def test_contact_of_net_with_net_is_compiled_before_the_node_is_ready(monkeypatch, tmp_path, way):
    """In flight it would be compiled for longer than a watcher waits."""
    asked = []
    monkeypatch.setattr(kernel_loading, "load_kernels", lambda _say, *of: asked.append(of))
    file = tmp_path / "given.yaml"
    node = "/**" if "all" in way else "sim"
    file.write_text(
        f"{node}:\n  ros__parameters:\n    system: zenit_4mu\n    net_contact: {THREADS}\n", encoding="utf-8"
    )
    words = ["-p", "system:=zenit_4mu", "-p", f"net_contact:={THREADS}"]
    kernel_loading.KernelLoading(
        ["sim", "--ros-args", *(words if way == "word" else ["--params-file", str(file)])]
    ).wait()
    kernel_loading.KernelLoading(["sim", "--ros-args", "-p", "system:=zenit_4mu"]).wait()
    assert [(system.digest, physics.net_contact) for system, physics in asked] == [
        (load_system("zenit_4mu").digest, contact) for contact in (THREADS, NONE)
    ]
