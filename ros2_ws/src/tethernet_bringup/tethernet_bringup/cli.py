"""``run_mission.py`` after the set-up: flies a mission over ROS 2, records it, prints the verdict."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import time
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from . import arguments
from .interrupts import Interrupts
from .outcome import ExitStatus, FlightRecord, build, describe, exit_status, write

if TYPE_CHECKING:
    from .progress import Display
    from .run_folder import RunFolder


def main(argv: Sequence[str] | None = None) -> int:
    """Fly a mission.

    Args:
        argv: the words of the command line after the program's name; default: this process'.

    Returns:
        Exit status, see :class:`tethernet_bringup.outcome.ExitStatus`.
    """
    began = time.monotonic()
    try:
        options = arguments.parse(sys.argv[1:] if argv is None else argv)
    except SystemExit as exit_:
        return int(exit_.code or 0)
    if options.setup_only:
        return ExitStatus.CAPTURED
    if hasattr(sys.stdout, "reconfigure"):  # a folder's name may hold what the terminal cannot show
        sys.stdout.reconfigure(errors="backslashreplace")
    with Interrupts() as interrupts:
        status = _run(options, interrupts, began)
    _detach_closed(sys.stdout)
    return int(status)


def _run(options, interrupts: Interrupts, began: float) -> ExitStatus:
    from .dds_profile import use_profile, uses_profile
    from .flight import Flight, FlightPlan
    from .graph import exclusive_topics
    from .mission_parameters import MissionParametersError, resolve
    from .processes import mission_processes
    from .progress import Display
    from .run_folder import RunFolderError, make_run_folder
    from .supervisor import Supervisor, mission_environment

    display = Display(sys.stdout, 2.0)
    try:
        setup = resolve(options)
    except MissionParametersError as error:
        return _refuse(ExitStatus.USAGE, str(error))
    try:
        folder = make_run_folder(options.output, setup.mu_count, setup.scenario.seed)
        commit = _commit()
        setup = setup.recorded_in(folder.bag, folder.run_info)
        folder.parameters.write_text(setup.yaml(), encoding="utf-8")
        folder.run_info.write_text(json.dumps(_facts(setup, commit), indent=2) + "\n", encoding="utf-8")
    except (RunFolderError, OSError) as error:
        return _refuse(ExitStatus.FAULT, str(error))
    display = Display(sys.stdout, setup.supervisor.report_period_s)
    for notice in (*options.notices, folder.shortage()):
        if notice:
            display.note(f"note: {notice}")
    display.note(_banner(setup, options, folder))

    record = FlightRecord(mu_count=setup.mu_count, seed=setup.scenario.seed, policy=setup.policy, commit=commit)
    # This process is part of the graph too: it finds the nodes under the same environment.
    try:
        environment = mission_environment(options.domain_id, options.discovery, folder.logs)
        protected = uses_profile(environment)
        exclusive = exclusive_topics(setup.mu_count, setup.external, setup.simulated)
        environment = use_profile(environment, folder.path, f"mission-{uuid.uuid4().hex}", exclusive)
    except OSError as error:
        return _refuse(ExitStatus.FAULT, f"cannot write under {folder.path}: {error.strerror or error}")
    os.environ.pop("ROS_LOCALHOST_ONLY", None)
    os.environ.update(environment)
    plan = FlightPlan(
        processes=mission_processes(setup, folder),
        mu_count=setup.mu_count,
        external=setup.external,
        simulated=setup.simulated,
        domain_id=options.domain_id,
        external_timeout_s=options.external_timeout,
        parameters=setup.patience,
        protected=protected,
    )
    with Supervisor(folder.logs, environment, setup.supervisor) as supervisor:
        flight = Flight(plan, supervisor, interrupts, record, display, began)
        flight.fly()
    try:
        return _report(record, folder, display)
    finally:
        flight.leave()


def _report(record: FlightRecord, folder: RunFolder, display: Display) -> ExitStatus:
    """Write and tell how the mission went."""
    from .recording import complaints, count_messages

    record.messages = count_messages(folder.bag)
    if record.launched and not record.faults:
        if not record.messages:
            record.faults.append(f"nothing was recorded under {folder.bag}")
        record.warnings += complaints(folder.path)
    content = build(record)
    try:
        write(folder.path, content)
    except OSError as error:
        record.faults.append(f"cannot write {folder.path / 'outcome.json'}: {error.strerror or error}")
    display.note(
        "\n".join(describe(record, content, folder.path, f"python analyse_mission.py {shlex.quote(str(folder.path))}"))
    )
    status = exit_status(record)
    if status == ExitStatus.FAULT:
        _refuse(status, content["verdict"])
    return status


def _facts(setup, commit: str) -> dict[str, str]:
    """What the recording says of itself."""
    return {
        "seed": str(setup.scenario.seed),
        "commit": commit,
        "mus": str(setup.mu_count),
        "policy": setup.policy,
        **{f"{name}_model": digest for name, digest in setup.models.items()},
        "pace": setup.scenario.pace,
        "simulated": str(setup.simulated).lower(),
        "external_mus": " ".join(map(str, setup.external)),
        "parameters": setup.yaml(),
    }


def _banner(setup, options, folder) -> str:
    scenario = setup.scenario
    x, y, z = scenario.debris_position
    place = f"debris at ({x:g}, {y:g}, {z:g}) m"
    lines = [f"mission: {setup.mu_count} MUs, {place}, policy {setup.policy}, seed {scenario.seed}, {scenario.pace}"]
    if setup.external:
        which = "all MUs, no simulator" if not setup.simulated else ", ".join(f"MU {mu}" for mu in setup.external)
        lines.append(f"external: {which}")
    domain = options.domain_id
    prefix = f"ROS_DOMAIN_ID={domain} " if domain else ""
    lines.append(
        f"ROS 2: domain {domain}, discovery {options.discovery}; look on with  {prefix}ros2 topic echo /mu1/thrust"
    )
    lines.append(f"run: {folder.path}")
    return "\n".join(lines)


def _refuse(status: ExitStatus, reason: str) -> ExitStatus:
    print(
        f"{arguments.PROGRAM}: {'error' if status == ExitStatus.USAGE else 'fault'}: {reason}",
        file=sys.stderr,
        flush=True,
    )
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


def _detach_closed(stream: TextIO) -> None:
    """Keep the interpreter from complaining at its end about a reader that went away."""
    try:
        stream.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


if __name__ == "__main__":
    raise SystemExit(main())
