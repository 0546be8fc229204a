"""Nets from files: an npz, or two CSV tables."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from .errors import DescriptionError, Place
from .lattices import FlatNet
from .sections import MOST_NODES, FileSection, GraphSection

LARGEST_FILE_BYTES = 16 * 1024 * 1024
_NODES, _THREADS = "two or three columns x, y, z in m", "two or three columns: node, node and rest length in m"
_ARRAYS = "nodes (N, 2 or 3) [m], threads (T, 2), and rest_lengths (T,) [m] if wanted"


def net_from_file(section: FileSection, folder: Path, place: Place) -> FlatNet:
    """A net from the files that a description names.

    Args:
        section: the files.
        folder: where they are, if their names are relative.
        place: for errors.

    Raises:
        DescriptionError: for files that cannot be read or hold no net.
    """
    tables = bool(section.nodes), bool(section.threads)
    if any(tables) if section.path else not all(tables):
        raise place.problem("names no net", "path (an npz), or both nodes and threads (two CSV files)")
    if section.path:
        return _from_npz(folder / section.path, place / "path")
    nodes = _bytes(folder / section.nodes, place / "nodes")
    threads = _bytes(folder / section.threads, place / "threads")
    return _from_tables([nodes, threads], place)


def net_from_graph(section: GraphSection, place: Place) -> FlatNet:
    """A net that is written in the description itself.

    Raises:
        DescriptionError: where the tables hold no net.
    """
    return _from_tables([section.nodes.encode(), section.threads.encode()], place)


def graph_tables(nodes: np.ndarray, threads: np.ndarray, rest_lengths: np.ndarray) -> dict[str, str]:
    """The entries of ``net.graph`` that make this net, to the last bit."""
    return {
        "nodes": "".join(f"{x!r}, {y!r}, {z!r}\n" for x, y, z in nodes.tolist()),
        "threads": "".join(
            f"{a}, {b}, {length!r}\n" for (a, b), length in zip(threads.tolist(), rest_lengths.tolist(), strict=True)
        ),
    }


def _bytes(path: Path, place: Place) -> bytes:
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE_BYTES + 1)
    except OSError as error:
        raise place.error(str(path), f"cannot be read: {error.strerror or error}", "the path of a file") from error
    if len(data) > LARGEST_FILE_BYTES:
        raise place.error(
            str(path), f"holds more than {LARGEST_FILE_BYTES // 1024**2} MiB", f"a net of at most {MOST_NODES} nodes"
        )
    return data


def _from_npz(path: Path, place: Place) -> FlatNet:
    data = _bytes(path, place)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(member.file_size for member in archive.infolist()) > 4 * LARGEST_FILE_BYTES:
                raise place.error(str(path), "unpacks to too much", f"a net of at most {MOST_NODES} nodes")
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            arrays = {name: file[name] for name in ("nodes", "threads", "rest_lengths") if name in file.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        if isinstance(error, DescriptionError):
            raise
        raise place.error(str(path), f"not an npz file: {error}", _ARRAYS) from error
    missing = [name for name in ("nodes", "threads") if name not in arrays]
    if missing:
        raise place.error(str(path), f"has no array {' and no array '.join(missing)}", _ARRAYS)
    threads = np.asarray(arrays["threads"])
    if threads.ndim == 2 and "rest_lengths" in arrays and arrays["rest_lengths"].shape == (len(threads),):
        threads = np.column_stack([threads.astype(float), arrays["rest_lengths"]])
    elif "rest_lengths" in arrays:
        raise place.error(str(path), f"rest_lengths have shape {arrays['rest_lengths'].shape}", _ARRAYS)
    return _checked(arrays["nodes"], threads, place, place)


def _from_tables(texts: list[bytes], place: Place) -> FlatNet:
    nodes = _table(texts[0], place / "nodes", _NODES)
    threads = _table(texts[1], place / "threads", _THREADS)
    return _checked(nodes, threads, place / "nodes", place / "threads")


def _table(data: bytes, place: Place, allowed: str) -> np.ndarray:
    """Numbers of a CSV table; a first line without numbers is a heading, # begins a comment."""
    try:
        lines = data.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise place.problem("is no text", f"CSV, {allowed}") from error
    rows: list[list[float]] = []
    heading_allowed = True
    for number, line in enumerate(lines, 1):
        text = line.split("#", 1)[0].strip()
        if not text:
            continue
        try:
            row = [float(word) for word in text.split(",")]
        except ValueError as error:
            if heading_allowed:
                heading_allowed = False
                continue
            raise place.problem(f"line {number} is {text[:60]!r}", f"CSV, {allowed}") from error
        heading_allowed = False
        if len(row) not in (2, 3) or (rows and len(row) != len(rows[0])):
            raise place.problem(f"line {number} has {len(row)} numbers", f"CSV, {allowed}")
        rows.append(row)
    if not rows:
        raise place.problem("is empty", f"CSV, {allowed}")
    return np.array(rows)


def _checked(nodes: Any, threads: Any, nodes_place: Place, threads_place: Place) -> FlatNet:
    nodes, threads = np.asarray(nodes), np.asarray(threads)
    for array, place, allowed in ((nodes, nodes_place, _NODES), (threads, threads_place, _THREADS)):
        if array.ndim != 2 or array.shape[1] not in (2, 3) or array.dtype.kind not in "fiu":
            raise place.problem(f"has shape {array.shape} of {array.dtype}", allowed)
        if not np.isfinite(array).all():
            raise place.problem(f"row {int(np.argwhere(~np.isfinite(array))[0, 0])} is not finite", allowed)
    nodes = nodes.astype(float)
    if nodes.shape[1] == 2:
        nodes = np.column_stack([nodes, np.zeros(len(nodes))])
    ends = threads[:, :2].astype(np.int64)
    wrong = np.flatnonzero(((ends < 0) | (ends >= len(nodes)) | (ends != threads[:, :2])).any(axis=1))
    if len(wrong):
        row = int(wrong[0])
        given = ", ".join(f"{value:g}" for value in threads[row, :2])
        raise threads_place.problem(
            f"thread {row} leads from and to nodes {given}", f"node numbers 0 to {len(nodes) - 1}"
        )
    if threads.shape[1] == 3:
        lengths = threads[:, 2].astype(float)
    else:
        apart = nodes[ends[:, 1]] - nodes[ends[:, 0]]
        lengths = np.sqrt((apart * apart).sum(axis=1))
    return FlatNet(nodes, ends, lengths, float(np.median(lengths)))
