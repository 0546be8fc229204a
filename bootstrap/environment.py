"""Make sure that an environment is there: nothing to do, a few steps, or all of them."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from . import machine
from .errors import SetupError
from .lock import end_leftovers, locked
from .places import Places
from .report import Report
from .state import State, interpreter_of, load
from .steps import KEPT, Step


class Interrupted(BaseException):
    """SIGTERM or SIGHUP during a set-up."""

    def __init__(self, signal_number: int) -> None:
        super().__init__(signal_number)
        self.signal_number = signal_number


def pending(places: Places, steps: Sequence[Step]) -> list[Step]:
    """Steps that are not done, or done for other inputs than today's. Takes a few milliseconds."""
    state = load(places)
    if state is None or unusable(places, state, steps):
        return list(steps)
    return [step for step in steps if state.done.get(step.name) != step.fingerprint(places)]


def unusable(places: Places, state: State | None, steps: Sequence[Step]) -> str:
    """Why an environment has to be made anew, "" if it can be gone on with."""
    if state is None:
        return "nothing is known about it" if places.venv.exists() else "it is not there"
    if state.root != str(places.root):
        return f"it was made for {state.root}, and the repository is now {places.root}"
    interpreter = interpreter_of(places)
    if state.done and (not interpreter or interpreter != state.interpreter):
        return f"its Python was {state.interpreter or 'unknown'} and is now {interpreter or 'missing'}"
    installers = [step for step in steps if step.installs]
    known = {"venv", "packages", "test", "bench", "learning", "cluster", "view"}
    if state.running in {step.name for step in installers} | known:
        return f"it was interrupted at the step '{state.running}'"
    for step in installers:
        if step.name in state.done and state.done[step.name] != step.fingerprint(places):
            return f"the requirements of the step '{step.name}' have changed"
    return ""


def ensure(places: Places, steps: Sequence[Step], report: Report, *, fresh: bool = False) -> bool:
    """Do what is missing for ``steps``, and nothing if nothing is.

    Args:
        places: the environment.
        steps: what is wanted, in order.
        report: tells the user what is done.
        fresh: make the environment anew in any case.

    Returns:
        Whether anything had to be done.

    Raises:
        SetupError: the environment cannot be made.
        Interrupted: by SIGTERM or SIGHUP; what is done stays done.
    """
    if not fresh and not pending(places, steps):
        return False
    with _signals():
        try:
            with locked(
                places.lock, lambda: report.say(f"Another start is setting up {places.venv}; waiting for it to end.")
            ):
                # Somebody else may have done it all in the meantime.
                if fresh or pending(places, steps):
                    _set_up(places, steps, report, fresh)
        except OSError as error:
            where = f" ({error.filename})" if error.filename else ""
            raise SetupError(
                f"{places.venv} cannot be set up: {error.strerror or error}{where}. Look at the disk's free space "
                "and the folder's permissions, or name another folder for the environment: TETHERNET_VENV=/some/folder."
            ) from error
    return True


def _set_up(places: Places, steps: Sequence[Step], report: Report, fresh: bool) -> None:
    """The steps, with the lock held."""
    begin = time.monotonic()
    leftovers = end_leftovers(places.venv)
    state = load(places)
    reason = unusable(places, state, steps)
    if state is None and places.venv.exists() and not _is_own(places.venv):
        raise SetupError(
            f"{places.venv} exists and was not made by this set-up. Move it away, or name another folder "
            "for the environment: TETHERNET_VENV=/some/folder."
        )
    anew = bool(fresh or reason) or state is None
    had: list[Step] = []
    if state is None or anew:
        had = [step for step in KEPT if state and step.name in state.done and step not in steps]
        state = State(root=str(places.root))
    again = [step for step in had if step.at_hand(places)]
    to_do = [step for step in steps if anew or state.done.get(step.name) != step.fingerprint(places)] + again
    found = machine.check(places, compiler=any(step.compiles for step in to_do))
    for step in to_do:
        step.check(places)

    places.log.write_text(f"{time.strftime('%Y-%m-%d %H:%M:%S')}  {found}\n")
    report.say(f"Set-up of {places.venv} ({found})" + ("; a minute or two, this once." if anew else "."))
    if leftovers:
        report.say(f"Ended {leftovers} processes of an interrupted set-up.")
    if anew and places.venv.exists():
        report.say(f"The environment is made anew: {'as asked for' if fresh else reason}.")
    if anew:
        _clear(places)
        places.venv.mkdir(parents=True)
        state.save(places.state)
    report.plan(len(to_do))
    for step in to_do:
        report.begin(step.title)
        wanted = step.fingerprint(places)  # taken before: a change while the step runs leads to its repetition
        state.running = step.name
        state.save(places.state)
        step.run(places, report)
        state.running = ""
        state.done[step.name] = wanted
        state.interpreter = interpreter_of(places)
        state.save(places.state)
        report.end()
    for step in had:
        if step not in again:
            report.say(f"Not in the environment any more: {step.name}; `make {step.name}` installs it anew.")
    report.say(f"Set-up done in {time.monotonic() - begin:.0f} s.")


def _is_own(venv: Path) -> bool:
    """Whether a folder without a readable state may be removed: it is empty, or our state was there and got torn."""
    return not any(venv.iterdir()) or any(venv.glob("setup.json*"))


def _clear(places: Places) -> None:
    """Remove the environment: out of the way first, so that a kill in between leaves no half of it in place."""
    doomed = places.venv.with_name(f"{places.venv.name}.doomed.{os.getpid()}")
    if places.venv.exists():
        places.venv.rename(doomed)
    for old in places.venv.parent.glob(f"{places.venv.name}.doomed.*"):
        shutil.rmtree(old)


@contextlib.contextmanager
def _signals() -> Iterator[None]:
    """Turn SIGTERM and SIGHUP into an exception, so that the running tool is ended too."""

    def interrupt(number: int, frame: object) -> None:
        raise Interrupted(number)

    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    before = {number: handler for number, handler in before.items() if handler is not signal.SIG_IGN}  # of nohup
    for number in before:
        signal.signal(number, interrupt)
    before[signal.SIGINT] = signal.signal(signal.SIGINT, signal.default_int_handler)  # a tool has to be ended
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
