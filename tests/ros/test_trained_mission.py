"""A mission with trained models: over ROS as in process."""

from tests import tiny_models
from tests.ros.mission_command import MissionCommand
from tests.systems import zenit
from tethernet_learning.campaigns.cases import Case, aim
from tethernet_learning.data.trigger import fly_and_look
from tethernet_planner.inference.surrogate_file import Surrogate
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Scenario

PLACE = (3.0, -2.0, -47.0)


def test_policy_and_surrogate_give_the_same_bits_over_ros_and_in_process(tmp_path, domain_id):
    policy = tiny_models.policy(tmp_path / "policy.safetensors", zenit(8), -0.2, 0.1)
    surrogate = tiny_models.surrogate(tmp_path / "surrogate.safetensors", zenit(8), pairs=7.0, seen=1005)
    (tmp_path / "p.yaml").write_text(f"assessor: {{ros__parameters: {{predictor: {surrogate}}}}}\n")
    words = ["--mus", "8", "--pace", "lockstep", "--seed", "5", "--debris", *map(str, PLACE)]
    words += ["--policy", str(policy), "--params", str(tmp_path / "p.yaml")]
    [case] = aim([Case(Scenario("zenit_8mu", debris_position=PLACE, seed=5), "")], str(policy))
    [flown], [seen] = fly_and_look([case.scenario], Settings.load("zenit_8mu"), stop_at_trigger=False)
    expected = Surrogate.load(surrogate).predict_many(seen[None])
    with MissionCommand(tmp_path / "runs", domain_id, *words) as mission:
        assert mission.finish() == (0 if flown.captured else 3), mission.text
        outcome = mission.outcome
    assert outcome["captured"] is flown.captured
    assert outcome["aiming_sources"] == [str(policy)] * 8
    assert (outcome["cqi"], outcome["fuel_kg"]) == (flown.cqi, list(flown.fuel_kg))
    predicted = outcome["prediction"]
    assert predicted["locked_pairs"] == expected.locked_pairs[0]
    assert predicted["locked_pairs_error"] == flown.locked_pairs - expected.locked_pairs[0]
    assert predicted["cqi_error"] == flown.cqi - expected.cqi[0]
