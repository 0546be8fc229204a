"""``tethernet campaign report``: a campaign as one page that anybody can open."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tethernet_core.subcommand import Parser, Subcommand, whole_number
from tethernet_core.system import load_system
from tethernet_learning.campaigns.errors import CampaignError

FLIGHTS = 24


def run(options: argparse.Namespace) -> None:
    """Fly what is to be shown, write the page."""
    from tethernet_bringup.report import campaign_page
    from tethernet_bringup.report.campaign_flights import fly_again, settings_of
    from tethernet_learning.campaigns import report, scenario_file

    output = options.output or options.files[0].with_suffix(".html")
    if not output.absolute().parent.is_dir():
        raise CampaignError(f"--output {output}: its folder does not exist; make it first")
    given = [load_system(name) for name in options.system]
    rows = report.read(options.files)
    cases_of = [scenario_file.read(file, given) for file in options.files]
    cases = [case for cases in cases_of for case in cases]
    numbers = _chosen(options.missions, len(cases)) or campaign_page.interesting(rows, options.flights)
    flown = fly_again(
        numbers, cases, settings_of(options.files, cases_of),
        lambda done, total: print(f"{done} of {total} missions flown once more, to be shown", file=sys.stderr),
    )  # fmt: skip
    systems = [case.scenario.system for case in cases]
    try:
        count = campaign_page.write(rows, systems, flown, options.files, output)
    except OSError as error:
        raise CampaignError(f"--output {output} cannot be written: {error.strerror}") from error
    print(f"{output}: {len(rows)} missions, {count} with their flight")


def _chosen(numbers: list[int] | None, count: int) -> list[int]:
    """Places of the missions that are asked for.

    Raises:
        CampaignError: for a number that there is not.
    """
    for number in numbers or []:
        if number > count:
            raise CampaignError(f"--missions {number}: there are {count}; allowed: 1 to {count}")
    return [number - 1 for number in dict.fromkeys(numbers or [])]


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add("files", type=Path, nargs="+", metavar="FILE", help="outcomes, .parquet or .csv")
    add("--output", type=Path, metavar="PAGE", help="default: the first file's name with .html")
    add(
        "--flights", type=whole_number(0), default=FLIGHTS, metavar="N",
        help=f"missions that are flown once more, to be shown: up to half of them went wrong; default {FLIGHTS}",
    )  # fmt: skip
    add("--missions", type=whole_number(1), nargs="+", metavar="N", help="show these, by their numbers on the page")
    add("--system", nargs="+", default=[], metavar="NAME|FILE", help="own systems that were flown")


COMMAND = Subcommand(
    "Make a page of a campaign: statistics, maps, a list of all missions, and flights to look at in 3-D. One HTML file "
    "below 6 MB, which needs no network.",
    ("random.parquet", "loss.csv --missions 7 12 --output loss.html"), run, _add_arguments,
    "Flights are not kept in outcomes files: those that the page shows are flown once more, with the settings that lie "
    "beside the file.",
)  # fmt: skip
