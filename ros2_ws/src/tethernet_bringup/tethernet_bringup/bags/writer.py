"""Writes a bag in the layout of rosbag2: a folder with metadata.yaml and one MCAP file.

What was recorded survives:

- a killed process: everything up to the last :meth:`BagWriter.flush` is in the file; metadata.yaml is that of the
  start, with topics and facts but without counts;
- a full disk: some megabytes are set aside at the start and given back when a write fails, so that the messages in
  memory,
  the index and metadata.yaml still find room and the bag is closed as a whole one.

Assumptions and limitations: nothing is forced through to the disk (no fsync), so a power failure may cost more than
the last second. Readers that insist on a finished file (``ros2 bag play``, rosbags) need
:mod:`tethernet_bringup.bags.salvage` first when the process was killed.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from tethernet_bringup.bags.errors import BagWriteError, cause
from tethernet_bringup.bags.mcap_writer import McapWriter
from tethernet_bringup.bags.metadata import (
    METADATA_FILE,
    ROSBAG2_RECORD,
    SERIALIZED_METADATA,
    BagTopic,
    metadata_yaml,
    serialized_metadata,
)
from tethernet_core.atomic_file import write_text

RUN_INFO_RECORD = "tethernet"
"""Name of the MCAP metadata record with the facts about the run."""
RESERVE_BYTES = 4 << 20  # a chunk that does not compress, the index of hours, metadata.yaml


class BagWriter:
    """Writes one bag.

    Args:
        folder: the bag's folder; made here, and only used when it holds no bag yet.
        topics: all topics; messages name them by their place in this list.
        run_info: facts about the run (seed, commit, parameters, ...), kept in the MCAP file and in metadata.yaml.
        chunk_bytes: messages are held in memory until there are so many bytes of them [B].
        zstd_level: compression level.

    Raises:
        BagWriteError: when the folder cannot be written, holds a bag already, or the disk is full.
    """

    def __init__(
        self,
        folder: Path,
        topics: Sequence[BagTopic],
        *,
        run_info: Mapping[str, str],
        chunk_bytes: int = 1 << 18,
        zstd_level: int = 1,
    ):
        self.folder = folder
        self.path = folder / f"{folder.name}_0.mcap"
        self._topics = list(topics)
        self._run_info = dict(run_info)
        self._make_folder()
        self._reserve = self._set_aside()
        self._mcap = McapWriter(self.path, chunk_bytes=chunk_bytes, zstd_level=zstd_level)
        try:
            if self._run_info:
                self._mcap.add_metadata(RUN_INFO_RECORD, self._run_info)
            schemas: dict[str, int] = {}
            for topic in self._topics:
                kind = topic.message_type
                if kind.name not in schemas:
                    schemas[kind.name] = self._mcap.add_schema(kind.name, kind.encoding, kind.definition.encode())
                qos = {"offered_qos_profiles": topic.qos, "topic_type_hash": kind.type_hash}
                self._mcap.add_channel(topic.name, schemas[kind.name], qos)
            self._write_metadata(self._information())
        except BagWriteError:
            self._mcap.abandon()
            self._release()
            raise

    @property
    def counts(self) -> list[int]:
        """Messages in the file, for each topic."""
        return [self._mcap.counts[channel] for channel in range(1, len(self._topics) + 1)]

    @property
    def pending_count(self) -> int:
        """Messages that only memory holds."""
        return self._mcap.pending_count

    @property
    def size(self) -> int:
        """Size of the MCAP file [B]."""
        return self._mcap.size

    @property
    def checksum(self) -> int:
        """CRC-32 of the MCAP file."""
        return self._mcap.checksum

    @property
    def span_ns(self) -> tuple[int, int]:
        """Smallest and largest log time in the file [ns]."""
        return self._mcap.start_time, self._mcap.end_time

    def write(self, topic: int, log_time: int, publish_time: int, sequence: int, data: bytes) -> None:
        """Take a message.

        Args:
            topic: place of its topic in the list given at the start.
            log_time: what readers order and play by [ns].
            publish_time: when its publisher says that it is from [ns].
            sequence: the publisher's counter.
            data: as serialized by the middleware.

        Raises:
            BagWriteError: when the file cannot be written any further; call :meth:`close` then.
        """
        self._mcap.add_message(topic + 1, log_time, publish_time, sequence, data)

    def flush(self) -> None:
        """Make what has been taken so far outlive this process.

        Raises:
            BagWriteError: when the file cannot be written any further; call :meth:`close` then.
        """
        self._mcap.flush()

    def close(self) -> None:
        """Finish the bag, as far as there is room.

        Raises:
            BagWriteError: when something could not be written; what is in the file is whole.
        """
        self._release()
        information = None
        try:
            self._mcap.flush()
            information = self._information()
            self._mcap.add_metadata(ROSBAG2_RECORD, {SERIALIZED_METADATA: information})
            self._mcap.finish()
        finally:
            self._mcap.abandon()
            self._write_metadata(information or self._information())

    def _information(self) -> str:
        start, end = self.span_ns
        return serialized_metadata(
            self._topics,
            self.counts,
            file_name=self.path.name,
            start_ns=start,
            end_ns=end,
            custom_data=self._run_info,
        )

    def _write_metadata(self, information: str) -> None:
        target = self.folder / METADATA_FILE
        try:
            write_text(target, metadata_yaml(information), durable=False)
        except OSError as error:
            raise BagWriteError(f"cannot write {target}: {cause(error)}") from error

    def _make_folder(self) -> None:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            in_the_way = [entry.name for entry in self.folder.iterdir()]
        except OSError as error:
            raise BagWriteError(f"cannot make the bag's folder {self.folder}: {cause(error)}") from error
        if in_the_way:
            raise BagWriteError(
                f"the folder {self.folder} is not empty (it holds {', '.join(sorted(in_the_way)[:3])}); "
                "a bag is never written over: give another folder"
            )

    def _set_aside(self) -> int:
        try:
            handle, name = tempfile.mkstemp(prefix=".reserve", dir=self.folder)
            Path(name).unlink()  # without a name it vanishes with this process, however that ends
        except OSError as error:
            raise BagWriteError(f"cannot write into {self.folder}: {cause(error)}") from error
        try:
            os.posix_fallocate(handle, 0, RESERVE_BYTES)
        except OSError as error:
            os.close(handle)
            raise BagWriteError(f"no room for a bag in {self.folder}: {cause(error)}") from error
        return handle

    def _release(self) -> None:
        if self._reserve >= 0:
            os.close(self._reserve)
            self._reserve = -1
