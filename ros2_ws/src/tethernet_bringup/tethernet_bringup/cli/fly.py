"""``tethernet fly``: one mission in this process, without ROS."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tethernet_core.atomic_file import write_text
from tethernet_core.command import FAULT
from tethernet_core.errors import InputError
from tethernet_core.hold import conditions
from tethernet_core.subcommand import Parser, Subcommand, number, whole_number
from tethernet_core.system import System
from tethernet_core.system.option import add_system, chosen_system
from tethernet_learning import flight_settings
from tethernet_learning.campaigns.cases import Case, aim, as_flown
from tethernet_learning.campaigns.records import plain
from tethernet_sim.fly import fly_many
from tethernet_sim.scenario import FAILURES, Failure, Outcome, Scenario

NOT_CAPTURED = 3
FARTHEST = 1e6


def run(options: argparse.Namespace) -> int:
    """Fly, print, write."""
    system = chosen_system(options)
    flights = flight_settings.flights_of(flight_settings.replaced(options), [system], options.control == "paper")
    if options.json is not None and not options.json.absolute().parent.is_dir():
        raise InputError(f"--json {options.json}: its folder does not exist")
    [case] = aim([Case(_scenario(options, system), "fly")], options.policy)
    if case.error:
        raise InputError(f"--policy {case.policy}: {case.error}")
    [case] = as_flown([case], flights)
    [outcome] = fly_many([case.scenario], flights[system].settings)
    print(_report(outcome, case.policy))
    if options.json is not None:
        content = {"policy": case.policy, "scenario": case.scenario.record(), "outcome": asdict(outcome)}
        write_text(options.json, json.dumps(plain(content), indent=2, allow_nan=False) + "\n")
    if outcome.error:
        return FAULT
    return 0 if outcome.captured else NOT_CAPTURED


def _scenario(options: argparse.Namespace, system: System) -> Scenario:
    """The default scenario, with what is given in the place of its values."""
    given = {
        "debris_position": options.debris, "debris_attitude": options.attitude, "debris_rate": options.tumble,
        "seed": options.seed,
    }  # fmt: skip
    values: dict[str, Any] = {
        name: value if name == "seed" else tuple(value) for name, value in given.items() if value is not None
    }
    try:
        if options.lose is not None:
            unit, kind, time_s = options.lose
            values["failure"] = Failure(int(unit), kind, float(time_s))
        return Scenario(system, **values)
    except ValueError as error:
        raise InputError(str(error)) from error


def _report(outcome: Outcome, policy: str) -> str:
    if outcome.error:
        return f"the simulation failed: {outcome.error}"
    times = f"{outcome.end_time_s:.1f} s after launch"
    if outcome.trigger_time_s is not None:
        times += f"; the net closed from {outcome.trigger_time_s:.1f} s on"
    lines = [f"{'CAPTURED' if outcome.captured else 'NOT CAPTURED'}   {outcome.verdict}"]
    if outcome.held is not None:
        # A mission that was missed never got to its hold test.
        how = f" ({conditions(outcome.hold_s, outcome.tow_n)})" if outcome.trigger_time_s is not None else ""
        lines.append(f"{'HELD' if outcome.held else 'NOT HELD'}   {outcome.hold_verdict}{how}")
    rows = [
        ("end", times),
        ("locked pairs", str(outcome.locked_pairs)),
        ("CQI", f"{outcome.cqi:.2f} (units counted: {outcome.cqi_all:.2f})"),
        ("MCQI", f"{outcome.mcqi:.2f}"),
        ("enclosed", "the closed net goes round the whole debris" if outcome.enclosed else "no"),
        (
            "largest loads",
            f"{100.0 * outcome.max_load_share:.1f} % of a thread's strength, "
            f"{outcome.max_contact_force_n:.0f} N of contact on the debris",
        ),
        ("net to debris", f"{outcome.net_debris_distance_m:.2f} m between the centres of mass"),
    ]
    if outcome.fuel_kg:
        each = ", ".join(f"{fuel:.4f}" for fuel in outcome.fuel_kg)
        rows[3:3] = [
            ("fuel", f"{sum(outcome.fuel_kg):.4f} kg in all; of each unit {each}"),
            ("aiming", policy),
            ("tracking error", f"at most {outcome.max_tracking_error_m:.2f} m"),
        ]
    return "\n".join([*lines, *(f"  {name:<15} {value}" for name, value in rows)])


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    position = number(-FARTHEST, FARTHEST, "m")
    add_system(parser, required=False)
    add("--debris", nargs=3, type=position, metavar=("X", "Y", "Z"), help="debris' centre of mass [m]; default 0 0 -50")
    add(
        "--attitude", nargs=4, type=number(-1.0, 1.0), metavar=("QX", "QY", "QZ", "QW"),
        help="debris' attitude, a unit quaternion, body to launch; default: long axis along the net's diagonal",
    )  # fmt: skip
    add(
        "--tumble", nargs=3, type=number(-1e3, 1e3, "rad/s"), metavar=("WX", "WY", "WZ"),
        help="debris' angular rate [rad/s], body frame; default 0 0 0",
    )  # fmt: skip
    add("--seed", type=whole_number(0), metavar="N", help="of the sensor noise; default 1")
    add(
        "--lose", nargs=3, metavar=("UNIT", "HOW", "S"),
        help=f"a unit that is lost this long after launch [s]; HOW is {', '.join(FAILURES)}",
    )  # fmt: skip
    flight_settings.add_flight(parser)
    add("--json", type=Path, metavar="FILE", help="scenario and outcome, with every number")


COMMAND = Subcommand(
    "Fly one mission in this process: physics, control, mission rules and capture test are those of a mission over ROS "
    "2, and so is every number. Many missions: tethernet campaign.",
    ("--mus 8", "--system zenit_4mu --debris 3 -4 -47.5 --tumble 0 0 0.05 --policy nominal --json flown.json"),
    run, _add_arguments,
    exit_status="exit status: 0 captured, 3 flown but not captured, 2 bad usage, 1 a fault, 130 interrupted",
)  # fmt: skip
