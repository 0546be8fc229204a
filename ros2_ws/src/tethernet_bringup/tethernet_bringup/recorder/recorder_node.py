"""The recorder: writes everything that is said in a mission into a bag, as it came off the wire.

::

    python -m tethernet_bringup.recorder.recorder_node --ros-args -p output:=RUN/bag -p system:=zenit_8mu
    -p run_info:=RUN/run_info.json

It ends with SIGINT or SIGTERM: it goes on until nothing has come for a moment, then closes the bag; a second signal
makes it close at once. Beside the bag it leaves ``recorder.json`` with the messages of each topic and what was lost.
Exit status: 0 stopped and all written, 1 a fault (disk full, folder not writable: what was recorded until then is
kept and the bag is whole), 2 bad parameters.

This node has no callbacks and is not run by :func:`tethernet_ros.executor.run`: it looks into its queues
twenty times a second and takes what is there. In lock-step, with 5000 messages a second, that costs half the CPU time
of the EventsExecutor and a tenth of the SingleThreadedExecutor; and it can go on after the signal that stops
everybody else.
"""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import quiet_start

    quiet_start()

import importlib
import json
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSCompatibility, QoSProfile, qos_check_compatible
from rclpy.subscription import Subscription

from tethernet_bringup.bags.errors import BagError, BagWriteError, cause
from tethernet_bringup.bags.message_definitions import installed_type
from tethernet_bringup.bags.metadata import BagTopic, as_texts, qos_profiles
from tethernet_bringup.bags.writer import BagWriter
from tethernet_bringup.nodes import RECORDER
from tethernet_bringup.recorder.publication_count import PublicationCount
from tethernet_bringup.recorder.recorded_topics import RecordedTopic, wanted_topics
from tethernet_bringup.recorder.recording import COMPLETE, FAULTY, RECORDING, REPORT_FILE
from tethernet_bringup.recorder.settings import RecorderParameters
from tethernet_bringup.recorder.timeline import StampReader, Timeline
from tethernet_core.atomic_file import write_text
from tethernet_core.parameters import ParameterError
from tethernet_core.system import load_system
from tethernet_ros import any_quality, qos, stop_request, topics
from tethernet_ros.executor import FAULT, STOPPED, USAGE, bound_the_end, enter
from tethernet_ros.parameters import NODE_OPTIONS, declare
from tethernet_ros.polled_group import PolledGroup

_MOST_AT_ONCE = 2000  # messages of one topic before the others get their turn
_MOST_EARLY = 10_000  # messages held back until the mission has a time
_SIGN_OF_LIFE_S = 1.0  # wall time between two reports, by which the command sees that the recorder goes on
_SEQUENCE_MASK = 0xFFFFFFFF  # MCAP counts in 32 bits


@dataclass
class _Source:
    """One recorded topic."""

    topic: RecordedTopic
    message_class: type
    stamp: StampReader
    subscription: Subscription = field(init=False)
    undemanding: bool = False
    """Whether the subscription hears publishers of any quality of service."""
    take: Callable[[type, bool], Any] = lambda _kind, _raw: None
    """Takes the oldest message out of the queue: (bytes, information), or None when it is empty, as that of a topic is
    that was never subscribed to.
    """
    is_clock: bool = False
    published: PublicationCount = field(init=False)
    """What the publisher's counter tells."""

    def __post_init__(self) -> None:
        self.published = PublicationCount(self.topic.shared)


@dataclass
class _Early:
    """A message from before the mission had a time."""

    index: int
    stamp: int | None
    sequence: int
    data: bytes = field(repr=False)


