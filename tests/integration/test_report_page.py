"""report.html in a browser: it plays, asks for nothing, says no error, and shows what was flown."""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np
import pytest

from tests import browser, toy_mission
from tethernet_bringup.analysis import report_page
from tethernet_bringup.analysis.mission_data import load
from tethernet_bringup.bags.reader import open_bag
from tethernet_bringup.cli.main import main
from tethernet_bringup.report import page
from tethernet_bringup.report.page import LARGEST_BYTES

TRIGGER_S = toy_mission.TRIGGER_S
HOSTILE = "</script><script>document.title='broken'</script><b id=broken>"


def report_of(bag: Path, folder: Path) -> Path:
    opened = open_bag(bag)
    return report_page.write(load(opened), opened, bag, folder)


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    program = browser.found()
    if program is None:
        pytest.skip(
            f"NOT TESTED: no browser here ({', '.join(browser.NAMES)}); Debian's package: chromium-headless-shell"
        )
    with browser.browser(program, tmp_path_factory.mktemp("profile")) as made:
        yield made


@pytest.fixture
def quiet(chromium):
    """The browser; afterwards it must have said nothing and asked for nothing."""
    chromium.logged.clear()
    chromium.asked.clear()
    yield chromium
    assert chromium.logged == []
    assert chromium.asked == []


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    """A mission with a hold test."""
    folder = tmp_path_factory.mktemp("held")
    toy_mission.write_bag(folder / "bag", end_s=toy_mission.end_of_hold(20.0), hold_s=20.0)
    return report_of(folder, folder)


def pixels(png: bytes) -> np.ndarray:
    """Red, green, blue of a picture, shape (height, width, 3)."""
    from io import BytesIO

    import matplotlib.image

    return matplotlib.image.imread(BytesIO(png))[:, :, :3]


def stage(chromium) -> np.ndarray:
    """The picture of the scene alone."""
    box = chromium.value(
        "(() => { const b = document.querySelector('.stage').getBoundingClientRect();"
        " return [b.left, b.top, b.right, b.bottom].map(Math.round); })()"
    )
    left, top, right, bottom = box
    return pixels(chromium.picture())[top:bottom, left:right]


