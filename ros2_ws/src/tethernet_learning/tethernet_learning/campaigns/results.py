"""A campaign's outcomes on disk, from the first mission to the last.

``FILE.json`` describes the campaign, ``FILE.part`` holds the rows flown so far, one JSON object a line, and becomes
``FILE`` itself when all are flown. What has been added once survives a kill.
"""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Mapping, Sequence
from io import BufferedRandom
from pathlib import Path
from typing import Any

from tethernet_core import atomic_file
from tethernet_learning.campaigns import tables
from tethernet_learning.campaigns.cases import outcome_columns
from tethernet_learning.campaigns.columns import Row
from tethernet_learning.campaigns.errors import CampaignError
from tethernet_learning.campaigns.provenance import differences


class Results:
    """The outcomes of one campaign; a context manager that keeps others from writing to them."""

    def __init__(self, path: Path, description: Mapping[str, Any]):
        """Take up what is there already, or begin.

        Args:
            path: the outcomes file, .parquet or .csv.
            description: of the campaign, from :func:`.provenance.describe`.

        Raises:
            CampaignError: when the file belongs to another campaign, to nobody known, is damaged, or is being written
                to by another process.
            OSError: when it cannot be written.
        """
        tables.check_suffix(path)
        self.path = path
        self._total = description["scenarios"]
        self._columns = outcome_columns(description["units"])
        self._description_path = path.with_name(path.name + ".json")
        self._part_path = path.with_name(path.name + ".part")
        self.rows: list[Row] = []
        """Rows of the missions flown so far."""
        self._file: BufferedRandom | None = None
        self._check(description)
        if path.exists():
            self.rows = tables.read(path, self._columns)
            if len(self.rows) != self._total:
                raise CampaignError(f"{path} has {len(self.rows)} rows instead of {self._total}; {self._advice}")
        else:
            self._open()

    @property
    def _advice(self) -> str:
        return f"give another file, or remove {self.path.name}, {self.path.name}.json and {self.path.name}.part"

    @property
    def complete(self) -> bool:
        """True when all missions are flown and the file is written."""
        return self.path.exists()

    def add(self, rows: Sequence[Row]) -> None:
        """Add the next rows; they are on the disk when this returns.

        Raises:
            OSError: when they cannot be written.
            ValueError: where the campaign is complete.
        """
        if self._file is None:
            raise ValueError(f"{self.path} is complete; no mission is missing")
        lines = "".join(json.dumps(row, allow_nan=False) + "\n" for row in rows)
        self._file.write(lines.encode())
        self._file.flush()
        os.fsync(self._file.fileno())
        self.rows.extend(rows)

    def finish(self) -> None:
        """Write the outcomes file.

        Raises:
            OSError: when it cannot be written; nothing is lost then.
        """
        tables.write(self.path, self._columns, self.rows)
        self._part_path.unlink()

    def __enter__(self) -> Results:
        return self

    def __exit__(self, *_exception: object) -> None:
        if self._file:
            self._file.close()

    def _check(self, description: Mapping[str, Any]) -> None:
        """Compare with the campaign that made the file; write the description where there is none."""
        if self._description_path.exists():
            try:
                made_by = json.loads(self._description_path.read_text(encoding="utf-8"))
            except ValueError as error:
                raise CampaignError(f"{self._description_path} is no campaign's: {error}; {self._advice}") from error
            if found := differences(made_by, description):
                raise CampaignError(
                    f"{self.path} was begun by another campaign and cannot be continued by this one: "
                    f"{'; '.join(found)}; fly with what it was begun with, or {self._advice}"
                )
            return
        for path in (self.path, self._part_path):
            if path.exists():
                raise CampaignError(
                    f"{path} exists, but {self._description_path.name} does not, which would tell whether it is this "
                    f"campaign's; {self._advice}"
                )
        text = json.dumps(description, indent=2) + "\n"
        atomic_file.write_text(self._description_path, text)

    def _open(self) -> None:
        self._file = file = self._part_path.open("a+b")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            file.close()
            raise CampaignError(f"another process is flying for {self.path}; wait for it, or end it") from error
        file.seek(0)
        whole = 0
        for number, line in enumerate(file, start=1):
            if not line.endswith(b"\n"):  # a kill while it was written
                break
            try:
                row = json.loads(line)
            except ValueError as error:
                raise CampaignError(f"{self._part_path}, line {number} is damaged: {error}; {self._advice}") from error
            self.rows.append(row)
            whole += len(line)
        file.truncate(whole)
        file.seek(0, os.SEEK_END)
