"""analyse_mission: hold test, loads and enclosure; and recordings from before there were any."""

import dataclasses
import json
import re

import pytest

from tests import toy_mission
from tests.integration.test_analyse_mission import PICTURES, analyse
from tethernet_bringup.analysis import pictures, recorded_flight, snapshots
from tethernet_bringup.analysis.decoder import Decoder
from tethernet_bringup.analysis.metrics import curve, enclosure
from tethernet_bringup.analysis.mission_data import load
from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.bags.writer import BagWriter
from tethernet_core.mission import Phase

HOLD_S = 3.0
NEWER = {
    "/mission/state": ("HOLDING", "hold_duration", "tow", "hold_time", "hold_end_time"),
    "/net/state": (
        "load_share_valid", "load_share", "max_load_share", "contact_force_valid", "contact_force", "max_contact_force",
    ),
    "/capture/assessment": (
        "HELD", "mcqi_valid", "mcqi", "enclosed_valid", "enclosed", "load_share_valid", "max_load_share",
        "contact_force_valid", "max_contact_force", "held_valid", "held", "hold_verdict",
    ),
}  # fmt: skip
"""Constants and fields that messages had none of before there was a hold test over ROS."""


@pytest.fixture
def coarse(monkeypatch):
    """Pictures of few dots, flights of few moments: quick."""
    monkeypatch.setattr(pictures, "_RESOLUTION_DPI", 30)
    monkeypatch.setattr(recorded_flight, "MOST_NUMBERS", 50_000)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "run"
    toy_mission.write_bag(folder / "bag", end_s=toy_mission.end_of_hold(HOLD_S), hold_s=HOLD_S)
    return folder


def test_a_hold_test_is_told_and_drawn(run, tmp_path, coarse, capsys):
    status, out, err = analyse(capsys, run, "--output", tmp_path, "--json")
    assert (status, err) == (0, "")
    assert {path.name for path in tmp_path.iterdir()} == PICTURES | {"analysis.json"}
    for line in (
        "held: the closed net goes round the whole debris (3 s after the verdict, towed with 20 N)",
        "  CQI                         0.90, after the hold test 0.90",
        "  MCQI                        0.30, after the hold test 0.30",
        "  enclosed                    yes, after the hold test yes",
        "  held                        yes",
        "  largest load of a thread    8.5 % of its strength",
        "  largest contact force       7 N",
        "holding         39.45     42.50",
    ):
        assert line in out.splitlines(), line
    content = json.loads((tmp_path / "analysis.json").read_text())
    assert (content["captured"], content["held"], content["enclosed"]) == (True, True, True)
    assert (content["hold_s"], content["tow_n"], content["mcqi"]) == (HOLD_S, toy_mission.TOW_N, 0.3)
    assert content["max_load_share"] == pytest.approx(toy_mission.LOAD_PER_S * toy_mission.end_of_hold(HOLD_S))
    assert content["problems"] == []


def test_its_series_and_moments(run):
    bag = open_bag(run)
    data = load(bag)
    assert [change.phase for change in data.phases][-3:] == [Phase.CLOSING, Phase.HOLDING, Phase.COMPLETE]
    assert float(data.seconds(data.judged_ns)) == pytest.approx(toy_mission.END_S)
    inside, mcqi = enclosure(data)
    closed = inside.time_s >= toy_mission.TRIGGER_S + 5.0
    assert inside.time_s[0] == pytest.approx(toy_mission.TRIGGER_S, abs=0.2)
    assert ((inside.value == 1.0) == closed).all()
    assert mcqi.known
    assert mcqi.time_s[mcqi.value > 0.0][0] >= toy_mission.END_S
    share, tether = curve(data, data.load_share), curve(data, data.tether)
    assert share.value == pytest.approx(toy_mission.LOAD_PER_S * share.time_s)
    assert set(tether.value[tether.time_s > toy_mission.END_S + 0.01]) == {toy_mission.TOW_N}
    shots = snapshots.take(data, bag)
    assert [shot.title for shot in shots] == ["early deployment", "trigger", "verdict", "end of the hold test"]
    assert shots[2].time_s == pytest.approx(toy_mission.END_S)