def drawn_share(picture: np.ndarray) -> float:
    """How much of it is something else than the background."""
    background = picture[picture.shape[0] // 2, 3]
    return float((np.abs(picture - background).max(axis=2) > 0.15).mean())


def differing_share(a: np.ndarray, b: np.ndarray) -> float:
    return float((np.abs(a - b).max(axis=2) > 0.15).mean())


@pytest.mark.parametrize(("width", "dark"), [(390, False), (1200, True)], ids=["narrow-light", "wide-dark"])
def test_the_flight_is_seen_at_trigger_and_end_from_all_cameras(quiet, held, width, dark):
    pictures = {}
    quiet.open(held, width=width, height=900, dark=dark)
    for time in (3.0, TRIGGER_S, 60.0):
        for view in ("beside", "ahead", "chaser"):
            quiet.value(f"report.player.seek({time})")
            quiet.value(f"document.querySelector('[data-view={view}]').click()")
            pictures[time, view] = stage(quiet)
    for (time, view), picture in pictures.items():
        assert drawn_share(picture) > 0.004, (time, view)
    for view in ("beside", "ahead", "chaser"):
        assert differing_share(pictures[TRIGGER_S, view], pictures[60.0, view]) > 0.02
    assert differing_share(pictures[TRIGGER_S, "beside"], pictures[TRIGGER_S, "ahead"]) > 0.02
    assert bool(np.mean(pictures[60.0, "beside"]) < 0.4) is dark
    assert quiet.value("document.documentElement.scrollWidth <= innerWidth")


def test_it_plays_pauses_and_obeys_the_keyboard(quiet, held):
    quiet.open(held, width=1000, height=800)
    assert quiet.value("report.player.time") == pytest.approx(TRIGGER_S, abs=0.06)
    before = stage(quiet)
    quiet.key(" ", "Space")
    assert quiet.value("[report.player.playing, report.player.time < 5]") == [True, True]  # from the launch on
    quiet.value("document.querySelector('[data-part=speed]').value = 8")
    quiet.value("document.querySelector('[data-part=speed]').dispatchEvent(new Event('change'))")
    quiet.wait("report.player.time > 8")
    quiet.key(" ", "Space")
    assert quiet.value("report.player.playing") is False
    stopped = quiet.value("report.player.time")
    assert differing_share(before, stage(quiet)) > 0.02
    assert quiet.value("report.player.time") == stopped
    quiet.key("ArrowRight")
    assert quiet.value("report.player.time") == pytest.approx(stopped + 0.5)
    quiet.key("End")
    end = quiet.value("report.player.time")
    assert end == pytest.approx(toy_mission.end_of_hold(20.0), abs=0.1)
    quiet.key("Home")
    assert quiet.value("report.player.time") == 0.0
    quiet.key("2")
    assert quiet.value("document.querySelector('[data-view=ahead]').getAttribute('aria-pressed')") == "true"
    quiet.value(
        "(() => { const scrub = document.querySelector('[data-part=scrub]'); scrub.value = 12;"
        " scrub.dispatchEvent(new Event('input')); })()"
    )
    assert quiet.value("report.player.time") == pytest.approx(12.0)


def test_who_turns_the_scene_keeps_the_camera(quiet, held):
    quiet.open(held, width=1000, height=800)
    before = stage(quiet)
    box = "document.querySelector('.stage canvas').getBoundingClientRect()"
    x, y = quiet.value(f"[{box}.left + 400, {box}.top + 200]")
    quiet.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", clickCount=1)
    for step in range(1, 6):
        quiet.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + 30 * step, y=y, button="left", buttons=1)
    quiet.call("Input.dispatchMouseEvent", type="mouseReleased", x=x + 150, y=y, button="left", clickCount=1)
    turned = stage(quiet)
    assert differing_share(before, turned) > 0.02
    assert quiet.value("document.querySelectorAll('[data-view][aria-pressed=true]').length") == 0
    distance = "report.stage.view.camera.position.distanceTo(report.stage.view.controls.target)"
    kept = quiet.value(distance)
    quiet.value("report.player.seek(5)")
    assert differing_share(turned, stage(quiet)) > 0.01
    assert quiet.value(distance) == pytest.approx(kept, rel=1e-6)


def test_without_webgl_tables_and_plots_are_complete(held, tmp_path):
    program = browser.found()
    if program is None:
        pytest.skip("NOT TESTED: no browser here")
    with browser.browser(program, tmp_path, "--disable-3d-apis") as blind:
        blind.open(held, width=800, height=800)
        assert "draws no 3-D" in blind.value("document.querySelector('[data-part=message]').textContent")
        assert blind.value("document.querySelectorAll('#plots figure').length") == 7
        assert blind.asked == []


def test_plots_follow_the_time_cursor_and_move_it(quiet, held):
    quiet.open(held, width=1200, height=900)
    titles = quiet.value("[...document.querySelectorAll('#plots figcaption')].map((title) => title.textContent)")
    assert titles[:4] == ["Distance of net and debris", "Position error of the units", "Commanded thrust", "Fuel used"]
    quiet.value("report.player.seek(20)")
    cursors = "[...document.querySelectorAll('.u-over .cursor')].map((c) => new DOMMatrix(c.style.transform).m41)"
    places = quiet.value(cursors)
    widths = quiet.value("[...document.querySelectorAll('.u-over')].map((over) => over.clientWidth)")
    end = quiet.value("report.player.end")
    assert places == pytest.approx([20.0 / end * width for width in widths], abs=1.5)
    legend = "document.querySelectorAll('#plots figure')[3].querySelector('.u-series:nth-child(2) td')"
    fuel = quiet.value(f"{legend}.innerText")
    assert float(fuel.split()[0]) == pytest.approx(1e3 * toy_mission.FUEL_KG_S * 20.0, rel=0.02)
    quiet.value("document.querySelector('.u-over').scrollIntoView()")
    x, y = quiet.value(
        "(() => { const b = document.querySelector('.u-over').getBoundingClientRect();"
        " return [b.left + b.width / 2, b.top + 20]; })()"
    )
    quiet.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", clickCount=1)
    quiet.call("Input.dispatchMouseEvent", type="mouseReleased", x=x, y=y, button="left", clickCount=1)
    assert quiet.value("report.player.time") == pytest.approx(0.5 * end, abs=0.2)


