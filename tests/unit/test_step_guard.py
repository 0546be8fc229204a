"""Which stamps and sequence numbers are believed."""

import random

import pytest

from tethernet_core.step_guard import Step, StepGuard

LONGEST, ENOUGH = 100, 5


def steps(*numbers):
    guard = StepGuard(LONGEST, ENOUGH)
    return [guard.take(number) for number in numbers], guard


def test_growing_in_bounded_steps_is_believed():
    taken, guard = steps(7, 8, 108, 109)
    assert taken == [Step.NEXT] * 4
    assert (guard.newest, guard.jumps) == (109, 0)


def test_repeated_and_out_of_order_is_old():
    taken, guard = steps(200, 200, 199, 100)
    assert taken == [Step.NEXT, Step.OLD, Step.OLD, Step.OLD]
    assert (guard.newest, guard.jumps) == (200, 0)


@pytest.mark.parametrize("wild", [10**18, 311, -(10**18), 99])
def test_one_number_from_elsewhere_is_dropped_and_counted(wild):
    taken, guard = steps(200, 210, wild, 220, 230)
    assert taken == [Step.NEXT, Step.NEXT, Step.JUMP, Step.NEXT, Step.NEXT]
    assert guard.jumps == 1


@pytest.mark.parametrize("offset", [10**9, -(10**9), -50])
def test_a_source_that_counts_anew_is_believed_after_enough_agreeing_numbers(offset):
    """Forward, back, and back by less than a step: all come back after as many samples."""
    guard = StepGuard(LONGEST, ENOUGH)
    for number in range(1000, 1010):
        guard.take(number)
    taken = [guard.take(1010 + offset + k) for k in range(8)]
    assert [step.good for step in taken] == [False] * (ENOUGH - 1) + [True] * 4
    assert taken[ENOUGH - 1] is Step.ANEW


def test_a_wild_first_number_is_overcome():
    taken, guard = steps(10**18, *range(10, 17))
    assert taken == [Step.NEXT, Step.JUMP, Step.JUMP, Step.JUMP, Step.JUMP, Step.ANEW, Step.NEXT, Step.NEXT]
    assert guard.newest == 16


def test_a_second_source_in_between_never_takes_over():
    guard = StepGuard(LONGEST, ENOUGH)
    for k in range(50):
        assert guard.take(k + 1) is Step.NEXT
        assert not guard.take(10**9 + k).good
    assert (guard.newest, guard.jumps) == (50, 50)


def test_numbers_that_do_not_agree_never_make_a_count():
    """A frozen stamp, and random ones: whatever comes, the true source goes on at once."""
    generator = random.Random(1)
    guard = StepGuard(LONGEST, ENOUGH)
    guard.take(500)
    for _ in range(300):
        assert not guard.take(10**12).good
    for _ in range(2000):
        assert not guard.take(generator.randrange(10**6, 10**18)).good
    assert guard.take(501) is Step.NEXT


@pytest.mark.parametrize("seed", range(20))
def test_after_any_rubbish_good_numbers_are_believed_soon(seed):
    generator = random.Random(seed)
    guard = StepGuard(LONGEST, ENOUGH)
    for _ in range(200):
        guard.take(generator.choice([0, 2**32 - 1, 2**63, generator.randrange(-(2**63), 2**63), 5]))
    begin = generator.randrange(-(10**6), 10**6)
    assert any(guard.take(begin + k).good for k in range(ENOUGH + 1))
    assert guard.take(begin + ENOUGH + 1) is Step.NEXT
