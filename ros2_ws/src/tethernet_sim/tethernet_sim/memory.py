"""What a flight takes of the machine's memory: how many scenarios can be flown together, and whether one can."""

from __future__ import annotations

import resource
from pathlib import Path

from tethernet_core.parameters import ParameterError
from tethernet_sim import cores
from tethernet_sim.kernels.crossing_work import RECORD, room
from tethernet_sim.model import Model
from tethernet_sim.settings import THREADS
from tethernet_sim.state import crossed_room

SHARE = 0.5
"""Of the free memory that the scenarios of one process may take: others run beside it, and what observes a flight keeps
samples."""
_DOUBLE = 8  # [bytes]
_BODIES, _MU = 2 * 13, 64  # numbers of debris and chaser, and of a unit with its controller and its commands
_WORK = 512
"""Work space of the kernels for each particle, thread and contact [bytes]: more than any of them allocates."""
_PAIR = 320
"""Of a pair of threads that are near each other [bytes], likewise."""
_LIMITS = (
    (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory.current")),
    (Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"), Path("/sys/fs/cgroup/memory/memory.usage_in_bytes")),
)
"""What a container may use and uses."""


def scenario_bytes(model: Model) -> int:
    """State of one scenario, see :class:`~tethernet_sim.state.State`, and what its controllers keep [bytes]."""
    units, pairs = len(model.arrays.mu_knot), len(model.arrays.pairs)
    numbers = 2 * 3 * model.numbers.knots + _MU * units + _BODIES + 3 * model.contact_count + 2 * pairs
    return _DOUBLE * (numbers + model.winch_threads + crossed_room(model) * RECORD)


def work_bytes(model: Model) -> int:
    """Work space of the kernels on one core, whatever the number of scenarios [bytes]."""
    crossing = len(model.arrays.crossing_threads.ends)
    pairs = _PAIR * room(crossing, crossed_room(model))
    return pairs + _WORK * (len(model.arrays.inverse_mass) + len(model.arrays.threads) + model.contact_count + crossing)


def flight_bytes(model: Model, scenarios: int) -> int:
    """What so many scenarios that are flown together take, on all cores of this process [bytes]."""
    return scenarios * scenario_bytes(model) + min(scenarios, cores.count()) * work_bytes(model)


def free_bytes() -> int:
    """Memory that this process can still take [bytes]: of the machine, its container and its own limit."""
    free = [_available()]
    for limit, used in _LIMITS:
        try:
            free.append(int(limit.read_text(encoding="ascii")) - int(used.read_text(encoding="ascii")))
        except (OSError, ValueError):  # no such container, or "max"
            continue
    own, _ = resource.getrlimit(resource.RLIMIT_AS)
    if own != resource.RLIM_INFINITY:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        free.append(own - pages * resource.getpagesize())
    return max(0, min(free))


def _available() -> int:
    for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
        if line.startswith("MemAvailable:"):
            return int(line.split()[1]) * 1024
    return 0


def allowed_bytes() -> int:
    """What the scenarios of this process may take now [bytes]."""
    return int(SHARE * free_bytes())


def most_scenarios(model: Model, wanted: int, name: str) -> int:
    """How many scenarios of those that are wanted can be flown together now.

    Args:
        model: of their system.
        wanted: at least 1.
        name: of the system, for the error.

    Raises:
        ParameterError: when not even one can: it names the entries that the memory is for.
    """
    allowed = allowed_bytes()
    fitting = wanted
    while fitting > 1 and flight_bytes(model, fitting) > allowed:
        fitting = (fitting + 1) // 2
    check_memory(model, fitting, name, allowed)
    return fitting


def check_memory(model: Model, scenarios: int, name: str, allowed: int | None = None) -> None:
    """Make sure that so many scenarios can be flown together.

    Raises:
        ParameterError: naming the entries that the memory is for, the bytes that are needed and those allowed.
    """
    allowed = allowed_bytes() if allowed is None else allowed
    needed = flight_bytes(model, scenarios)
    if needed <= allowed:
        return
    entries, advice = f"net: {model.numbers.knots} nodes", "a smaller net"
    if len(model.arrays.segments):
        entries += f", physics.contact: {THREADS}, {model.contact_count} contacts with the parts of debris.shape"
        advice += ", contact of knots, or a shape of fewer parts"
    if len(model.arrays.crossing_threads.ends):
        entries += f", physics.net_contact: {THREADS}"
        advice += ", without contact of net with net"
    together = "" if scenarios == 1 else f" for {scenarios} scenarios together"
    raise ParameterError(
        f"system {name}: {entries}: {needed} bytes needed{together}; allowed: {allowed}, half of what is free; "
        f"fly {advice}" + ("" if scenarios == 1 else ", or fewer scenarios together")
    )