def test_without_a_hold_test_nothing_is_said_of_one(tmp_path, coarse, capsys):
    toy_mission.write_bag(tmp_path / "bag")
    _, out, _ = analyse(capsys, tmp_path, "--output", tmp_path / "out", "--json")
    assert "  held                        -" in out.splitlines()
    assert "after the hold test" not in out
    content = json.loads((tmp_path / "out" / "analysis.json").read_text())
    assert (content["held"], content["hold_verdict"], content["hold_s"]) == (None, None, 0.0)


def test_a_recording_cut_in_its_hold_test_keeps_its_verdict(tmp_path, coarse, capsys):
    toy_mission.write_bag(tmp_path / "bag", end_s=toy_mission.END_S + 1.0, hold_s=HOLD_S)
    status, out, _ = analyse(capsys, tmp_path, "--output", tmp_path / "out")
    assert status == 0
    assert "captured: CQI 0.90 below 2.5, 8 of 8 pairs locked" in out
    assert "  held                        -" in out.splitlines()
    assert "holding" in out


def test_a_recording_from_before_the_hold_test_is_analysed_as_far_as_it_goes(tmp_path, coarse, capsys):
    """A bag carries the definitions of its messages: the old ones have no phase HOLDING, no loads, no enclosure."""
    older = {topic.name: topic for topic in toy_mission.bag_topics()}
    decode = Decoder()
    stores = {}
    for name, without in NEWER.items():
        kind = older[name].message_type
        older[name] = dataclasses.replace(older[name], message_type=before(kind, without))
        stores[name] = store_of(older[name].message_type)
    topics = toy_mission.bag_topics()
    writer = BagWriter(tmp_path / "bag", list(older.values()), run_info=toy_mission.RUN_INFO)
    for index, stamp, newest in toy_mission.serialized(8, toy_mission.END_S):
        topic, data = topics[index], newest
        if topic.name in stores:
            message = decode(topic.message_type, newest)
            store, kind = stores[topic.name], topic.message_type.name
            fields = {field.name: getattr(message, field.name) for field in dataclasses.fields(store.types[kind])}
            fields = {name: value for name, value in fields.items() if not name.startswith("__")}
            data = bytes(store.serialize_cdr(store.types[kind](**fields), kind))
        writer.write(index, stamp, stamp, 1, data)
    writer.close()
    status, out, err = analyse(capsys, tmp_path, "--output", tmp_path / "out", "--json")
    assert (status, err) == (0, "")
    assert "captured: CQI 0.90 below 2.5, 8 of 8 pairs locked" in out
    assert "  CQI                         0.90" in out.splitlines()
    assert "  largest load of a thread    -" in out.splitlines()
    assert "note: /net/state is of a version without load_share: no loads" in out
    assert "note: /capture/assessment is of a version without enclosed: no MCQI, not known whether the debris" in out
    assert {path.name for path in (tmp_path / "out").iterdir()} == PICTURES - {"loads.png"} | {"analysis.json"}
    content = json.loads((tmp_path / "out" / "analysis.json").read_text())
    assert content["captured"] is True
    assert content["cqi_all"] == pytest.approx(1.7)
    assert [content[name] for name in ("mcqi", "enclosed", "held", "max_load_share")] == [None] * 4


def before(kind, without):
    """A message's type as it was before these fields."""
    lines = kind.definition.split("\n")
    end = next((number for number, line in enumerate(lines) if line.startswith("===")), len(lines))
    kept = [line for line in lines[:end] if not re.match(rf"\S+ +({'|'.join(without)})\b", line)]
    assert len(kept) == end - len(without)
    return dataclasses.replace(kind, definition="\n".join(kept + lines[end:]))


def store_of(kind):
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(kind.definition, kind.name))
    return store
