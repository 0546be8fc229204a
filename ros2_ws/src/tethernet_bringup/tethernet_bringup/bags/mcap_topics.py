"""Which topics the channel numbers of an MCAP file stand for, and of which type they are."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from typing import TypeVar

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema

from tethernet_bringup.bags.contents import LARGEST_DESCRIPTION_BYTES, BagContents
from tethernet_bringup.bags.mcap_summary import Summary
from tethernet_bringup.bags.message_definitions import known_type
from tethernet_bringup.bags.metadata import BagTopic, MessageType

Description = TypeVar("Description", Schema, Channel)

_TOO_LONG = f"a description was left out, it is longer than {LARGEST_DESCRIPTION_BYTES >> 20} MiB"
_TOO_MANY = "a description was left out, there are too many of them"
_DIFFERS = "a description differs from the other one of its number, which is taken"


class TopicTable:
    """Schemas and channels of one file.

    Those of a closing part that keeps its checksum are right; else the first of each number is taken, and what is
    damaged there may be had from a closing part without checksum.

    Args:
        contents: gets topics and facts.
        summary: the closing part.
        wanted: which topics messages are wanted of.
    """

    def __init__(self, contents: BagContents, summary: Summary, wanted: Callable[[str], bool]):
        self._contents = contents
        self._summary = summary
        self._wanted = wanted
        self._schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        """By number, also those whose type is not known."""
        self.names: dict[int, str | None] = {}
        """Topics by channel number, None for those not wanted; channels without a type are not among them."""
        if summary.is_checked:
            self._schemas.update(summary.schemas)
            for channel in summary.channels.values():
                self.channels[channel.id] = channel
                self._use(channel)

    def describe(self, opcode: int, body: bytes | memoryview) -> str:
        """Take a description.

        Args:
            opcode: of a schema, a channel, or metadata.
            body: of the record.

        Returns:
            What is wrong with it; empty when it was taken, or was known already.
        """
        if len(body) > LARGEST_DESCRIPTION_BYTES:
            return _TOO_LONG
        stream = ReadDataStream(io.BytesIO(body))
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                return self._add(self._schemas, schema, len(body)) or self._use_all(schema.id)
            if opcode == Opcode.CHANNEL:
                channel = Channel.read(stream)
                return self._add(self.channels, channel, len(body)) or self._use(channel)
            record = Metadata.read(stream)
        except (McapError, struct.error, UnicodeDecodeError) as error:
            return f"a damaged description was left out ({type(error).__name__})"
        if not self._contents.has_room_for(len(body)):
            return _TOO_MANY
        self._contents.metadata[record.name] = record.metadata
        return ""

    def take_repeated(self, number: int) -> bool:
        """Take a channel that is damaged where it stood from a closing part without checksum.

        Returns:
            Whether its topic and type are known now.
        """
        repeated = self._summary.channels.get(number)
        if repeated is not None:
            channel = self.channels.setdefault(number, repeated)
            schema = self._summary.schemas.get(channel.schema_id)
            if schema is not None:
                self._schemas.setdefault(schema.id, schema)
            self._use(channel)
        return number in self.names

    def _add(self, table: dict[int, Description], description: Description, length: int) -> str:
        known = table.get(description.id)
        if known is not None:
            return "" if known == description else _DIFFERS
        if not self._contents.has_room_for(length):
            return _TOO_MANY
        table[description.id] = description
        return ""

    def _use_all(self, schema_id: int) -> str:
        return next(filter(None, map(self._use, (c for c in self.channels.values() if c.schema_id == schema_id))), "")

    def _use(self, channel: Channel) -> str:
        """Make messages of a channel readable, once its schema is known; returns what is wrong."""
        schema = self._schemas.get(channel.schema_id)
        if schema is None or channel.id in self.names:
            return ""
        try:
            definition = schema.data.decode()
        except UnicodeDecodeError:
            return f"the definition of {schema.name} is damaged"
        kind: MessageType | None
        if definition.strip():
            type_hash = channel.metadata.get("topic_type_hash", "")
            kind = MessageType(schema.name, definition, type_hash, encoding=schema.encoding)
        else:
            kind = known_type(schema.name)  # its recorder did not find the definition
        if kind is None:
            return f"{channel.topic} was left out, type {schema.name} is neither in it nor installed"
        qos = channel.metadata.get("offered_qos_profiles", "")
        self._contents.topics.setdefault(channel.topic, BagTopic(channel.topic, kind, qos))
        self.names[channel.id] = channel.topic if self._wanted(channel.topic) else None
        return ""
