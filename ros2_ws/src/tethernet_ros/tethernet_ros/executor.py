"""The one way a node of this project runs: made, spun, stopped, with an exit status that tells how it went.

The executor is chosen here and nowhere else. rclpy's EventsExecutor needs half the CPU time of the
SingleThreadedExecutor for one small message (62 against 155 microseconds, measured with rclpy 7.1.6). Its ``spin()``
never fires in that release, and neither does ``spin_until_future_complete()`` without a time limit; with one, all
works: timers, services, signals, exceptions. It is also 20 % cheaper than ``spin_once()`` in a loop, which stops after
every callback. The MultiThreadedExecutor is never used: it loses replies.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from threading import Thread
from typing import TypeVar

import rclpy
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions, install_signal_handlers
from rclpy.task import Future
from rclpy.utilities import remove_ros_args

from tethernet_core.parameters import ParameterError
from tethernet_ros import stop_request
from tethernet_ros.connections import serve_connections
from tethernet_ros.start_gate import pass_gate

EXECUTOR_VARIABLE = "TETHERNET_EXECUTOR"
"""Environment variable that chooses the executor: ``events`` (default) or ``single``."""

STOPPED, FAULT, USAGE = 0, 1, 2
"""Exit statuses: stopped on request (signal), stopped by a fault, started with bad parameters or arguments."""

LEAVE_S = 5.0
_SPIN_S = 1.0  # [s] the EventsExecutor only fires when spun with a time limit
_SIGNAL_LOOK_S = 0.02

_Made = TypeVar("_Made", bound=Node)

_initialised = False


def make_executor() -> Executor:
    """The executor all nodes use: events where rclpy has it (7.1.4 and later), else single-threaded.

    Raises:
        ParameterError: when the environment variable asks for an unknown one.
    """
    wanted = os.environ.get(EXECUTOR_VARIABLE, "events")
    if wanted not in ("events", "single"):
        raise ParameterError(f"{EXECUTOR_VARIABLE}={wanted!r}: no such executor; allowed: events, single")
    if wanted == "events":
        try:
            from rclpy.experimental import EventsExecutor
        except ImportError:
            pass  # an older rclpy
        else:
            return EventsExecutor()
    return SingleThreadedExecutor()


def spin(node: Node) -> None:
    """Run the node's callbacks until rclpy shuts down.

    Raises:
        ExternalShutdownException: on a signal.
        Exception: whatever a callback raised.
    """
    executor = make_executor()
    executor.add_node(node)
    try:
        if isinstance(executor, SingleThreadedExecutor):
            while rclpy.ok() and not stop_request.requests():
                executor.spin_once(timeout_sec=_SPIN_S)
        else:
            while rclpy.ok() and not stop_request.requests():
                executor.spin_until_future_complete(Future(), timeout_sec=_SPIN_S)
    finally:
        # The EventsExecutor holds what it has spun until then: the node would not leave the graph when it is destroyed,
        # and the process would end with the participant's threads in the middle of whatever they do.
        executor.shutdown()


def run(
    make_node: Callable[[], _Made], args: list[str] | None = None, complete: Callable[[_Made], None] | None = None
) -> int:
    """Make a node, spin it until a signal or a fault, clean up.

    Args:
        make_node: called once, after rclpy is initialised.
        args: command line with the program's name; default: this process'.
        complete: what the node still needs when all its endpoints are in the graph, where the others find them
            meanwhile; until it returns the node answers nothing.

    Returns:
        Exit status: 0 stopped by SIGINT or SIGTERM, 1 a fault (logged), 2 bad parameters or arguments (explained on
            stderr). A process that hangs in the middleware when it leaves ends by SIGALRM, see :func:`bound_the_end`,
            or by a SIGTERM that comes meanwhile.
    """
    global _initialised
    args = sys.argv if args is None else args
    program = Path(args[0]).stem if args else "node"
    node = None
    try:
        # rclpy shuts down by itself on both signals, through handlers that are put before these; Python's own
        # KeyboardInterrupt would come in the middle of a callback. While the node is made these only take note, which
        # is looked for before each endpoint: a shutdown would leave its participant behind, and a process that ends
        # with one can die with the lock of a queue in shared memory, on which all others wait.
        signal.signal(signal.SIGINT, _on_signal)
        signal.signal(signal.SIGTERM, _on_signal)
        _refuse_leftovers(args)
        pass_gate()
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        _initialised = True
        node = make_node()
        serve_connections(node)
        if complete is not None:
            complete(node)
        install_signal_handlers(SignalHandlerOptions.ALL)
        gc.freeze()  # what was imported stays: no collection shall walk through it in the middle of a flight
        spin(node)
    except ExternalShutdownException:
        return STOPPED
    except ParameterError as error:
        print(f"{program}: {error}", file=sys.stderr, flush=True)
        return USAGE
    except Exception as error:
        if not _initialised:  # rcl could not parse the arguments or read the parameter file
            print(f"{program}: cannot start with {' '.join(args[1:])}: {error}", file=sys.stderr, flush=True)
            return USAGE
        if not rclpy.ok():
            return STOPPED  # a publisher or a wait set that the shutdown took away under a running callback
        _log_fault(program, node, error)
        return FAULT
    finally:
        # A second signal must not turn a clean end into a traceback; one that is more than a request ends what hangs.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        bound_the_end()
        close_down(node)
    return STOPPED


def enter(name: str, args: list[str], load: Callable[[], object] = lambda: None) -> bool:
    """Let a process into the graph whose node is not spun by :func:`run`, but takes its messages by hand.

    Signals are noted from then on, nothing else: see :mod:`tethernet_ros.stop_request`.

    Args:
        name: of the node, for what is told.
        args: command line with the program's name.
        load: what else it needs that takes time, done before the graph is joined.

    Returns:
        Whether it is in; false where it cannot start, which is then explained on stderr.
    """
    try:
        _refuse_leftovers(args)
        load()
        pass_gate()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, stop_request.note)
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rcl's own errors have no common class
        print(f"{name}: cannot start: {error}", file=sys.stderr, flush=True)
        return False
    return True


def outlast(work: Thread) -> None:
    """Wait, while a node is made or completed, for the end of what another thread does.

    Raises:
        ExternalShutdownException: when a signal asks to stop meanwhile: :func:`run` then leaves the graph at once.
    """
    while work.is_alive():
        stop_request.leave_if_asked()
        work.join(_SIGNAL_LOOK_S)


def bound_the_end() -> None:
    """Let this process live for 5 s more at most, then end it by SIGALRM, which its parent sees: called when only the
    middleware has something left to do.

    Fast DDS 2.14 hangs now and then when many participants leave together: the thread that destroys the participant
    waits for a callback, which waits for a lock that this thread takes again and again, or as told in
    :mod:`tethernet_bringup.mission.dds_profile`. rclpy holds the interpreter's lock meanwhile, so nothing in Python can
    end it.
    """
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, LEAVE_S)


def _on_signal(number: int, frame: object) -> None:
    if not _initialised:
        os._exit(STOPPED)  # nothing to clean up yet
    stop_request.note(number, frame)


def _refuse_leftovers(args: list[str]) -> None:
    left = remove_ros_args(args)[1:]
    if left:
        raise ParameterError(
            f"unexpected argument {' '.join(left)!r}; "
            "parameters are given as --ros-args -p NAME:=VALUE or --ros-args --params-file FILE"
        )


def _log_fault(program: str, node: Node | None, error: Exception) -> None:
    import traceback

    text = "".join(traceback.format_exception(error)).rstrip()
    reason = f"stopped by {type(error).__name__}: {error}"
    if node is None:
        print(f"{program}: {reason}\n{text}", file=sys.stderr, flush=True)
    else:
        node.get_logger().fatal(f"{reason}\n{text}")


def close_down(node: Node | None) -> None:
    """Leave the graph with this node, or with one that was never complete and that nobody holds any more (None)."""
    try:
        if node is not None:
            node.destroy_node()
        else:
            # A signal came while it was made, and left a participant behind that nobody holds. Were the process to end
            # with that, its threads could die with the lock of a queue in shared memory, on which all others then wait.
            gc.collect()
        rclpy.try_shutdown()
    except Exception as error:
        # Everything is over; what remains is the middleware's business. Told, because it should not happen.
        print(f"while closing: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
