"""The digest by which cards of models go stale: what counts, and what does not."""

import json

import pytest

from tests import tiny_models
from tests.systems import zenit
from tethernet_learning import flight_digest, measured
from tethernet_planner.inference import shipped_models
from tethernet_planner.inference.model_file import file_fingerprint

SOURCE = '''
"""A module."""

GAIN = 3.0
"""Of the loop."""


def thrust(error):
    """Newtons."""
    # proportional
    if error > 1e3:
        raise ValueError("an error as large as this is none")
    return GAIN * error
'''


def test_comments_annotations_layout_and_prose_do_not_count():
    again = SOURCE.replace("# proportional", "# another comment").replace('"""Newtons."""', '"""In newtons [N]."""')
    again = again.replace("thrust(error)", "thrust(error: float) -> float")
    again = again.replace("is none", "is no error").replace("GAIN * error", "(GAIN\n        * error)")
    assert again != SOURCE
    assert flight_digest.meaning(again) == flight_digest.meaning(SOURCE)


@pytest.mark.parametrize(
    ("old", "new"), [("3.0", "3.1"), ("GAIN * error", "GAIN + error"), ("1e3", "1e4"), ("error > ", "error >= ")]
)
def test_every_number_and_every_operation_counts(old, new):
    assert flight_digest.meaning(SOURCE.replace(old, new)) != flight_digest.meaning(SOURCE)


def test_physics_control_and_aiming_count_and_nodes_do_not():
    names = set(flight_digest.modules())
    assert {
        "tethernet_sim.fly", "tethernet_sim.kernels.step", "tethernet_sim.kernels.contact", "tethernet_control.law",
        "tethernet_planner.closing", "tethernet_control.estimator", "tethernet_core.capture_quality",
        "tethernet_planner.inference.task", "tethernet_planner.inference.net_features",
    } <= names  # fmt: skip
    assert not [name for name in names if ".ros" in name or name.endswith("_node")]


def test_a_default_parameter_counts(monkeypatch):
    now = flight_digest.flight_digest()
    known = flight_digest.defaults
    monkeypatch.setattr(flight_digest, "defaults", lambda kind: {**known(kind), "kp": 12.0})
    assert flight_digest.flight_digest.__wrapped__() != now


def test_a_card_of_other_physics_of_another_file_or_none_is_stale_and_the_command_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(shipped_models, "FOLDER", tmp_path)
    file = tiny_models.policy(shipped_models.place("policy", "zenit_8mu"), zenit(8))
    assert "cannot be read" in measured.stale("policy", zenit(8))
    told = {"model": file_fingerprint(file), "flight_digest": flight_digest.flight_digest()}
    told["system_digest"] = zenit(8).digest

    def with_card(**changed):
        measured.place("policy", "zenit_8mu").write_text(json.dumps({**told, **changed}))
        return measured.stale("policy", zenit(8))

    assert with_card() == ""
    elsewhere = ({"flight_digest": "0" * 16}, "on other physics or control")
    for changed, words in (elsewhere, ({"model": "x"}, "another file"), ({"system_digest": "x"}, "for another system")):
        assert words in with_card(**changed)
        assert "the card of the policy for zenit_8mu is stale" in measured.stale("policy", zenit(8))
        assert "make cards" in measured.stale("policy", zenit(8))
