"""The simulator's barrier and its book of commands."""

from __future__ import annotations

import math

import pytest

from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters
from tethernet_core.system import load_system
from tethernet_sim.lockstep import ZERO, Barrier, CommandBuffer

TICK = 50_000_000


@pytest.fixture
def book() -> CommandBuffer:
    return CommandBuffer(load(ControlParameters), load_system("zenit_8mu").units[0])


def test_the_barrier_falls_with_the_last_answer():
    barrier = Barrier(frozenset({"mu1", "mu2", "planner"}))
    barrier.open(TICK, 0.0)
    assert not barrier.answer("mu1", TICK)
    assert not barrier.answer("mu1", TICK), "an answer counts once"
    assert not barrier.answer("planner", TICK - 1), "answers to another tick are ignored"
    assert not barrier.answer("planner", TICK)
    assert barrier.answer("mu2", TICK)


def test_who_is_lost_is_not_waited_for_until_it_answers():
    barrier = Barrier(frozenset({"mu1", "mu2"}))
    barrier.open(0, 0.0)
    barrier.answer("mu1", 0)
    assert barrier.give_up() == ["mu2"]
    barrier.open(TICK, 0.0)
    assert barrier.answer("mu1", TICK), "mu2 is not waited for"
    barrier.open(2 * TICK, 0.0)
    assert not barrier.answer("mu2", 2 * TICK)
    assert barrier.lost == set()
    barrier.open(3 * TICK, 0.0)
    assert not barrier.answer("mu1", 3 * TICK), "mu2 is back and waited for again"
    assert barrier.answer("mu2", 3 * TICK)


def test_a_standstill_of_the_one_who_waits_passes_for_one_look():
    barrier = Barrier(frozenset({"mu1"}))
    barrier.open(0, 7.0)
    assert barrier.look(7.01, 0.03) == pytest.approx(0.01)
    assert barrier.look(7.04, 0.03) == pytest.approx(0.04)
    assert barrier.look(8.64, 0.03) == pytest.approx(0.07), "1.6 s in which nobody could answer"
    assert barrier.look(8.65, 0.03) == pytest.approx(0.08), "the next may come right after it"
    barrier.open(TICK, 8.65)
    assert barrier.look(8.66, 0.03) == pytest.approx(0.01)


def test_a_command_is_held_and_then_zeroed(book):
    force = (1.0, -2.0, 0.5)
    assert book.take(0, force, 0)
    assert book.thrust(0) == force
    for tick in range(1, 6):
        assert book.thrust(tick * TICK) == force
    assert book.thrust(6 * TICK) == ZERO
    assert (book.late, book.zeroed) == (6, 1)
    assert book.take(7 * TICK, force, 7 * TICK)
    assert book.thrust(7 * TICK) == force


def test_without_any_command_there_is_no_thrust(book):
    assert book.thrust(0) == ZERO
    assert (book.late, book.zeroed) == (1, 1)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_command_that_is_no_number_is_not_used(book, bad, axis):
    book.take(0, (1.0, 1.0, 1.0), 0)
    force = [0.5, 0.5, 0.5]
    force[axis] = bad
    assert not book.take(TICK, force, TICK)
    assert book.thrust(TICK) == (1.0, 1.0, 1.0), "the last good command is held"


def test_thrust_beyond_the_limit_is_clipped_and_counted(book):
    assert book.take(0, (6.0, -100.0, 5.1), 0)
    assert book.thrust(0) == (5.1, -5.1, 5.1)
    assert book.clipped == 1


def test_a_late_command_is_better_than_an_older_one(book):
    book.take(0, (1.0, 0.0, 0.0), 0)
    assert book.take(TICK, (2.0, 0.0, 0.0), 3 * TICK)
    assert book.thrust(3 * TICK) == (2.0, 0.0, 0.0)
    assert not book.take(0, (1.0, 0.0, 0.0), 3 * TICK), "older than the one held"
    assert not book.take(4 * TICK, (1.0, 0.0, 0.0), 3 * TICK), "of the future"
