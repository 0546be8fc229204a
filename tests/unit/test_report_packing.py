"""Pages: numbers survive being packed, texts from outside stay texts, libraries are the pinned ones."""

from __future__ import annotations

import json
from html.parser import HTMLParser

import numpy as np
import pytest

from bootstrap.places import ROOT
from tethernet_bringup.report import libraries, markup, page
from tethernet_bringup.report.campaign_page import MOST_LISTED, interesting, listed
from tethernet_bringup.report.flight import Flight, size_of
from tethernet_bringup.report.geometry import coarse_knots, coarsened, geometry
from tethernet_bringup.report.packing import LEVELS, pack, unpack
from tethernet_bringup.report.plots import peaks, sampled, times
from tethernet_core.system import load_system, shipped_systems

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(1)>\u2028\"'&"


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.found.append(tag)


def tags(html: str) -> list[str]:
    parser = _Tags()
    parser.feed(html)
    return parser.found


@pytest.mark.parametrize("rows", [1, 2, 300])
def test_packed_numbers_come_back_to_within_half_a_step(rows):
    rng = np.random.default_rng(3)
    values = np.cumsum(rng.normal(size=(rows, 9)), axis=0) * ([1.0, 20.0, 0.1] * 3)
    packed = pack(values, period=3)
    assert json.loads(json.dumps(packed)) == packed
    assert np.abs(unpack(packed) - values).max() <= 0.5 * packed["step"] * (1.0 + 1e-6)
    assert packed["step"] == pytest.approx(
        np.ptp(values.reshape(-1, 3), axis=0).max() / LEVELS, rel=1e-9
    ) or rows == 1  # fmt: skip


def test_missing_numbers_stay_missing_and_a_step_can_be_asked_for():
    values = np.array([[0.0, 1.0], [np.nan, np.inf], [0.25, 1.0]])
    packed = pack(values, finest=0.01)
    assert packed["step"] == 0.01
    back = unpack(packed)
    assert np.isnan(back[1]).all()
    assert back[[0, 2]] == pytest.approx(values[[0, 2]], abs=0.005)
    assert np.isnan(unpack(pack(np.full((4, 2), np.nan)))).all()
    huge = unpack(pack(np.array([[1e308, 1.0], [-1e308, 2.0]])))
    assert np.isnan(huge[:, 0]).all()
    assert huge[:, 1] == pytest.approx([1.0, 2.0])


def test_what_changes_little_takes_few_bytes():
    time = np.arange(800)[:, None]
    smooth = np.sin(0.01 * time + np.arange(300))
    noise = np.random.default_rng(1).normal(size=smooth.shape)
    assert len(pack(smooth, finest=1e-3)["data"]) < 0.35 * len(pack(noise, finest=1e-3)["data"])


def test_series_on_other_times():
    time, value = np.array([1.0, 2.0, 4.0]), np.array([10.0, 20.0, 0.0])
    at = np.array([0.0, 1.0, 1.5, 3.0, 4.0, 5.0])
    assert sampled(at, time, value) == pytest.approx([np.nan, 10.0, 15.0, 10.0, 0.0, np.nan], nan_ok=True)
    assert sampled(at, time, value, hold=True) == pytest.approx([np.nan, 10, 10, 20, 0, 0], nan_ok=True)
    assert np.isnan(sampled(at, np.zeros(0), np.zeros(0))).all()


def test_no_peak_is_lost_between_the_times_of_a_plot():
    time = np.arange(0.0, 100.0, 0.05)
    value = np.zeros(len(time))
    value[777] = 5.0
    at = times(100.0, 0.05)
    assert len(at) <= 1500 + 1
    assert np.nanmax(peaks(at, time, value)) == 5.0
    assert np.nanargmax(peaks(at, time, value)) == np.searchsorted(at, time[777] - 1e-9)


def test_a_thinned_flight_has_half_the_moments_of_the_same_span():
    rng = np.random.default_rng(2)
    flight = Flight("f", "s", 0.0, 0.05, knots=rng.normal(size=(401, 50, 3)), debris=np.ones((401, 7)))
    half = flight.thinned()
    assert (half.count, half.step_s) == (201, 0.1)
    assert half.step_s * (half.count - 1) == pytest.approx(flight.step_s * (flight.count - 1))
    assert size_of(half.content()) < 0.6 * size_of(flight.content())


