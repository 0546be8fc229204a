"""``run_mission.py`` after the set-up: flies a mission over ROS 2, records it, prints the verdict."""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import mission_start

    mission_start()

import json
import os
import shlex
import subprocess
import sys
import time
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tethernet_bringup.bags.run_info import DESCRIPTION
from tethernet_bringup.mission import arguments
from tethernet_bringup.mission.interrupts import Interrupts
from tethernet_bringup.mission.look_on import look_on
from tethernet_bringup.mission.outcome import (
    FILE_NAME,
    ExitStatus,
    FlightRecord,
    build,
    exit_status,
    verdict,
    write,
)
from tethernet_bringup.mission.outcome_text import describe
from tethernet_bringup.mission.run_folder import keep_traceback
from tethernet_bringup.view.live import View
from tethernet_core.command import complain, explain, let_go_of_closed_streams
from tethernet_core.errors import FaultError, InputError
from tethernet_core.hold import conditions
from tethernet_core.quiet_start import open_standard_streams
from tethernet_ros import topics

if TYPE_CHECKING:
    from argparse import Namespace

    from tethernet_bringup.mission.conductor import Flight
    from tethernet_bringup.mission.live_display import Display
    from tethernet_bringup.mission.parameters import MissionSetup
    from tethernet_bringup.mission.run_folder import RunFolder


def main(argv: Sequence[str] | None = None) -> int:
    """Fly a mission.

    Args:
        argv: the words of the command line after the program's name; default: this process'.

    Returns:
        Exit status, see :class:`tethernet_bringup.mission.outcome.ExitStatus`.
    """
    began = time.monotonic()
    open_standard_streams()
    with Interrupts() as interrupts:
        try:
            options = arguments.parse(sys.argv[1:] if argv is None else argv)
        except SystemExit as exit_:
            status = int(exit_.code or 0)
        else:
            if hasattr(sys.stdout, "reconfigure"):  # a folder's name may hold what the terminal cannot show
                sys.stdout.reconfigure(errors="backslashreplace")
            status = ExitStatus.CAPTURED if options.setup_only else _run(options, interrupts, began)
        let_go_of_closed_streams()
    return int(status)


def _run(options: Namespace, interrupts: Interrupts, began: float) -> ExitStatus:
    from tethernet_bringup.mission.live_display import Display
    from tethernet_bringup.mission.parameters import MissionParametersError, resolve
    from tethernet_bringup.mission.run_folder import RunFolderError, make_run_folder

    try:
        setup = resolve(options)
        view = None if options.view is None else View(options.view)
    except (MissionParametersError, InputError) as error:
        return _refuse(ExitStatus.USAGE, str(error))
    except FaultError as error:
        return _refuse(ExitStatus.FAULT, str(error))
    interrupts.hold()  # from here on there is something to leave in order
    try:
        folder = make_run_folder(options.output, setup.system.name, setup.scenario.seed)
    except RunFolderError as error:
        return _refuse(ExitStatus.USAGE if error.usage else ExitStatus.FAULT, str(error))
    display = Display(sys.stdout, setup.supervisor.report_period_s)
    record = FlightRecord(system=setup.system, seed=setup.scenario.seed, policy=setup.policy, commit=_commit())
    flight = None
    try:
        flight = _fly(options, setup, folder, record, interrupts, display, began, view)
    except FaultError as error:
        record.faults.append(str(error))
    except OSError as error:
        record.faults.append(f"cannot prepare the mission under {folder.path}: {explain(error)}")
    except Exception as error:  # not foreseen: end in order all the same, and keep what a developer needs
        record.faults.append(keep_traceback(error, folder.logs))
    status = _report(record, folder, display)
    if flight is not None:
        flight.leave(status)
    if view is not None:
        view.leave(display, interrupts)
    return status


def _fly(
    options: Namespace,
    setup: MissionSetup,
    folder: RunFolder,
    record: FlightRecord,
    interrupts: Interrupts,
    display: Display,
    began: float,
    view: View | None,
) -> Flight:
    """Fly the mission; what comes of it goes into the record. The flight returned has yet to leave the graph."""
    from tethernet_bringup.mission.conductor import Flight
    from tethernet_bringup.mission.dds_profile import use_profile, uses_profile
    from tethernet_bringup.mission.flight_plan import FlightPlan
    from tethernet_bringup.mission.graph import exclusive_topics
    from tethernet_bringup.mission.processes import mission_processes, prepare_forking
    from tethernet_bringup.mission.supervisor import Supervisor, mission_environment
    from tethernet_bringup.recorder.recording import sign_of_life

    folder.system.write_text(setup.system.to_yaml(), encoding="utf-8")
    setup = setup.recorded_in(folder.bag, folder.run_info, folder.system)
    if view is not None:
        setup = setup.shown_in(view.begin(setup.view_memory_mb, folder.logs))
    parameters = setup.yaml()
    folder.parameters.write_text(parameters, encoding="utf-8")
    facts = _facts(setup, parameters, record.commit)
    folder.run_info.write_text(json.dumps(facts, indent=2) + "\n", encoding="utf-8")
    for notice in (*options.notices, folder.shortage()):
        if notice:
            display.note(f"note: {notice}")
    display.note(_banner(setup, options, folder))
    if view is not None:
        display.note(view.told)
    # This process is part of the graph too: it finds the nodes under the same environment.
    environment = mission_environment(options.domain_id, options.discovery, folder.logs)
    protected = uses_profile(environment)
    exclusive = exclusive_topics(setup.system, setup.external, setup.simulated)
    partition = f"mission-{uuid.uuid4().hex}"
    aside = use_profile(environment, folder.path, partition, exclusive, shared_memory=False) if view else None
    environment = use_profile(environment, folder.path, partition, exclusive)
    os.environ.pop("ROS_LOCALHOST_ONLY", None)
    os.environ.update(environment)
    plan = FlightPlan(
        processes=mission_processes(setup, folder, aside),
        system=setup.system,
        external=setup.external,
        simulated=setup.simulated,
        domain_id=options.domain_id,
        external_timeout_s=options.external_timeout,
        parameters=setup.patience,
        control=setup.control,
        longest_s=setup.longest_s,
        protected=protected,
        ask_recorder=sign_of_life(folder.path),
    )
    prepare_forking(folder)
    with Supervisor(folder.logs, environment, setup.supervisor) as supervisor:
        flight = Flight(plan, supervisor, interrupts, record, display, began)
        flight.fly()
    # Digests of a hundred source files take most of a second: found out when no node waits for a core any more, and
    # where nobody waits for the end.
    if not (record.interrupted_by or record.faults):
        for notice in filter(None, stale_cards(setup)):
            display.note(f"note: {notice}")
    return flight