def test_what_the_browser_unpacks_is_where_the_net_was(quiet, held):
    quiet.open(held)
    quiet.value(f"report.player.seek({TRIGGER_S - 5.0})")
    quiet.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    seen = np.array(quiet.value("[...report.stage.points.array]")).reshape(-1, 3)
    assert seen[:529] == pytest.approx(toy_mission.knots(TRIGGER_S - 5.0), abs=0.03)
    for mu in range(1, 9):
        assert seen[528 + mu] == pytest.approx(toy_mission.true_position(mu, TRIGGER_S - 5.0), abs=0.03)


def test_captured_and_held_stand_side_by_side(held):
    text = held.read_text()
    assert "at the verdict" in text
    assert "after the hold test" in text
    assert text.count('class="verdict good"') == 2


@pytest.mark.parametrize(
    ("without", "end_s", "note"),
    [
        (["/net/state"], 26.0, "no /net/state: the net is not drawn"),
        (["/debris/odom", "/chaser/odom"], 26.0, "no /debris/odom: the debris is not drawn"),
        (["/mission/state", "/capture/assessment"], 12.0, "no phases, times count from the first message"),
        ([f"/mu{mu}/{what}" for mu in range(1, 9) for what in ("odom", "thrust", "status")], 26.0, "no thrust"),
    ],
)
def test_what_is_missing_is_said_and_the_rest_is_shown(quiet, tmp_path, without, end_s, note):
    toy_mission.write_bag(tmp_path / "bag", end_s=end_s, without=without)
    made = report_of(tmp_path, tmp_path)
    assert note in made.read_text()
    quiet.open(made, width=700, height=800)
    assert drawn_share(stage(quiet)) > 0.002
    assert quiet.value("document.querySelectorAll('#plots figure').length") >= 1


