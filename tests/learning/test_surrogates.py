"""Surrogates: what is saved predicts what was trained, wrong files are explained, one seed gives one model."""

import dataclasses
import json
import math

import numpy as np
import pytest

from tests.command import tethernet
from tests.systems import zenit
from tethernet_learning import assumed_numbers
from tethernet_learning.campaigns.chunks import failed
from tethernet_learning.data import data_set, make_data, measure_repeatability
from tethernet_learning.data.data_set import Captures
from tethernet_learning.data.trigger import fly_and_look
from tethernet_learning.flight_settings import Flight
from tethernet_learning.policies import capture_sources as sources
from tethernet_learning.surrogates import surrogate_training
from tethernet_learning.surrogates.surrogate_scores import scores, with_errors
from tethernet_planner.inference import model_file, networks
from tethernet_planner.inference.model_file import MadeFor, ModelFileError
from tethernet_planner.inference.net_features import feature_count, sector_nodes
from tethernet_planner.inference.surrogate_file import NOISES, Surrogate, log_fuel, probability, seen_arrays
from tethernet_sim.fly import Settings

pytestmark = pytest.mark.learning
SYSTEM = zenit(4)


def invented(system, count, seed):
    """Captures that depend on how far the net is beside the debris."""
    random = np.random.default_rng(seed)
    rows = random.normal(0, 0.3, (count, feature_count(system) // 6, 6)).astype(np.float32)
    beside = random.uniform(0, 4, count)
    rows[:, :, 2] += beside[:, None]
    captured = beside < 2.5
    pairs = np.where(captured, 9.0, 4.0)
    about = {"seed": seed, "flight_parameters": ""}
    cqi = 0.5 + beside
    fuel = 0.1 * np.ones(count)
    flat = rows.reshape(count, -1)
    return Captures(flat, cqi, pairs, fuel, captured, count, int((~captured).sum()), about, system)


@pytest.fixture(scope="module")
def materials():
    return surrogate_training.prepare(invented(SYSTEM, 80, 0), seed=0)


@pytest.mark.parametrize("mus", [4, 8])
def test_the_sequence_goes_once_round_the_mouth(mus):
    nodes = sector_nodes(zenit(mus))
    assert nodes.shape == (8, 22)
    knots = nodes[:, :20].ravel()
    assert sorted(knots) == list(range(160))
    assert (nodes[:, 20] == 160).all()
    assert sorted(n - 160 for n in nodes[:, 21] if n != 161 + mus) == list(range(1, mus + 1))


@pytest.mark.parametrize("name", ["rnn", "mlp", "trees"])
def test_what_is_saved_predicts_what_was_trained(name, materials, tmp_path):
    pytest.importorskip("torch")
    pytest.importorskip("sklearn")
    from tethernet_learning.surrogates.train_surrogate import train_one

    overrides = {"epochs": 12, "trees": 30}
    test = invented(SYSTEM, 60, 1)
    surrogate = with_errors(train_one(name, materials[:2], 3, overrides, {}), test)
    surrogate.save(tmp_path / "a.safetensors")
    again = Surrogate.load(tmp_path / "a.safetensors")
    predicted, loaded = surrogate.predict_many(test.features), again.predict_many(test.features)
    assert np.allclose(predicted.cqi, loaded.cqi, rtol=1e-5)
    assert again.errors == surrogate.errors
    judged = scores(again, test)
    assert judged["balanced"] > 0.8
    assert 0.0 < judged["inference_ms"] < math.inf, "told; how fast it is hangs on the machine's other work"
    assert judged["all"]["right"] == judged["right"], "closing began in all of them"
    more = scores(again, dataclasses.replace(test, scenarios=len(test.captured) + 40))
    assert more["right"] == judged["right"]
    assert more["all"]["scenarios"] == len(test.captured) + 40
    assert more["all"]["failures"] == judged["failures"] + 40
    assert more["all"]["right"] == pytest.approx((60 * judged["right"] + 40) / 100)
    assert judged["always_captured"] == judged["all"]["always_captured"] == test.captured.mean()
    assert more["all"]["always_captured"] == pytest.approx((test.captured.sum() + 40) / 100)
    never = more["all"]["failures"]
    assert more["all"]["always_captured_balanced"] == pytest.approx(0.5 + 0.5 * 40 / never)
    assert json.dumps(judged)
    same = train_one(name, materials[:2], 3, overrides, {})
    assert all(np.array_equal(same.arrays[key], surrogate.arrays[key]) for key in same.arrays)


def test_every_scenario_is_held_back_from_one_member(materials):
    assert len(materials) == surrogate_training.FOLDS
    held = np.concatenate([material.held_inputs for material in materials])
    assert len(held) == 80
    assert len(np.unique(held, axis=0)) == 80
    for material in materials:
        both = np.concatenate([material.inputs, material.held_inputs])
        assert len(np.unique(both, axis=0)) == len(both) == 80


def test_too_few_failures_for_every_member_are_told():
    captures = invented(SYSTEM, 80, 0)
    captured = np.ones(80, bool)
    captured[17] = False
    with pytest.raises(ValueError, match=r"too few of the 80 training scenarios .* make more scenarios"):
        surrogate_training.prepare(dataclasses.replace(captures, captured=captured), seed=0)
    with pytest.raises(ValueError, match="all 80 training scenarios captured"):
        surrogate_training.prepare(dataclasses.replace(captures, captured=np.ones(80, bool)), seed=0)


@pytest.mark.parametrize("sure", [4.0, 15.0, 40.0])
def test_a_model_that_is_too_sure_is_calibrated_to_what_happens(sure):
    """Wrong in 7 of 2000 cases that it knows apart by nothing."""
    captured = np.ones(2000)
    captured[:7] = 0.0
    logit = sure + np.random.default_rng(0).normal(0.0, 1.0, 2000)
    calibration = surrogate_training._calibration(logit, captured)
    assert probability(logit, calibration).mean() == pytest.approx(captured.mean(), abs=2e-3)
    assert 0.0 < calibration[0] < 1.0


def test_members_predict_together():
    alone, other = small_surrogate(), small_surrogate()
    other.arrays["0.bias_0"] = np.array([0.6, -3.0, 1.0, 2.0])
    second = {f"1.{name[2:]}": array for name, array in other.arrays.items() if name.startswith("0.")}
    both = dataclasses.replace(alone, arrays={**alone.arrays, **second})
    rows = np.zeros((1, feature_count(SYSTEM)))
    a, b, ab = (surrogate.predict_many(rows) for surrogate in (alone, other, both))
    assert ab.locked_pairs[0] == pytest.approx((a.locked_pairs[0] + b.locked_pairs[0]) / 2)
    assert ab.cqi[0] == pytest.approx(np.sqrt(a.cqi[0] * b.cqi[0]))
    assert ab.capture_probability[0] == pytest.approx((a.capture_probability[0] + b.capture_probability[0]) / 2)


def test_numpy_and_torch_agree(materials):
    torch = pytest.importorskip("torch")
    from tethernet_learning.surrogates.train_networks import _Dense, _Recurrent

    torch.manual_seed(0)
    rows = materials[0].held_inputs
    dense = _Dense(rows.shape[1], 0.0)
    steps = networks.sector_inputs(rows, sector_nodes(SYSTEM))
    recurrent = _Recurrent(steps.shape[2], 0.0)
    with torch.no_grad():
        expected = dense.outputs(torch.from_numpy(rows)).numpy()
        assert np.allclose(networks.dense(dense.arrays(), rows), expected, atol=1e-5)
        expected = recurrent.outputs(torch.from_numpy(steps)).numpy()
        assert np.allclose(networks.recurrent(recurrent.arrays(), steps), expected, atol=1e-5)


def test_exported_trees_predict_what_scikit_learn_does():
    sklearn = pytest.importorskip("sklearn.ensemble")
    from tethernet_learning.surrogates.train_trees import _Tree

    random = np.random.default_rng(0)
    rows = random.normal(size=(200, 6)).astype(np.float32)
    model = sklearn.GradientBoostingRegressor(n_estimators=20, max_depth=3, learning_rate=0.1, random_state=0)
    model.fit(rows, rows[:, 0] * rows[:, 1])
    trees = [_Tree.of(tree.tree_, 0.1) for tree in model.estimators_[:, 0]]
    nodes = max(len(tree.value) for tree in trees)
    names = ("feature", "left", "right", "threshold", "value")
    arrays = {name: np.stack([[tree.padded(name, nodes) for tree in trees]]) for name in names}
    arrays |= {"components": np.zeros((0, 6)), "direct": np.arange(6), "base": np.array([model.init_.constant_[0, 0]])}
    assert np.allclose(networks.boosted_trees(arrays, rows)[:, 0], model.predict(rows), atol=1e-5)


def small_surrogate(system=SYSTEM):
    inputs = feature_count(system)
    arrays = {
        "0.weight_0": np.zeros((4, inputs)), "0.bias_0": np.zeros(4), "input_mean": np.zeros(inputs),
        "input_scale": np.ones(inputs), "output_mean": np.array([0.0, 9.0, log_fuel(0.1)]), "output_scale": np.ones(3),
        "calibration": np.array([1.0, 0.0]), **seen_arrays(system),
    }  # fmt: skip
    errors = dict.fromkeys(("all", "near", "far"), surrogate_training.PredictionErrors(0.0, 0.5, 0.0, 0.5))
    return Surrogate("mlp", MadeFor.of(system), system.closing.max_locked_pairs, arrays, errors, {})


@pytest.mark.parametrize("fuel_kg", [0.0, 0.08, 2.0])
def test_the_fuel_of_closing_comes_out_of_its_logarithm(fuel_kg):
    surrogate = small_surrogate(zenit(8))
    surrogate.arrays["output_mean"][2] = log_fuel(fuel_kg)
    predicted = surrogate.predict_many(np.zeros((1, feature_count(zenit(8)))))
    assert predicted.closing_fuel_kg[0] == pytest.approx(fuel_kg, abs=1e-9)


def test_an_episode_through_a_surrogate(tmp_path):
    small_surrogate().save(tmp_path / "s.safetensors")
    scenarios = make_data.scenarios(SYSTEM, "train", 1, 0, 2)
    flown = [sources.make("surrogate", Settings.load(), tmp_path / "s.safetensors", noise) for noise in NOISES]
    split, _, exact = (source.fly(scenarios) for source in flown)
    assert (split.cqi != exact.cqi).any()
    alone = flown[0].fly(scenarios[:1])
    assert alone.cqi[0] == split.cqi[0]
    assert alone.fuel_kg[0] == split.fuel_kg[0] > 0.1


@pytest.mark.parametrize(
    "spoil", ["missing", "text", "kind", "system", "units", "shape", "nan", "members", "nodes", "sectors"]
)
def test_wrong_files_are_explained(spoil, tmp_path):
    path = tmp_path / "s.safetensors"
    surrogate = small_surrogate()
    surrogate.save(path)
    arrays, about = model_file.read(path, "surrogate")
    path.unlink()
    changed = {
        "shape": {"calibration": np.zeros(3)},
        "nan": {"calibration": np.full(2, np.nan)},
        "nodes": {"nodes": -arrays["nodes"]},
        "sectors": {"sectors": arrays["sectors"] + 200},
    }
    if spoil == "text":
        path.write_text("no model")
    elif spoil == "members":
        model_file.write(path, "surrogate", {n: a for n, a in arrays.items() if not n.startswith("0.")}, about)
    elif spoil != "missing":
        facts = {"system": {"system": None}, "units": {"mus": 8}}.get(spoil, {})
        kind = "policy" if spoil == "kind" else "surrogate"
        model_file.write(path, kind, {**arrays, **changed.get(spoil, {})}, {**about, **facts})
    with pytest.raises(ModelFileError, match=r"s\.safetensors"):
        Surrogate.load(path)


def test_a_data_set_without_its_system_is_refused_with_what_to_do(tmp_path):
    parquet, pa = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("pyarrow")
    flown = make_data.scenarios(SYSTEM, "train", 0, 0, 1)
    outcomes = [failed(scenario, "not flown") for scenario in flown]
    table = pa.Table.from_pylist(data_set.rows(0, flown, outcomes, [None]), data_set.schema(SYSTEM, {"seed": 0}))
    parquet.write_table(table, tmp_path / "old.parquet")
    with pytest.raises(ValueError, match=r"old\.parquet does not say which system .* anew with tethernet data make"):
        data_set.read(tmp_path / "old.parquet")


def test_a_data_set_is_made_described_resumed_and_not_mixed(tmp_path, capsys):
    parquet = pytest.importorskip("pyarrow.parquet")
    words = ["--mus", "4", "--train", "2", "--test", "1", "--output", str(tmp_path / "d")]
    assert tethernet("data", "make", *words) == 0
    form = parquet.read_schema(tmp_path / "d" / "train.parquet")
    assert set(form.names) == set(data_set.COLUMNS)
    assert all(form.field(name).metadata[b"description"] for name in form.names)
    assert json.loads(form.metadata[b"tethernet"])["seed"] == 0
    captures = data_set.read(tmp_path / "d" / "train.parquet")
    assert captures.scenarios == 2
    flown = make_data.scenarios(SYSTEM, "train", 0, 0, 2)
    outcomes, seen = fly_and_look(flown, Settings.load(), stop_at_trigger=False)
    same = data_set.captures(outcomes, seen, captures.about, SYSTEM)
    for field in dataclasses.fields(data_set.Captures):
        assert np.array_equal(getattr(same, field.name), getattr(captures, field.name)), field.name
    before = (tmp_path / "d" / "train.parts" / "000000.parquet").stat().st_mtime_ns
    assert tethernet("data", "make", *words) == 0
    assert (tmp_path / "d" / "train.parts" / "000000.parquet").stat().st_mtime_ns == before
    assert tethernet("data", "make", *words, "--seed", "1") == 2
    assert "seed: there 0, asked for 1" in capsys.readouterr().err


def test_a_data_set_with_numbers_drawn_is_flown_with_them(monkeypatch):
    monkeypatch.setattr(assumed_numbers, "GROUP", 1)
    settings = Settings.load(SYSTEM)
    rows = make_data.Part(SYSTEM, "train", 0, 0, 2, "random").fly(settings)
    for row, scenario in zip(rows, make_data.scenarios(SYSTEM, "train", 0, 0, 2), strict=True):
        flight, _ = assumed_numbers.drawn(Flight(SYSTEM, settings), scenario.seed)
        alone = dataclasses.replace(scenario, system=flight.system)
        outcomes, seen = fly_and_look([alone], flight.settings, stop_at_trigger=False)
        (expected,) = data_set.rows(row["number"], [scenario], outcomes, seen)
        assert np.array_equal(row.pop("features"), expected.pop("features"))
        assert row == expected
    as_described = make_data.Part(SYSTEM, "train", 0, 0, 2).fly(settings)
    assert [row["fuel_kg"] for row in as_described] != [row["fuel_kg"] for row in rows]


def test_a_micrometre_at_the_trigger_changes_the_capture_and_nothing_before(monkeypatch):
    flown = []
    fly_many = measure_repeatability.fly_many
    monkeypatch.setattr(measure_repeatability, "fly_many", lambda *a, **k: flown.append(fly_many(*a, **k)) or flown[-1])
    found = measure_repeatability.measure(SYSTEM, 3, 0, Settings.load())
    pairs = [(a, b) for a, b in zip(*flown, strict=True) if a.trigger_time_s is not None]
    assert found["closing_began"] == len(pairs) > 0
    differ = sum(a.captured != b.captured for a, b in pairs) / len(pairs)
    assert (found["same_verdict"], found["bound"]) == pytest.approx((1.0 - differ, 1.0 - differ / 2))
    for a, b in pairs:
        assert (a.trigger_time_s, a.fuel_at_trigger_kg) == (b.trigger_time_s, b.fuel_at_trigger_kg)
        assert a.cqi != b.cqi
