"""A batch shared among cores: every scenario once, failures told, forks and other threads allowed."""

import multiprocessing
import threading

import numpy as np
import pytest

from tethernet_sim import cores


@pytest.fixture(autouse=True)
def as_before(monkeypatch):
    """What a test sets holds for that test alone."""
    monkeypatch.setattr(cores, "_limit", None)
    monkeypatch.setattr(cores, "_pool", None)


@pytest.mark.parametrize("number", [1, 2, 3, 7])
@pytest.mark.parametrize("items", [0, 1, 2, 5, 64])
def test_every_index_is_worked_on_once(number, items):
    cores.use(number)
    indices, seen = np.arange(10, 10 + items), []
    cores.share(lambda part: seen.extend(part.tolist()), indices)
    assert sorted(seen) == indices.tolist()


def test_the_parts_run_at_the_same_time():
    cores.use(3)
    meeting = threading.Barrier(3, timeout=30.0)
    cores.share(lambda part: meeting.wait(), np.arange(3))


@pytest.mark.parametrize("wrong", [0, 1])
def test_a_failing_part_is_told_after_all_have_ended(wrong):
    cores.use(2)
    ended = []

    def work(part):
        ended.append(part[0])
        if part[0] == wrong:
            raise ArithmeticError(f"part {wrong}")

    with pytest.raises(ArithmeticError, match=f"part {wrong}"):
        cores.share(work, np.arange(2))
    assert sorted(ended) == [0, 1]


@pytest.mark.parametrize(("number", "words"), [(1, "1 core"), (2, "2 cores")])
def test_it_is_told_in_words(number, words):
    cores.use(number)
    assert cores.told() == words


def test_none_is_no_number_of_cores():
    with pytest.raises(ValueError, match="0 cores: allowed: 1 or more"):
        cores.use(0)


def _in_a_child(queue):
    seen = []
    cores.share(lambda part: seen.extend(part.tolist()), np.arange(4))
    queue.put(sorted(seen))


def test_a_forked_process_starts_threads_of_its_own():
    cores.use(2)
    cores.share(lambda part: None, np.arange(4))
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_in_a_child, args=(queue,))
    child.start()
    assert queue.get(timeout=60.0) == [0, 1, 2, 3]
    child.join(60.0)
    assert child.exitcode == 0