class Recorder(Node):
    """Takes serialized messages off all topics of a mission and writes them.

    Raises:
        ParameterError: a parameter is unknown, of the wrong type, out of range, or names what does not exist.
        BagError: the bag cannot be made.
    """

    def __init__(self) -> None:
        super().__init__(RECORDER, **NODE_OPTIONS)
        self.settings: RecorderParameters = declare(self, RecorderParameters)
        self._sources = _sources(self.settings)
        self._timeline = Timeline()
        self._early: list[_Early] = []
        self._bag = BagWriter(
            Path(self.settings.output).absolute(),
            [_bag_topic(source.topic) for source in self._sources],
            run_info=_run_info(self.settings.run_info),
            chunk_bytes=self.settings.chunk_bytes,
            zstd_level=self.settings.zstd_level,
        )
        self._unheard: dict[str, _Source] = {}
        self._group = PolledGroup()
        for source in self._sources:
            if stop_request.requests():  # the bag is closed in order: nobody needs what else could be heard
                break
            self._subscribe(source, qos.RECORD_LATCHED if source.topic.latched else qos.RECORD)
            self._unheard[source.topic.name] = source
        self._write_report(RECORDING)
        self.get_logger().info(f"recording {len(self._sources)} topics to {self._bag.folder}")

    def _subscribe(self, source: _Source, quality: QoSProfile) -> None:
        source.subscription = self.create_subscription(
            source.message_class, source.topic.name, lambda _: None, quality, callback_group=self._group, raw=True
        )
        source.take = source.subscription.handle.take_message

    def note_publishers(self) -> None:
        """Look after topics of which no publisher is heard: one that offers less than asked for is heard as it comes.

        Tells once when every topic has a publisher that the recorder hears: from then on nothing is missed.
        """
        if not self._unheard:
            return
        for name, source in list(self._unheard.items()):
            if source.subscription.get_publisher_count():
                del self._unheard[name]
            elif not source.undemanding and self._offers_less(source):
                source.undemanding = True
                self.destroy_subscription(source.subscription)
                self._subscribe(source, any_quality.undemanding(qos.RECORD))
        if not self._unheard:
            self.get_logger().info("all topics have a publisher")

    def _offers_less(self, source: _Source) -> bool:
        asked = source.subscription.qos_profile
        offers = [info.qos_profile for info in self.get_publishers_info_by_topic(source.topic.name)]
        return any(qos_check_compatible(offer, asked)[0] == QoSCompatibility.ERROR for offer in offers)

    def take(self) -> int:
        """Take what is in the queues; returns the number of messages.

        Raises:
            BagWriteError: when the bag cannot be written any further.
        """
        count = 0
        for index, source in enumerate(self._sources):
            take, message_class = source.take, source.message_class
            for _ in range(_MOST_AT_ONCE):
                taken = take(message_class, True)
                if taken is None:
                    break
                count += 1
                self._keep(index, source, *taken)
        return count

    def flush(self) -> None:
        """Make what has been taken outlive this process.

        Raises:
            BagWriteError: when the bag cannot be written any further.
        """
        self._bag.flush()

    def give_sign_of_life(self) -> None:
        """Renew the report.

        Raises:
            BagWriteError: when it cannot be written.
        """
        self._write_report(RECORDING)

    def close(self, fault: str = "") -> str:
        """Finish the bag and the report.

        Args:
            fault: what has gone wrong before, if anything.

        Returns:
            What has gone wrong in all; empty when everything is written.
        """
        try:
            self._write_early()
            self._bag.close()
        except BagWriteError as error:
            fault = fault or str(error)
        kept, pending = sum(self._bag.counts), self._bag.pending_count
        if pending:
            fault = f"{fault}; {pending} messages could not be written"
        try:
            self._write_report(FAULTY if fault else COMPLETE, fault)
        except BagWriteError as error:
            fault = fault or str(error)
        lost = sum(source.published.lost for source in self._sources)
        self.get_logger().info(
            f"recorded {kept} messages ({self._bag.size / 1e6:.1f} MB) to {self._bag.folder}"
            + (f"; {lost} never arrived" if lost else "")
        )
        return fault

    def _keep(self, index: int, source: _Source, data: bytes, information: Mapping[str, Any]) -> None:
        sequence = information["publication_sequence_number"] or 0
        source.published.take(sequence)
        stamp = source.stamp(data)
        if source.topic.tells_time:
            self._timeline.tell(stamp, clock=source.is_clock)
        sequence &= _SEQUENCE_MASK
        if self._timeline.now is None and len(self._early) < _MOST_EARLY:
            self._early.append(_Early(index, stamp, sequence, data))
            return
        if self._early:
            self._write_early()
        self._write(index, stamp, sequence, data)

    def _write_early(self) -> None:
        while self._early:
            message = self._early.pop(0)
            self._write(message.index, message.stamp, message.sequence, message.data)

    def _write(self, index: int, stamp: int | None, sequence: int, data: bytes) -> None:
        log_time = self._timeline.log_time(stamp)
        if log_time is None:
            log_time = stamp or 0
        self._bag.write(index, log_time, log_time if stamp is None else stamp, sequence, data)

    def _write_report(self, state: str, fault: str = "") -> None:
        counts = self._bag.counts
        start, end = self._bag.span_ns
        report = {
            "state": state,
            "fault": fault,
            "message_count": sum(counts),
            "messages": {source.topic.name: count for source, count in zip(self._sources, counts, strict=True)},
            "never_arrived": {s.topic.name: s.published.lost for s in self._sources if s.published.lost},
            "start_time_ns": start,
            "end_time_ns": end,
            "bytes": self._bag.size,
            "crc32": self._bag.checksum,
        }
        path = self._bag.folder.parent / REPORT_FILE
        try:
            write_text(path, json.dumps(report, indent=2) + "\n", durable=False)
        except OSError as error:
            raise BagWriteError(f"cannot write {path}: {cause(error)}") from error


