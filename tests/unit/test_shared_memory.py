import fcntl
import subprocess
import sys
import textwrap
import time

import pytest

from tethernet_bringup.mission import shared_memory

DEADLINE_S = 20.0


def until(condition, what):
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.01)


def test_only_segments_that_nobody_holds_are_removed(tmp_path, monkeypatch):
    monkeypatch.setattr(shared_memory, "FOLDER", tmp_path)
    ours, held, theirs = (f"fastrtps_{letter * 16}" for letter in "abc")
    for name in (ours, f"{ours}_el", f"sem.{ours}_mutex", held, theirs, f"{theirs}_el", "fastrtps_port7001"):
        (tmp_path / name).write_bytes(b"x" * 4096)
    code = f"""
        import mmap
        for name in ({str(tmp_path / held)!r}, {str(tmp_path / "fastrtps_port7001")!r}):
            with open(name, "rb") as file:
                globals()[name] = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        print("ready", flush=True)
        input()
    """
    holder = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert holder.stdout.readline() == "ready\n"
        assert shared_memory.held_by([holder.pid]) == {held}, "the ports below 7400 are everybody's"
        assert shared_memory.clean([ours, held, "fastrtps_none"]) == [ours]
    finally:
        holder.communicate("\n", timeout=DEADLINE_S)
    assert holder.returncode == 0
    assert {path.name for path in tmp_path.iterdir()} == {held, theirs, f"{theirs}_el", "fastrtps_port7001"}


def test_segments_that_nobody_noted_are_known_by_their_age(tmp_path, monkeypatch):
    monkeypatch.setattr(shared_memory, "FOLDER", tmp_path)
    monkeypatch.setattr(shared_memory, "YOUNG_S", 0.0)
    before = tmp_path / "fastrtps_00000000000000aa"
    before.touch()
    began_s = before.stat().st_ctime + 0.05
    until(lambda: time.time() > began_s, "no time has passed")
    for name in ("fastrtps_00000000000000bb", "fastrtps_00000000000000bb_el", "fastrtps_port7399", "other"):
        (tmp_path / name).touch()
    until(lambda: shared_memory.made_since(began_s), "the new segment is not found")
    assert shared_memory.made_since(began_s) == {"fastrtps_00000000000000bb"}
    assert shared_memory.clean(shared_memory.made_since(began_s)) == ["fastrtps_00000000000000bb"]
    assert before.exists()


def test_a_segment_made_at_once_is_not_too_old(tmp_path, monkeypatch):
    """The times of files are those of the kernel's last tick, up to some milliseconds behind the clock."""
    monkeypatch.setattr(shared_memory, "FOLDER", tmp_path)
    monkeypatch.setattr(shared_memory, "YOUNG_S", 0.0)
    for number in range(50):
        began_s = time.time()
        made = tmp_path / f"fastrtps_{number:016x}"
        made.touch()
        until(lambda made=made, began_s=began_s: made.name in shared_memory.made_since(began_s), "it is not found")
        time.sleep(0.0007)


def test_what_was_made_just_now_is_waited_for_unless_somebody_owns_it(tmp_path, monkeypatch):
    """A node that is killed while it joins leaves what nobody has noted and what is too young to be judged."""
    monkeypatch.setattr(shared_memory, "FOLDER", tmp_path)
    monkeypatch.setattr(shared_memory, "YOUNG_S", 0.5)
    began_s = time.time()
    port, living = tmp_path / "fastrtps_port7415", tmp_path / "fastrtps_port7417"
    for path in (port, living):
        for name in (path.name, f"{path.name}_el", f"sem.{path.name}_mutex"):
            (tmp_path / name).touch()
    with (tmp_path / f"{living.name}_el").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert shared_memory.clean(shared_memory.left_since(began_s)) == [], "it might be one of another mission"
        assert shared_memory.clean_with_the_young([], began_s) == [port.name]
        assert {path.name for path in tmp_path.iterdir()} == {
            living.name, f"{living.name}_el", f"sem.{living.name}_mutex"
        }  # fmt: skip
        # What is owned is waited for by nobody.
        monkeypatch.setattr(shared_memory.time, "sleep", lambda s: pytest.fail("there is nothing to wait for"))
        living.touch()
        assert shared_memory.clean_with_the_young([], began_s) == []


def test_a_lock_without_its_segment_is_swept_too(tmp_path, monkeypatch):
    monkeypatch.setattr(shared_memory, "FOLDER", tmp_path)
    (tmp_path / "fastrtps_port7415_el").touch()
    assert shared_memory.abandoned_locks() == {"fastrtps_port7415"}
    assert shared_memory.clean(["fastrtps_port7415"]) == ["fastrtps_port7415"]
    assert not list(tmp_path.iterdir())


def test_ports_that_nobody_noted_go_with_or_without_a_lock_unless_somebody_holds_it(tmp_path, monkeypatch):
    monkeypatch.setattr(shared_memory, "FOLDER", tmp_path)
    monkeypatch.setattr(shared_memory, "YOUNG_S", 0.0)
    before, low = tmp_path / "fastrtps_port7412", tmp_path / "fastrtps_port7001"
    before.touch()
    began_s = before.stat().st_ctime + 0.05
    until(lambda: time.time() > began_s, "no time has passed")
    half, whole, living = (tmp_path / f"fastrtps_port{number}" for number in (7410, 7414, 7416))
    for path in (low, half, whole, living):
        path.touch()
        (tmp_path / f"sem.{path.name}_mutex").touch()
    (tmp_path / f"{whole.name}_el").touch()
    with (tmp_path / f"{living.name}_sl").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_SH)
        until(lambda: len(shared_memory.left_since(began_s)) == 3, "the ports are not found")
        assert shared_memory.clean(shared_memory.left_since(began_s)) == [half.name, whole.name]
    others = {f"{what}{path.name}{more}" for path in (low, living) for what, more in (("", ""), ("sem.", "_mutex"))}
    assert {path.name for path in tmp_path.iterdir()} == {before.name, f"{living.name}_sl", *others}