def test_a_torn_bag_and_a_bag_of_four_units(quiet, tmp_path):
    toy_mission.write_bag(tmp_path / "whole" / "bag", mus=4)
    whole = report_of(tmp_path / "whole", tmp_path / "a")
    content = (tmp_path / "whole" / "bag" / "bag_0.mcap").read_bytes()
    (tmp_path / "torn.mcap").write_bytes(content[: len(content) // 2])
    torn = report_of(tmp_path / "torn.mcap", tmp_path / "b")
    assert "the bag is damaged: torn.mcap" in torn.read_text()
    assert "No verdict" in torn.read_text()
    for made in (whole, torn):
        assert made.stat().st_size < LARGEST_BYTES
        quiet.open(made, width=800, height=800)
        assert drawn_share(stage(quiet)) > 0.004
        assert quiet.value("report.stage.units.length") == 4


def test_a_hostile_reason_does_not_break_out(quiet, tmp_path, monkeypatch):
    toy_mission.write_bag(tmp_path / "bag", end_s=26.0)
    opened = open_bag(tmp_path)
    data = load(opened)
    data.phases = [type(change)(change.time_ns, change.phase, HOSTILE) for change in data.phases]
    data.facts |= {"system": HOSTILE, "policy": HOSTILE, "parameters": f"a: '{HOSTILE}'"}
    made = report_page.write(data, opened, tmp_path, tmp_path)
    quiet.open(made)
    assert quiet.value("document.title").startswith("Capture mission </script>")
    assert quiet.value("document.getElementById('broken')") is None


def test_numbers_that_no_bag_of_ours_would_hold_are_left_out(tmp_path):
    toy_mission.write_bag(tmp_path / "bag", end_s=8.0)
    opened = open_bag(tmp_path)
    data = load(opened)
    data.debris.add(int(data.debris.stamps[-1]) + 50_000_000, 1e300, 0, 0, 0, 0, 0, 1)
    data.mus[2].measured.add(data.end_ns, np.inf, 0, 0)
    data.mus[3].fuel.add(data.end_ns, 1e308)
    data.mus[3].fuel.add(data.end_ns + 1, -1e308)
    data.mus[10**9] = data.mus[1]
    data.facts["system"] = "name \udcff"
    made = report_page.write(data, opened, tmp_path, tmp_path)
    assert made.stat().st_size < LARGEST_BYTES


def test_a_flight_that_is_too_large_is_thinned(tmp_path, monkeypatch):
    toy_mission.write_bag(tmp_path / "bag", end_s=20.0)
    large = report_of(tmp_path, tmp_path / "a").stat().st_size
    monkeypatch.setattr(page, "FLIGHTS_BYTES", 100_000)
    small = report_of(tmp_path, tmp_path / "b").stat().st_size
    assert small < large
    assert small - len(page.html(page.Page("", [], "", "", {}))) < 450_000


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """A small campaign with its page; half of its missions are shown."""
    folder = tmp_path_factory.mktemp("campaign")
    outcomes = folder / "tumble.csv"
    words = ["tumble", "--mus", "4", "--rates", "0", "2", "--axes", "2", "--each", "1", "--policy", "nominal"]
    assert main(["campaign", *words, "--output", str(outcomes)]) == 0
    assert main(["campaign", "report", str(outcomes), "--flights", "2"]) == 0
    return folder / "tumble.html"


def test_a_campaign_shows_the_flights_that_it_has(quiet, campaign):
    assert campaign.stat().st_size < LARGEST_BYTES
    quiet.open(campaign, width=1100, height=900)
    quiet.wait("document.querySelectorAll('.list tbody tr').length === 4")
    assert quiet.value("document.querySelectorAll('.maps figure').length") == 2  # places and tumbling
    assert quiet.value("document.querySelectorAll('.dot.flight').length") == 3  # one of the two does not tumble
    first = stage(quiet)
    assert drawn_share(first) > 0.004
    choose = "[...document.querySelectorAll('.list tr.flight button')].at(-1).click()"
    chosen = "document.querySelector('[data-part=chosen]').textContent"
    before = quiet.value(chosen)
    quiet.value(choose)
    quiet.wait(f"{chosen} !== {before!r}")
    quiet.value("report.player.seek(report.player.end)")
    assert differing_share(first, stage(quiet)) > 0.02


def test_a_mission_without_a_flight_says_how_to_get_it(quiet, campaign):
    quiet.open(campaign, width=1100, height=900)
    quiet.wait("document.querySelectorAll('.list tbody tr').length === 4")
    quiet.value("document.querySelector('.list tbody tr:not(.flight) button').click()")
    command = quiet.value("document.querySelector('[data-part=command]').textContent").split()
    assert quiet.value("document.querySelector('[data-part=flown]').hidden") is True
    assert command[:3] == ["tethernet", "campaign", "report"]
    again = campaign.with_name("again.html")
    assert main([*command[1:], "--output", str(again)]) == 0
    quiet.open(again)
    quiet.wait(f"document.querySelector('.list tr.chosen button')?.textContent === '{command[-1]}'")
    assert quiet.value("document.querySelector('[data-part=flown]').hidden") is False


def test_a_mission_flown_again_ends_as_it_did(campaign):
    assert "flown again for this page" not in campaign.read_text()


def test_a_number_that_there_is_not_is_refused(campaign, capsys):
    assert main(["campaign", "report", str(campaign.with_suffix(".csv")), "--missions", "9"]) == 2
    assert "--missions 9: there are 4; allowed: 1 to 4" in capsys.readouterr().err


def test_the_browser_would_be_told_of_an_error(chromium, tmp_path):
    """The checks above could find something."""
    bad = tmp_path / "bad.html"
    bad.write_text(
        "<script>document.documentElement.dataset.state = 'ready'; fetch('http://127.0.0.1:9/').catch(() => 0);"
        "setTimeout(() => { throw new Error('x') })</script>"
    )
    chromium.open(bad)
    chromium.wait("true")
    chromium.value("new Promise((done) => setTimeout(done, 200))")
    assert chromium.asked == ["http://127.0.0.1:9/"]
    assert any("Error: x" in line for line in chromium.logged)
    assert zlib.crc32(chromium.picture()) != 0