@pytest.mark.parametrize("name", shipped_systems())
def test_every_shipped_system_can_be_drawn(name):
    system = load_system(name)
    shape = geometry(system)
    assert shape["nodes"] == system.net.node_count
    assert max(shape["threads"]) < shape["nodes"]
    assert len(shape["unitNodes"]) == system.unit_count
    assert len(shape["pairs"]) == 2 * len(system.closing.ring)
    assert max(shape["faces"]) == len(shape["vertices"]) // 3 - 1
    json.dumps(shape, allow_nan=False)
    shown = coarse_knots(system)
    if system.net.grid is None:
        assert shown is None
        return
    coarse = geometry(system, shown)
    assert coarse["nodes"] == len(shown) < 0.35 * system.net.node_count
    ends = np.array(coarse["threads"]).reshape(-1, 2)
    place = system.net.nodes[shown]
    lengths = np.linalg.norm(place[ends[:, 0]] - place[ends[:, 1]], axis=1)
    assert lengths.max() == pytest.approx(2.0 * system.net.grid.mesh_m)
    for unit, node in zip(system.units, coarse["unitNodes"], strict=True):
        assert np.linalg.norm(place[node] - system.net.nodes[unit.node]) <= 1.5 * system.net.grid.mesh_m


def test_a_fine_surface_is_coarsened():
    angle = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.concatenate([np.column_stack([ring, np.full(200, z)]) for z in np.linspace(0.0, 3.0, 100)])
    low = np.arange(99 * 200).reshape(99, 200)
    right = np.roll(low, -1, axis=1)
    halves = [np.stack([low, right, low + 200], -1), np.stack([right, right + 200, low + 200], -1)]
    faces = np.stack(halves).reshape(-1, 3)
    fewer, triangles = coarsened(vertices, faces, 20_000)
    assert len(triangles) <= 20_000 < len(faces)
    assert np.ptp(fewer, axis=0) == pytest.approx(np.ptp(vertices, axis=0), abs=0.05)


def test_hostile_texts_stay_texts():
    made = page.html(
        page.Page(
            HOSTILE, [(HOSTILE, HOSTILE, HOSTILE)], HOSTILE,
            markup.section(HOSTILE, markup.table((HOSTILE, ""), [(HOSTILE, HOSTILE)], name=HOSTILE), name=HOSTILE)
            + markup.details(HOSTILE, markup.block(HOSTILE)) + markup.items([HOSTILE]),
            {"systems": {}, "flights": [], "said": HOSTILE},
        )
    )  # fmt: skip
    plain = page.html(page.Page("a", [("a", "a", "a")], "a", "", {"systems": {}, "flights": []}))
    assert tags(made).count("script") == tags(plain).count("script") == 4
    assert "img" not in tags(made)
    begin = made.index('id="data">') + len('id="data">')
    assert json.loads(made[begin : made.index("</script>", begin)])["said"] == HOSTILE


def test_a_page_asks_for_nothing():
    made = page.html(page.Page("a", [], "", "", {"systems": {}, "flights": []}))
    assert "default-src 'none'" in made
    for word in ("src=", "@import", "url(http", "fetch(", "XMLHttpRequest", "WebSocket"):
        assert word not in made, word
    assert len(made) < 1_300_000


@pytest.mark.parametrize("library", libraries.libraries(), ids=lambda library: library.name)
def test_libraries_are_the_pinned_ones_with_their_licences(library):
    assert {name: libraries.digest(name) for name in library.files} == library.files
    assert f"{library.name}.LICENSE" in library.files
    assert "Permission is hereby granted, free of charge" in library.licence
    assert library.licence.splitlines()[2] in page.html(page.Page("", [], "", "", {}))


def test_libraries_are_those_that_the_requirements_name():
    asked = json.loads((ROOT / "requirements" / "report" / "package.json").read_text())["dependencies"]
    assert {library.name: library.version for library in libraries.libraries()} == asked


def test_missions_that_went_wrong_are_shown_first():
    rows = [{"captured": number % 10 != 3, "error": "e" if number == 33 else ""} for number in range(100)]
    chosen = interesting(rows, 8)
    assert len(chosen) == 8
    assert sum(rows[number]["captured"] for number in chosen) == 4
    assert 33 not in chosen
    assert interesting(rows[:3], 8) == [0, 1, 2]
    many = rows * 100
    places = listed(many)
    assert len(places) == MOST_LISTED
    assert {number for number, row in enumerate(many) if not row["captured"]} <= set(places)