def _sources(settings: RecorderParameters) -> list[_Source]:
    sources: dict[str, _Source] = {}
    for topic in wanted_topics(load_system(settings.system).unit_count, settings.extra_topics):
        try:
            kind = installed_type(topic.type_name)
            package, _, short = topic.type_name.split("/")
            message_class = getattr(importlib.import_module(f"{package}.msg"), short)
        except (BagError, AttributeError, ImportError) as error:
            raise ParameterError(f"cannot record {topic.name}: {error}") from error
        sources[topic.name] = _Source(topic, message_class, StampReader.of(kind), is_clock=topic.name == topics.CLOCK)
    return list(sources.values())


def _bag_topic(topic: RecordedTopic) -> BagTopic:
    return BagTopic(
        name=topic.name,
        message_type=installed_type(topic.type_name).message_type,
        qos=qos_profiles(latched=topic.latched, depth=topic.depth),
    )


def _run_info(path: str) -> dict[str, str]:
    if not path:
        return {}
    try:
        facts = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ParameterError(f"run_info: cannot read {path}: {error}; allowed: a JSON file with an object") from error
    if not isinstance(facts, dict):
        raise ParameterError(f"run_info: {path} holds no JSON object but a {type(facts).__name__}")
    return as_texts(facts)


def _record(recorder: Recorder) -> None:
    """Record until this process is asked to stop and the queues are empty, or is asked twice.

    Raises:
        BagWriteError: when the bag cannot be written any further.
    """
    settings = recorder.settings
    # The only executor that respects callback groups; it has nothing to do but parameters.
    answers = SingleThreadedExecutor()
    answers.add_node(recorder)
    next_flush = time.monotonic() + settings.flush_period_s
    next_sign = time.monotonic() + _SIGN_OF_LIFE_S
    idle_since = stop_at = None
    while stop_request.requests() < 2:
        took = recorder.take()
        recorder.note_publishers()
        now = time.monotonic()
        if now >= next_flush:
            recorder.flush()
            answers.spin_once(timeout_sec=0.0)
            next_flush = now + settings.flush_period_s
        if now >= next_sign:
            recorder.give_sign_of_life()
            next_sign = now + _SIGN_OF_LIFE_S
        if stop_request.requests():
            stop_at = stop_at or now + settings.drain_s
            idle_since = now if took or idle_since is None else idle_since
            if now - idle_since >= settings.idle_s or now >= stop_at:
                break
        time.sleep(settings.take_period_s)
    recorder.take()


def main(args: list[str] | None = None) -> int:
    """Run the node; returns the exit status."""
    if not enter(RECORDER, sys.argv if args is None else args):
        return USAGE
    try:
        return _run()
    finally:
        rclpy.try_shutdown()


def _run() -> int:
    try:
        recorder = Recorder()
    except ParameterError as error:
        print(f"{RECORDER}: {error}", file=sys.stderr, flush=True)
        return USAGE
    except BagError as error:
        print(f"{RECORDER}: {error}", file=sys.stderr, flush=True)
        return FAULT
    fault = ""
    try:
        _record(recorder)
    except BagWriteError as error:
        fault = str(error)
    fault = recorder.close(fault)
    if fault:
        recorder.get_logger().fatal(f"recording ended early: {fault}; what was recorded until then is kept")
    bound_the_end()
    recorder.destroy_node()
    return FAULT if fault else STOPPED


if __name__ == "__main__":
    sys.exit(main())
