"""The checks of the driver contract, on hand-made odometry: each breach is found, and by its own check."""

import dataclasses
import math
import random

import pytest

from tethernet_control.driver_contract import Reaction, Sample, check_reaction, check_samples, obstacle, table
from tethernet_core.parameters import load
from tethernet_core.settings import ControlParameters

CONTROL = load(ControlParameters)
SIGMA = 0.1 / 3.0


def samples(count=100, velocity=lambda t: 0.0, begin_s=0.0, seed=1):
    noise = random.Random(seed)
    made = []
    for k in range(count):
        time_s = begin_s + 0.05 * k
        made.append(
            Sample(
                time_s + noise.uniform(0.0, 0.004), round(time_s * 1e9), "launch", "mu3", (0.0, 0.0, -1.5),
                (0.0, 0.0, 0.0, 1.0), (velocity(time_s) + noise.gauss(0.0, SIGMA), 0.0, 0.0), (SIGMA**2,) * 3,
                (SIGMA**2,) * 3,
            )
        )  # fmt: skip
    return made


def failed(findings):
    return [finding.requirement for finding in findings if not finding.passed]


def changed(made, index, **values):
    made[index] = dataclasses.replace(made[index], **values)
    return made


def test_a_good_driver_passes():
    assert failed(check_samples(3, samples(), "launch", CONTROL)) == []


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"frame": "map"}, "frame_id is 'launch'"),
        ({"child_frame": "base_link"}, "child_frame_id is 'mu3'"),
        ({"position": (0.0, math.nan, 0.0)}, "finite"),
        ({"attitude": (0.0, 0.0, 0.0, 0.0)}, "unit quaternion"),
        ({"pose_variances": (0.0, 0.1, 0.1)}, "variances"),
        ({"twist_variances": (0.1, 0.1, math.inf)}, "variances"),
        ({"stamp_ns": 0}, "stamps grow"),
    ],
)
def test_one_bad_message_is_found(values, words):
    assert any(words in text for text in failed(check_samples(3, changed(samples(), 50, **values), "launch", CONTROL)))


def test_wrong_rate_and_gaps_are_found():
    assert any("rate on the wall clock" in text for text in failed(check_samples(3, samples()[::2], "launch", CONTROL)))
    made = samples()
    del made[40:44]
    assert failed(check_samples(3, made, "launch", CONTROL)) == ["no gap of 5 periods or more"]


def test_silence_is_found():
    assert failed(check_samples(3, [], "launch", CONTROL)) == ["odometry arrives on /mu3/odom"]


def reaction(velocity):
    every = samples(140, velocity)
    return Reaction(0, 1.0, every[:40], every[40:60], every[60:])


def ramp(begin_s, end_s, acceleration):
    return lambda t: acceleration * (min(max(t, begin_s), end_s) - begin_s)


@pytest.mark.parametrize(
    ("velocity", "words"),
    [
        (ramp(2.0, 3.2, 0.4), None),  # 1 N on 2.5 kg for 20 commands and the watchdog's 5 periods
        (ramp(2.0, 3.2, -0.4), "faster"),
        (ramp(2.0, 3.2, 0.8), "faster"),
        (lambda t: 0.0, "faster"),
        (ramp(2.0, 99.0, 0.4), "silence for more than 5 periods"),
    ],
)
def test_reaction_to_thrust(velocity, words):
    wrong = failed(check_reaction(reaction(velocity), 2.5, CONTROL))
    assert wrong == [] if words is None else any(words in text for text in wrong)


def test_table_tells_what_was_seen():
    text = table(check_samples(3, samples()[::2], "launch", CONTROL))
    assert "FAIL  rate on the wall clock 20 Hz within 10%" in text
    assert "10.0" in text


YAW = math.radians(90.0)
YAWED = (0.0, 0.0, math.sin(YAW / 2.0), math.cos(YAW / 2.0))
"""The MU's x axis points along y of the launch frame."""


