"""The same scenarios under different settings: what each option of the control is worth, and what winch is best."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np

from tethernet_core.command import INTERRUPTED
from tethernet_core.errors import InputError
from tethernet_core.subcommand import Parser, Subcommand, whole_number
from tethernet_core.system import System, load_system, shipped_systems
from tethernet_core.system.changing import changed
from tethernet_core.system.option import DEFAULT, add_system, chosen_system
from tethernet_learning.campaigns import pictures, provenance
from tethernet_learning.campaigns import variations as sources
from tethernet_learning.campaigns.cases import aim, as_flown
from tethernet_learning.campaigns.columns import rebuild
from tethernet_learning.campaigns.results import Results
from tethernet_learning.campaigns.run import resume
from tethernet_learning.campaigns.statistics import Summary, summarise
from tethernet_learning.flight_settings import Flight, changed_system
from tethernet_planner import policies
from tethernet_sim.fly import Settings
from tethernet_sim.scenario import Outcome

CHUNK = 64
_PAPER_GAINS = {"kp": 10.0, "ki": 6.0, "kd": 6.0}
_FIXED = {"closing_plan": "fixed", "regroup_period_s": 0.0}
_TRACK = ({"closing_law": "track"}, {**_FIXED, "closing_depth_m": 3.5, "closing_duration_s": 8.0})

OPTIONS: dict[str, tuple[bool, dict[str, Any], dict[str, Any]]] = {
    "paper as printed": (True, {}, {}),
    "paper + Kalman filter": (True, {"estimator": "kalman"}, {}),
    "paper + Kalman filter, feed forward, ramp": (
        True, {"estimator": "kalman", "feed_forward": True, "ramp_time_s": 1.0}, {},
    ),
    "paper + these, dead band 0.3 N": (
        True, {"estimator": "kalman", "feed_forward": True, "ramp_time_s": 1.0, "dead_band_n": 0.3}, {},
    ),
    "paper + these, intercept closing, release": (
        True,
        {
            "estimator": "kalman", "feed_forward": True, "ramp_time_s": 1.0, "dead_band_n": 0.3,
            "closing_law": "intercept",
        },
        {"closing_depth_m": 6.0, "closing_duration_s": 13.0, "release_docked": True},
    ),
    "default": (False, {}, {}),
    "default, raw samples": (False, {"estimator": "raw"}, {}),
    "default, gains of the paper": (False, _PAPER_GAINS, {}),
    "default, no feed forward": (False, {"feed_forward": False}, {}),
    "default, no ramp": (False, {"ramp_time_s": 0.0}, {}),
    "default, no follow-through": (False, {"follow_through_m": 0.0}, {}),
    "default, no dead band": (False, {"dead_band_n": 0.0}, {}),
    "default, no anti-windup": (False, {"anti_windup": False}, {}),
    "default, minimum impulse bit 25 mN s": (False, {"minimum_impulse_n_s": 0.025}, {}),
    "default, fixed closing by tracking": (False, *_TRACK),
    "default, fixed closing place": (False, {}, _FIXED),
}  # fmt: skip
"""Name: (start from the paper's control, control, mission)."""

SPEEDS_M_S, TENSIONS_N = (0.5, 0.75, 1.0, 1.5, 2.0), (10.0, 20.0, 30.0, 40.0, 80.0)
STIFFNESSES_N_M = (50.0, 200.0, 1000.0)
"""Of the closing thread, beside the default one, which the map is made with."""


def option_settings(system: System) -> dict[str, Settings]:
    """The settings of each option, by its name."""
    return {
        name: (Settings.paper if printed else Settings.load)(system, control=control, mission=mission)
        for name, (printed, control, mission) in OPTIONS.items()
    }


def winch_systems(system: System) -> dict[str, System]:
    """A system with each winch, by its name: the map of speed and tension, then the thread's stiffness."""
    winches = {
        f"{speed:g} m/s, {tension:g} N": changed(
            system, {"closing.winch.speed_m_s": speed, "closing.winch.tension_n": tension}
        )
        for speed in SPEEDS_M_S
        for tension in TENSIONS_N
    }
    threads = {f"default, {k:g} N/m": changed(system, {"closing.winch.stiffness_n_m": k}) for k in STIFFNESSES_N_M}
    return {**winches, **threads}


def fly(variants: dict[str, tuple[System, Settings]], count: int, seed: int, folder: Path) -> dict[str, Summary] | None:
    """Statistics of every variant with the nominal aiming points, by name, or None when interrupted; see
    :func:`outcomes`.
    """
    flown = outcomes(variants, count, seed, folder)
    return None if flown is None else {name: summarise(of_variant) for name, of_variant in flown.items()}


def outcomes(
    variants: dict[str, tuple[System, Settings]],
    count: int,
    seed: int,
    folder: Path,
    *,
    first: int = 1,
    total: int | None = None,
    chunk: int = CHUNK,
    aimed_by: str = policies.NOMINAL,
    aimed_for: System | None = None,
) -> dict[str, list[Outcome]] | None:
    """Fly every variant, each into a file of its own; what is there already is not flown again.

    Args:
        variants: systems and settings by name.
        count: scenarios of each.
        seed: of the scenarios.
        folder: for the files.
        first: number of the first variant, by which its file is named.
        total: of so many, as progress is reported; None: as many as there are here.
        chunk: so many missions are flown, and kept, at a time.
        aimed_by: the policy.
        aimed_for: the system that it is asked for; None: each variant's own.

    Returns:
        Outcomes by name, in the order of the scenarios, or None when interrupted.

    Raises:
        CampaignError: when a file there was made with other settings or code.
        PolicyError: when the policy cannot be loaded or was made for another system.
    """
    found = {}
    for number, (name, (system, settings)) in enumerate(variants.items(), start=first):
        own = aimed_for or system
        cases = aim(sources.random_positions(own, count, seed, settings.mission), aimed_by)
        cases = as_flown(cases, {own: Flight(system, settings)})
        source = {"name": "sweep", "variant": name, "seed": seed, "scenarios": count}
        file = folder / f"{system.name}_{number:02d}.csv"
        if aimed_by != policies.NOMINAL:
            source["policy"] = policies.fingerprint(aimed_by, own)
            file = folder / f"{system.name}_{number:02d}_{Path(aimed_by).stem}.csv"
        with Results(file, provenance.describe(source, cases, {system: settings})) as results:
            print(f"{number} of {total or len(variants)}: {name}", file=sys.stderr)
            if not results.complete and not resume(results, cases, {system: settings}, chunk):
                return None
            found[name] = [rebuild(Outcome, row) for row in results.rows]
    return found


def mean_pairs(summary: Summary) -> float:
    """Locked pairs of a mission, on average."""
    return sum(pairs * missions for pairs, missions in summary.locked_pairs.items()) / summary.count


def table(found: dict[str, Summary], system: System) -> list[str]:
    """The statistics as lines of a Markdown table."""
    limit = system.closing.max_locked_pairs
    lines = [
        f"| {system.name} | captured | fuel per unit, kg | until the trigger, kg | pairs of {limit}, mean |",
        "|---|---|---|---|---|",
    ]
    for name, summary in found.items():
        pairs = mean_pairs(summary)
        fuel, before = ("-" if e is None else f"{e.value:.4f}" for e in (summary.fuel_kg, summary.fuel_at_trigger_kg))
        lines.append(f"| {name} | {100 * summary.success.value:.0f} % | {fuel} | {before} | {pairs:.1f} |")
    return lines


def draw_winches(found: dict[str, Summary], system: System) -> Any:
    """Success and locked pairs over the winch's speed and tension, as a figure."""
    figure = pictures.new_figure(11.0, 4.6)
    limit, needed = system.closing.max_locked_pairs, system.capture.required_locked_pairs
    shape = len(SPEEDS_M_S), len(TENSIONS_N)
    mapped = list(found.values())[: shape[0] * shape[1]]
    success = np.array([100.0 * s.success.value for s in mapped]).reshape(shape)
    pairs = np.array([mean_pairs(s) for s in mapped]).reshape(shape)
    panels = figure.subplots(1, 2)
    for panel, values, title, low, high in (
        (panels[0], success, "captured [%]", 0.0, 100.0),
        (panels[1], pairs, f"locked pairs of {limit}, mean", 0.5 * needed, float(limit)),
    ):
        image = panel.imshow(values.T, origin="lower", aspect="auto", vmin=low, vmax=high, cmap="viridis")
        panel.set_xticks(range(shape[0]), [f"{v:g}" for v in SPEEDS_M_S])
        panel.set_yticks(range(shape[1]), [f"{t:g}" for t in TENSIONS_N])
        panel.set_xlabel("winch speed [m/s]")
        panel.set_ylabel("largest tension [N]")
        panel.set_title(title)
        for (i, j), value in np.ndenumerate(values):
            dark = value < 0.5 * (low + high)
            panel.text(i, j, f"{value:.3g}", ha="center", va="center", color="white" if dark else "black")
        figure.colorbar(image, ax=panel)
    return figure


def run(options: argparse.Namespace) -> int:
    """Fly, print the table, write it and the picture; gives 130 when interrupted."""
    base = _system(options)
    if options.what == "winch":
        variants = {name: (system, Settings.load(system)) for name, system in winch_systems(base).items()}
    else:
        variants = {name: (base, settings) for name, settings in option_settings(base).items()}
    options.output.mkdir(parents=True, exist_ok=True)
    found = fly(variants, options.scenarios, options.seed, options.output)
    if found is None:
        return INTERRUPTED
    lines = table(found, base)
    (options.output / f"{options.what}_{base.name}.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    if options.what == "winch":
        pictures.save(draw_winches(found, base), options.output / "winch.png")
    print("\n".join(lines))
    return 0


def _system(options: argparse.Namespace) -> System:
    """Raises: InputError: where a sweep of the winch shall fly a system without one."""
    if options.what != "winch":
        return changed_system(options.set, chosen_system(options))
    shipped = [load_system(name) for name in shipped_systems()]
    winched = [system.name for system in shipped if system.closing.kind == "winch"]
    with_units = [name for name in winched if load_system(name).unit_count]
    system = changed_system(options.set, chosen_system(options, (with_units or winched)[0]))
    if system.closing.kind != "winch":
        raise InputError(
            f"--system {system.name}: closes by {system.closing.kind}; allowed with winch: systems that are closed by "
            f"winches, of the shipped ones {', '.join(winched)}"
        )
    return system


def _add_arguments(parser: Parser) -> None:
    add = parser.add_argument
    add("what", choices=("options", "winch"), help="options of the control, or the winch")
    add_system(parser, required=False, default=f"{DEFAULT}; winch: the one that has winches")
    add("--scenarios", type=whole_number(1), default=40, metavar="N", help="of each setting, default 40")
    add("--seed", type=whole_number(0), default=0, metavar="N", help="of the scenarios, default 0")
    add(
        "--set", nargs="+", action="extend", default=[], metavar="system.ENTRY=VALUE",
        help="entries of the description to replace: system.net.thread.damping_ratio=0.05",
    )  # fmt: skip
    add("--output", type=Path, required=True, metavar="FOLDER", help="for outcomes, table and picture")


COMMAND = Subcommand(
    "Fly the same scenarios under different settings: what each option of the control is worth, or how the winch "
    "should reel. Interrupted, the same command goes on.",
    ("options --mus 8 --output sweep", "winch --scenarios 12 --seed 1 --output sweep"), run, _add_arguments,
)  # fmt: skip
