"""The checks of the driver contract, on hand-made odometry: each breach is found, and by its own check."""

import dataclasses
import math
import random

import pytest

from tethernet_control.driver_contract import Reaction, Sample, check_reaction, check_samples, table
from tethernet_control.parameters import load
from tethernet_control.settings import ControlParameters

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