def yawed(velocity_in_child):
    """The reaction to thrust along x of the launch frame, of an MU that is yawed by 90 degrees."""
    made = [
        dataclasses.replace(s, attitude=YAWED, velocity=velocity_in_child(s.velocity))
        for s in samples(140, ramp(2.0, 3.2, 0.4))
    ]
    return Reaction(0, 1.0, made[:40], made[40:60], made[60:])


def test_a_yawed_driver_that_gives_the_twist_in_the_child_frame_passes():
    assert failed(check_reaction(yawed(lambda v: (v[1], -v[0], v[2])), 2.5, CONTROL)) == []


def test_a_yawed_driver_that_gives_the_twist_in_the_parent_frame_fails():
    wrong = failed(check_reaction(yawed(lambda v: v), 2.5, CONTROL))
    assert any("faster" in text for text in wrong)
    assert any("moves nothing else" in text for text in wrong)


def clocked(offset_s, **values):
    """Samples whose clock is so far ahead of the mission's, 2 to 10 ms on their way."""
    noise = random.Random(5)
    return [
        dataclasses.replace(
            s, clock_ns=s.stamp_ns - round(1e9 * offset_s) + round(1e6 * noise.uniform(2.0, 10.0)), **values
        )
        for s in samples()
    ]


@pytest.mark.parametrize(("offset_s", "seen"), [(0.2, "0.198 s ahead"), (-0.2, "0.202 s behind"), (5.0, "4.998 s")])
def test_a_clock_that_is_off_is_found(offset_s, seen):
    found = [f for f in check_samples(3, clocked(offset_s), "launch", CONTROL) if not f.passed]
    assert [f.requirement for f in found] == ["stamps agree with the mission's clock within 50 ms"]
    assert seen in found[0].seen


@pytest.mark.parametrize("offset_s", [-0.04, 0.0, 0.04])
def test_a_clock_within_a_control_period_passes(offset_s):
    assert failed(check_samples(3, clocked(offset_s), "launch", CONTROL)) == []
    assert obstacle(3, clocked(offset_s), "launch", CONTROL, waiting=False) == ""


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"frame": "map"}, "header.frame_id is 'launch': seen 'map'"),
        ({"child_frame": "base_link"}, "child_frame_id is 'mu3': seen 'base_link'"),
        ({"attitude": (0.0, 0.0, 0.0, 0.0)}, "attitude is a unit quaternion: seen norm 0"),
        ({"attitude": (0.0, 0.0, math.nan, 1.0)}, "attitude is a unit quaternion: seen norm nan"),
        ({"velocity": (0.0, math.inf, 0.0)}, "all numbers finite"),
        ({"stamp_ns": 1_795_721_613_000_000_000}, "stamps agree with the mission's clock within 50 ms: seen 17957"),
    ],
)
@pytest.mark.parametrize("waiting", [False, True])
def test_what_keeps_an_mu_from_being_launched_is_named(waiting, values, words):
    made = clocked(0.0)
    made = [dataclasses.replace(s, **values) for s in made]
    assert words in obstacle(3, made, "launch", CONTROL, waiting)


def test_a_rate_that_is_wrong_keeps_an_mu_from_being_launched_where_the_clock_runs():
    assert "rate by the stamps" in obstacle(3, clocked(0.0)[::2], "launch", CONTROL, waiting=False)
    assert obstacle(3, clocked(0.0)[:1], "launch", CONTROL, waiting=True) == ""


def test_covariances_and_a_busy_machine_keep_no_mu_on_the_ground():
    made = [dataclasses.replace(s, arrival_s=2.0 * s.arrival_s) for s in clocked(0.0, pose_variances=(0.0,) * 3)]
    assert len(failed(check_samples(3, made, "launch", CONTROL))) == 2
    assert obstacle(3, made, "launch", CONTROL, waiting=False) == ""
