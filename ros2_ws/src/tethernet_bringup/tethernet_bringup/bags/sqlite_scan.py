"""Reads one SQLite file of rosbag2 (storage ``sqlite3``), row by row, in bounded memory; the file is only read.

Assumptions and limitations: SQLite keeps no time of publication and no counter, so the time of recording stands for the
first, and lost messages cannot be counted. There are no checksums: such a bag is never verified. Definitions that older
recorders left out are those of this machine.
"""

from __future__ import annotations

import sqlite3
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import quote

from tethernet_bringup.bags.bag_information import read_information
from tethernet_bringup.bags.contents import LARGEST_DESCRIPTION_BYTES, LARGEST_RECORD_BYTES, BagContents, BagMessage
from tethernet_bringup.bags.errors import NotABagError
from tethernet_bringup.bags.message_definitions import known_type
from tethernet_bringup.bags.metadata import BagTopic, MessageType
from tethernet_bringup.bags.writer import RUN_INFO_RECORD

MAGIC = b"SQLite format 3\0"


class SqliteScan:
    """One pass over one file.

    Args:
        contents: gets topics, facts and problems.
        path: of the file, for what is said about it.
        database: where SQLite finds it; another path where the file is compressed.
        wanted: which topics to yield messages of.
    """

    def __init__(self, contents: BagContents, path: Path, database: Path, wanted: Callable[[str], bool]):
        self._contents = contents
        self._path = path
        self._database = database
        self._wanted = wanted

    def messages(self) -> Iterator[BagMessage]:
        """The messages in the order in which they were recorded.

        Raises:
            NotABagError: when it is no database of rosbag2.
        """
        self._contents.verified = False
        # Immutable: no journal is rolled back and no file is made beside it.
        uri = f"file:{quote(bytes(self._database.absolute()))}?mode=ro&immutable=1"
        try:
            connection = sqlite3.connect(uri, uri=True)
        except sqlite3.Error as error:
            raise NotABagError(f"{self._path} cannot be opened as an SQLite bag: {error}") from error
        try:
            connection.text_factory = lambda text: text.decode(errors="backslashreplace")
            connection.execute("PRAGMA trusted_schema = OFF")
            names = self._topics(connection)
            self._take_facts(connection)
            yield from self._rows(connection, names)
        except sqlite3.Error as error:
            self._problem(f"it is damaged, what follows is left out ({error})")
        finally:
            connection.close()
        journal = self._path.with_name(self._path.name + "-wal")
        if journal.exists() and journal.stat().st_size:
            self._problem(f"messages that only {journal.name} holds were left out; the recorder did not end in order")

    def _topics(self, connection: sqlite3.Connection) -> dict[int, str]:
        try:
            found = dict(connection.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table'"))
        except sqlite3.Error as error:
            raise NotABagError(f"{self._path} cannot be read as an SQLite bag: {error}") from error
        plain = {name for name, sql in found.items() if str(sql).upper().startswith("CREATE TABLE")}
        if not {"topics", "messages"} <= plain:
            raise NotABagError(f"{self._path} is an SQLite file, but no bag: it has no tables 'topics' and 'messages'")
        definitions = self._definitions(connection) if "message_definitions" in plain else {}
        columns = {row[1] for row in connection.execute("PRAGMA table_info(topics)")}
        qos = "substr(offered_qos_profiles, 1, 100000)" if "offered_qos_profiles" in columns else "''"
        names = {}
        for number, name, kind, profiles in connection.execute(
            f"SELECT id, substr(name, 1, 1000), substr(type, 1, 1000), {qos} FROM topics"
        ):
            message_type = definitions.get(kind) or known_type(kind)
            if message_type is None:
                self._problem(f"the messages of {name} were left out, type {kind} is neither in it nor installed")
                continue
            if not self._contents.has_room_for(len(name) + len(kind) + len(profiles)):
                self._problem(f"topic {name} was left out, there are too many of them")
                continue
            self._contents.topics.setdefault(name, BagTopic(name, message_type, str(profiles)))
            names[number] = name
        return names

    def _definitions(self, connection: sqlite3.Connection) -> dict[str, MessageType]:
        found = {}
        rows = connection.execute(
            "SELECT topic_type, encoding, encoded_message_definition, type_description_hash FROM message_definitions "
            f"WHERE length(encoded_message_definition) <= {LARGEST_DESCRIPTION_BYTES}"
        )
        for kind, encoding, definition, type_hash in rows:
            if definition and self._contents.has_room_for(len(definition)):
                found[kind] = MessageType(str(kind), str(definition), str(type_hash), str(encoding))
        return found

    def _take_facts(self, connection: sqlite3.Connection) -> None:
        """The facts about the run, which rosbag2 keeps as custom data."""
        try:
            found = connection.execute(
                f"SELECT metadata FROM metadata WHERE length(metadata) <= {LARGEST_DESCRIPTION_BYTES} "
                "ORDER BY id DESC LIMIT 1"
            ).fetchone()
        except sqlite3.OperationalError:
            return  # older recorders have no such table
        if found and (facts := read_information(str(found[0])).facts):
            self._contents.metadata[RUN_INFO_RECORD] = dict(facts)

    def _rows(self, connection: sqlite3.Connection, names: dict[int, str]) -> Iterator[BagMessage]:
        wanted = {number: name for number, name in names.items() if self._wanted(name)}
        left_out: Counter[str] = Counter()
        for topic, time, data in connection.execute(
            f"SELECT topic_id, timestamp, CASE WHEN length(data) <= {LARGEST_RECORD_BYTES} THEN data END "
            "FROM messages ORDER BY id"
        ):
            name = wanted.get(topic)
            if name is None:
                left_out["their topic is unknown"] += topic not in names
            elif not isinstance(data, bytes) or not isinstance(time, int):
                left_out["they are damaged or too long"] += 1
            else:
                yield BagMessage(name, time, time, 0, data)
        for why, count in left_out.items():
            if count:
                self._problem(f"{count} messages were left out, {why}")

    def _problem(self, what: str) -> None:
        self._contents.note(f"{self._path.name}: {what}")
