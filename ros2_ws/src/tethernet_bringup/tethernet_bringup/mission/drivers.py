"""What is heard of the drivers of external MUs: whether they keep the driver contract, and in flight whether they live.

Judged by messages, not by the graph: that somebody publishes a topic says neither that anything comes nor what.
"""

from __future__ import annotations

import sys
import time
from collections import deque
from collections.abc import Callable, Iterable

from tethernet_control.driver_contract import Sample, obstacle
from tethernet_core.settings import ControlParameters
from tethernet_ros.topics import CLOCK, FRAME, mu_odometry

_JUDGED_S = 2.0
"""[s] so much of the newest odometry is judged: a driver may put itself right."""


class DriverWatch:
    """Collects the odometry of external MUs and says what keeps each of them on the ground."""

    def __init__(
        self,
        mus: Iterable[int],
        control: ControlParameters,
        waiting: bool,
        clock: Callable[[], float] = time.monotonic,
    ):
        """Args:
        mus: the external MUs.
        control: gives period and watchdog.
        waiting: whether the mission's clock waits for the launch, as a simulator's does: then one sample says all.
        clock: wall time [s].
        """
        self._control, self._waiting, self._wall_clock = control, waiting, clock
        length = 1 if waiting else round(_JUDGED_S / control.control_period_s)
        self.mus = tuple(mus)
        self._samples: dict[int, deque[Sample]] = {mu: deque(maxlen=length) for mu in self.mus}
        self._enough = length
        self._held_ns = control.held_ns
        self._bad_since: dict[int, float] = {}
        self._fallen_silent: set[int] = set()

    @property
    def silent(self) -> list[int]:
        """MUs of which nothing has come."""
        return [mu for mu, samples in self._samples.items() if not samples]

    def saw(self, mu: int, sample: Sample) -> None:
        """A message of this MU's driver has come."""
        self._samples[mu].append(sample)

    def obstacles(self) -> dict[int, str]:
        """What keeps MUs on the ground, of those that are heard; an empty text: not heard for long enough."""
        found = {}
        for mu, samples in self._samples.items():
            if not samples:
                continue
            why = obstacle(mu, list(samples), FRAME, self._control, self._waiting or len(samples) < 2)
            if why or len(samples) < self._enough:
                found[mu] = why
            if why:
                self._bad_since.setdefault(mu, self._wall_clock())
            else:
                self._bad_since.pop(mu, None)
        return found

    def bad_for_s(self, mu: int) -> float:
        """How long this MU has been kept on the ground by what its driver says, without a break [s]."""
        since = self._bad_since.get(mu)
        return 0.0 if since is None else self._wall_clock() - since

    def changes(self, now_ns: int) -> list[tuple[int, bool]]:
        """MUs that have fallen silent in flight since the last look (true), or are heard again (false).

        Args:
            now_ns: the time on the mission's clock [ns].
        """
        found = []
        for mu, samples in self._samples.items():
            silent = not samples or now_ns - samples[-1].stamp_ns > self._held_ns
            if silent != (mu in self._fallen_silent):
                self._fallen_silent ^= {mu}
                found.append((mu, silent))
        return found


class DriverFaultError(Exception):
    """A driver breaks the contract for good; the message says which and how."""


class DriverDesk:
    """Says what is to be said of the drivers: whom the mission waits for, what is wrong, who has fallen silent."""

    def __init__(
        self,
        watch: DriverWatch,
        heard: Callable[[int], bool],
        published: Callable[[int], bool],
        patience_s: float,
    ):
        """Args:
        watch: on the external MUs.
        heard: tells whether an MU's controller has taken its odometry.
        published: tells whether somebody publishes an MU's odometry.
        patience_s: a driver has so long to put itself right [s].
        """
        self._watch, self._heard, self._published, self._patience_s = watch, heard, published, patience_s
        self._named: dict[int, str] = {}
        self.waiting: list[int] = watch.silent
        """MUs that cannot fly yet."""

    def update(self) -> list[str]:
        """Look at the drivers; returns what there is to say that was not said before.

        Raises:
            DriverFaultError: when one has broken the contract for too long.
        """
        news, obstacles = [], self._watch.obstacles()
        for mu, why in obstacles.items():
            kind = why.split(": seen")[0]
            if why and self._named.get(mu) != kind:
                self._named[mu] = kind
                news.append(f"MU {mu} cannot fly yet: {why}")
            if self._watch.bad_for_s(mu) > self._patience_s:
                raise DriverFaultError(f"the driver of MU {mu} breaks the driver contract: {why}")
        self.waiting = sorted({*self._watch.silent, *obstacles, *self._deaf()})
        return news

    def problem(self, waited_s: float, domain_id: int, simulated: bool) -> str:
        """Why no mission is launched after all the waiting.

        Args:
            waited_s: how long [s].
            domain_id: of the mission.
            simulated: whether the simulator runs.
        """
        after = f"after {waited_s:g} s"
        missing = [mu for mu in self._watch.silent if not self._published(mu)]
        if missing:
            return (
                f"no driver publishes {', '.join(map(mu_odometry, missing))} {after}; start it in DDS domain "
                f"{domain_id}, or wait longer with --external-timeout"
            )
        if self._watch.silent:
            clock = f"; in a simulated mission a driver follows {CLOCK}" if simulated else ""
            silent = ", ".join(map(mu_odometry, self._watch.silent))
            return f"{silent}: somebody publishes it, and not one message has come {after}{clock}"
        for mu, why in self._watch.obstacles().items():
            what = f"breaks the driver contract: {why}" if why else f"has not been heard for long enough {after}"
            return f"the driver of MU {mu} {what}"
        deaf = mu_list(self._deaf())
        return f"the controllers of {deaf} take nothing of what the drivers publish {after}; see their logs"

    def _deaf(self) -> list[int]:
        return [mu for mu in self._watch.mus if not self._heard(mu)]


def hint(mus: Iterable[int], waits_s: float, domain_id: int, simulated: bool) -> str:
    """How to start the example driver.

    Args:
        mus: those waited for.
        waits_s: how long [s].
        domain_id: of the mission.
        simulated: whether the simulator runs.
    """
    clock = " --clock sim" if simulated else ""
    lines = [f"waiting for the drivers of {mu_list(mus)}, up to {waits_s:g} s; the example driver:"]
    lines += [
        f"    ROS_DOMAIN_ID={domain_id} {sys.executable} examples/mu_driver.py --mu {mu}{clock}" for mu in sorted(mus)
    ]
    return "\n".join(lines)


def mu_list(mus: Iterable[int]) -> str:
    """``MU 3, MU 5``."""
    return ", ".join(f"MU {mu}" for mu in sorted(mus))
