"""Lock-step makes a mission reproducible: the same seed gives the same bag."""

import re
from collections import defaultdict

import pytest

from tests.ros.mission_command import MissionCommand
from tests.ros.test_mission_faults import LOCKSTEP, short
from tethernet_bringup.analysis.decoder import Decoder
from tethernet_bringup.bags.reader import open_bag

pytestmark = pytest.mark.ros

WALL_CLOCK_TOPICS = {"/sim/status", "/diagnostics"}
"""They tell how long things took."""


def content(run):
    """All messages but those about the wall clock: by topic, with their times, decoded."""
    bag, decode, found = open_bag(run), Decoder(), defaultdict(list)
    for message in bag.messages(lambda topic: topic not in WALL_CLOCK_TOPICS):
        decoded = repr(decode(bag.topics[message.topic].message_type, message.data))
        decoded = re.sub(r"\bmission_id=\d+", "mission_id", decoded)  # each planner draws one
        found[message.topic].append((message.log_time, message.publish_time, decoded))
    assert bag.problems == []
    return found


def test_the_same_seed_gives_the_same_bag(tmp_path, domain_id):
    bags = []
    for name in ("first", "second"):
        flags = ("--mus", "4", "--seed", "7", *LOCKSTEP, *short(tmp_path, 2.0))
        with MissionCommand(tmp_path / name, domain_id, *flags) as mission:
            assert mission.finish() == 3, mission.text
            bags.append(content(mission.run))
    first, second = bags
    assert len(first["/net/state"]) >= 40
    assert set(first) == set(second)
    begin, *_, end = sorted(entry[0] for entry in first["/net/state"])
    for topic in first:
        # When a status echoes the end, before or after the last odometry was answered, and whether there is one more
        # assessment of the last tick, is chance. What is flown is not.
        if topic.endswith("/status"):
            continue
        flown = [[entry for entry in bag[topic] if begin < entry[0] < end] for bag in bags]
        assert flown[0] == flown[1], topic
        if topic.endswith(("/odom", "/thrust", "/net/state")):
            assert set(first[topic]) == set(second[topic]), topic
