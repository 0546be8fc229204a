from tethernet_bringup.recorder.publication_count import PublicationCount


def counted(*sequences, shared=False):
    count = PublicationCount(shared)
    for sequence in sequences:
        count.take(sequence)
    return count.lost


def test_gaps_in_a_publishers_counter_are_messages_that_never_came():
    assert counted(1, 2, 3) == 0
    assert counted(5, 6, 9, 11) == 3


def test_two_publishers_of_one_topic_are_not_taken_for_losses():
    assert counted(1, 2, 5001, 3, 5002, 4) == 0


def test_a_publisher_that_was_started_anew_is_no_loss():
    assert counted(1, 2, 200, 1, 2, 3) == 0


def test_the_counters_of_a_shared_topic_say_nothing():
    assert counted(1, 9, 20, shared=True) == 0