def stale_cards(setup: MissionSetup) -> list[str]:
    """Why the figures given of the shipped models do not hold for what flies here; empty texts where they do."""
    from tethernet_learning import measured
    from tethernet_planner import policies
    from tethernet_planner import predictors as prediction
    from tethernet_planner.inference import shipped_models

    flies = {
        shipped_models.POLICY: setup.policy == policies.RL,
        shipped_models.SURROGATE: setup.nodes["assessor"].get("predictor") == prediction.SURROGATE,
    }
    return [measured.stale(kind, setup.system) for kind, chosen in flies.items() if chosen]


def _report(record: FlightRecord, folder: RunFolder, display: Display) -> ExitStatus:
    """Write and say how the mission went, whatever that was."""
    from tethernet_bringup.recorder.recording import faults, problems, recorded_messages

    try:
        record.messages = recorded_messages(folder.path, folder.bag)
        if record.launched and not record.faults:
            found = faults(folder.path, folder.bag)
            (record.warnings if record.interrupted_by else record.faults).extend(found)
            record.warnings += problems(folder.path)
        build(record)
    except Exception as error:
        record.faults.append(keep_traceback(error, folder.logs))
        record.forget_what_was_heard()
    try:
        write(folder.path, build(record))
    except OSError as error:
        record.faults.append(f"cannot write {folder.path / FILE_NAME}: {error.strerror or error}")
    command = f"python analyse_mission.py {shlex.quote(str(folder.path))}"
    display.note("\n".join(describe(record, build(record), folder.path, command)))
    status = exit_status(record)
    if status == ExitStatus.FAULT:
        for reason in record.faults or [verdict(record)]:
            _refuse(status, reason)
    return status


def _facts(setup: MissionSetup, parameters: str, commit: str) -> dict[str, str]:
    """What the recording says of itself."""
    return {
        "seed": str(setup.scenario.seed),
        "commit": commit,
        "mus": str(setup.system.unit_count),
        "system": setup.system.name,
        "system_digest": setup.system.digest,
        DESCRIPTION: setup.system.to_yaml(),
        "policy": setup.policy,
        **{f"{name}_model": digest for name, digest in setup.models.items()},
        "pace": setup.scenario.pace,
        "simulated": str(setup.simulated).lower(),
        "external_mus": " ".join(map(str, setup.external)),
        "parameters": parameters,
    }


def _banner(setup: MissionSetup, options: Namespace, folder: RunFolder) -> str:
    scenario = setup.scenario
    x, y, z = scenario.debris_position
    place = f"debris at ({x:g}, {y:g}, {z:g}) m"
    what = f"{setup.system.name}, {_units(setup)}"
    lines = [f"mission: {what}, {place}, policy {setup.policy}, seed {scenario.seed}, {scenario.pace}"]
    if setup.hold_s:
        lines.append(f"hold test: {conditions(setup.hold_s, setup.tow_n)}")
    if setup.external:
        which = "all units, no simulator" if not setup.simulated else ", ".join(f"MU {mu}" for mu in setup.external)
        lines.append(f"external: {which}")
    domain = options.domain_id
    topic = topics.mu_thrust(1) if setup.system.units else topics.DEBRIS_ODOMETRY
    lines.append(f"ROS 2: domain {domain}, discovery {options.discovery}; {look_on(topic, domain)}")
    lines.append(f"run: {folder.path}")
    return "\n".join(lines)


def _units(setup: MissionSetup) -> str:
    count = setup.system.unit_count
    return f"{count} unit{'s' if count != 1 else ''}" if count else "no units"


def _refuse(status: ExitStatus, reason: str) -> ExitStatus:
    complain(f"{'error' if status == ExitStatus.USAGE else 'fault'}: {reason}", arguments.PROGRAM)
    return status


def _commit() -> str:
    """The commit of these sources, with "-dirty" where they were changed since; "unknown" without git."""
    try:
        done = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=40", "--exclude", "*"],
            cwd=Path(__file__).resolve().parent, capture_output=True, text=True, timeout=5.0, check=True,
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return done.stdout.strip() or "unknown"


if __name__ == "__main__":
    raise SystemExit(main())
