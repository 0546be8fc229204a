"""From a name or a file to a system."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..near_match import near_match
from .described_closing import (
    Equipped,
    build_aiming,
    build_capture,
    build_closing,
    build_launch,
    build_units,
    order_round_mouth,
)
from .described_debris import build_debris
from .described_net import build_net
from .entries import check_keys, read_section
from .errors import DescriptionError, Findings, Place
from .merging import merged, overridden
from .net_file import graph_tables
from .parts import Chaser, Tether
from .sections import DescriptionSection
from .system import System
from .yaml_text import parse_mapping, read_mapping

SHIPPED_FOLDER = Path(__file__).parents[1] / "systems"
PARAMETER_SECTIONS = ("control", "mission", "physics", "scenario")
"""Subsystems whose parameters a description may give."""
_LONGEST_CHAIN = 10
_OUTERMOST = {"name", "description"}
"""Entries that say what a description is, and are not taken over by those based on it."""


@functools.cache
def shipped_systems() -> tuple[str, ...]:
    """Names of the descriptions that are shipped."""
    return tuple(sorted(path.stem for path in SHIPPED_FOLDER.glob("*.yaml")))


def load_system(name_or_path: str | Path, overrides: Mapping[str, Any] | None = None) -> System:
    """Load a system.

    Args:
        name_or_path: name of a shipped description, or path of one.
        overrides: entries to replace: nested mappings, or dotted keys such as ``net.square.mesh_m`` and
            ``units[3].thread_length_m``; files that they name are found from the description's folder.

    Raises:
        DescriptionError: where there is no such system, or its description is wrong: which entry, what it holds and
            what is allowed.
    """
    if not overrides and isinstance(name_or_path, str) and name_or_path in shipped_systems():
        return _shipped(name_or_path)
    if not overrides and str(name_or_path) in _kept:
        return _kept[str(name_or_path)]
    path = _path_of(name_or_path, None)
    content, folder = _complete(path, ())
    return _from_content(content, path.stem, folder, overrides)


_kept: dict[str, System] = {}


def keep_system(path: str) -> System:
    """Load a system from a file that nothing changes any more: this process, and those that it forks, read it once.

    Raises:
        DescriptionError: as :func:`load_system`.
    """
    _kept[path] = load_system(path)
    return _kept[path]


def check_system(name_or_path: str | Path) -> System:
    """Load a system, and look for all mistakes in its description instead of ending at the first.

    What hangs on a part that cannot be read, as units do on the net, is not looked at.

    Raises:
        DescriptionError: ``sentences`` holds one for each mistake.
    """
    path = _path_of(name_or_path, None)
    content, folder = _complete(path, ())
    found = Findings()
    with found.collected():
        section = read_section(DescriptionSection, content, Place(str(content.get("name") or path.stem)))
    found.raise_them()
    place = Place(section.name or path.stem)
    independent: tuple[Callable[[], object], ...] = (
        lambda: build_debris(section.debris, folder, place / "debris"),
        lambda: read_section(Chaser, section.chaser, place / "chaser"),
        lambda: read_section(Tether, section.tether, place / "tether"),
        lambda: _parameters(section.parameters, place / "parameters"),
    )
    for part in (lambda: _check_on_net(section, folder, place), *independent):
        with found.collected():
            part()
    found.raise_them()
    return load_system(name_or_path)


def _check_on_net(section: DescriptionSection, folder: Path, place: Place) -> None:
    """The net, and all that hangs on it."""
    net, flat = build_net(section.net, folder, place / "net")
    units = build_units(section.units, section.unit, net, flat, place)
    equipped = Equipped(net, flat, units, order_round_mouth(net, units))
    found = Findings()
    with found.collected():
        closing = build_closing(section.closing, equipped, place / "closing")
        build_capture(section.capture, closing, place / "capture")
    with found.collected():
        build_launch(section.launch, equipped, place / "launch")
    with found.collected():
        build_aiming(section.aiming, equipped, place / "aiming")
    found.raise_them()


def system_from_text(text: str, *, folder: Path | None = None, source: str = "text") -> System:
    """A system from the text of its description, as :meth:`System.to_yaml` writes it.

    Args:
        text: YAML.
        folder: where files that it names are, if their names are relative; None: the working directory.
        source: named in errors, and the system's name if it has none.

    Raises:
        DescriptionError: as :func:`load_system`.
    """
    here = Path() if folder is None else folder
    content, base_folder = _based(parse_mapping(text, source), here, source, ())
    return _from_content(content, source, base_folder, None)


@functools.cache
def _shipped(name: str) -> System:
    """A shipped system, which does not change while the process runs: made once."""
    path = SHIPPED_FOLDER / f"{name}.yaml"
    content, folder = _complete(path, ())
    return _from_content(content, name, folder, None)


def _path_of(name_or_path: str | Path, folder: Path | None) -> Path:
    text = str(name_or_path)
    if text in shipped_systems():
        return SHIPPED_FOLDER / f"{text}.yaml"
    path = Path(text) if folder is None else folder / text
    if path.is_file():
        return path
    names = shipped_systems()
    raise DescriptionError(
        f"no system {text[:200]!r}{near_match(text, names)}; allowed: {', '.join(names)}, or the path of a description"
    )


def _complete(path: Path, chain: tuple[Path, ...]) -> tuple[dict[str, Any], Path]:
    """A file's description with everything that it is based on."""
    return _based(read_mapping(path), path.parent, path.name, (*chain, path.resolve()))


def _based(content: dict[str, Any], folder: Path, source: str, chain: tuple[Path, ...]) -> tuple[dict[str, Any], Path]:
    place = Place(source)
    check_keys(content, DescriptionSection.__dataclass_fields__, place)
    content = with_absolute_files(content, folder)
    base = content.get("based_on")
    if base is None:
        return content, folder
    if not isinstance(base, str):
        raise (place / "based_on").error(base, "not a name", f"{', '.join(shipped_systems())}, or a path")
    try:
        path = _path_of(base, folder)
    except DescriptionError as error:
        raise (place / "based_on").error(
            base, "no such system", f"{', '.join(shipped_systems())}, or a path"
        ) from error
    if path.resolve() in chain or len(chain) > _LONGEST_CHAIN:
        names = " -> ".join([*(link.name for link in chain), path.name])
        raise (place / "based_on").error(base, f"leads round in a circle: {names}", "a description that needs no other")
    below, _ = _complete(path, chain)
    own = {key: value for key, value in content.items() if key != "based_on"}
    return merged({key: value for key, value in below.items() if key not in _OUTERMOST}, own), folder


def with_absolute_files(content: dict[str, Any], folder: Path) -> dict[str, Any]:
    """A description whose files are found from anywhere."""
    result = dict(content)
    net, debris = content.get("net"), content.get("debris")
    if isinstance(net, Mapping) and isinstance(net.get("file"), Mapping):
        names = {
            key: _absolute(value, folder) if key in ("path", "nodes", "threads") else value
            for key, value in net["file"].items()
        }
        result["net"] = {**net, "file": names}
    if isinstance(debris, Mapping) and isinstance(debris.get("shape"), Mapping):
        result["debris"] = {**debris, "shape": _absolute_mesh(debris["shape"], folder)}
    return result


def _absolute(value: Any, folder: Path) -> Any:
    return str((folder / value).resolve()) if isinstance(value, str) and value else value


def _absolute_mesh(shape: Any, folder: Path) -> Any:
    """A shape whose mesh file, or those of its parts, are found from anywhere."""
    if not isinstance(shape, Mapping):
        return shape
    result = {key: _absolute(value, folder) if key == "file" else value for key, value in shape.items()}
    if isinstance(result.get("parts"), list):
        result["parts"] = [
            {**part, "shape": _absolute_mesh(part["shape"], folder)}
            if isinstance(part, Mapping) and "shape" in part
            else part
            for part in result["parts"]
        ]
    return result


def _from_content(
    content: dict[str, Any], default_name: str, folder: Path, overrides: Mapping[str, Any] | None
) -> System:
    place = Place(str(content.get("name") or default_name))
    if overrides:
        content = with_absolute_files(overridden(content, overrides, place), folder)
    section = read_section(DescriptionSection, content, place)
    name = section.name or default_name
    place = Place(name)
    net, flat = build_net(section.net, folder, place / "net")
    units = build_units(section.units, section.unit, net, flat, place)
    equipped = Equipped(net, flat, units, order_round_mouth(net, units))
    closing = build_closing(section.closing, equipped, place / "closing")
    launch = build_launch(section.launch, equipped, place / "launch")
    return System(
        name=name,
        description=" ".join(section.description.split()),
        net=net,
        units=units,
        mouth_order=equipped.mouth_order,
        closing=closing,
        launch=launch,
        debris=build_debris(section.debris, folder, place / "debris"),
        chaser=read_section(Chaser, section.chaser, place / "chaser"),
        tether=read_section(Tether, section.tether, place / "tether"),
        capture=build_capture(section.capture, closing, place / "capture"),
        aiming=build_aiming(section.aiming, equipped, place / "aiming"),
        parameters=_parameters(section.parameters, place / "parameters"),
        content=_self_contained(content, name, flat),
        flat_net=flat,
    )


def _parameters(content: Any, place: Place) -> dict[str, dict[str, Any]]:
    given = check_keys({} if content is None else content, PARAMETER_SECTIONS, place, "subsystem")
    for section, values in given.items():
        if not isinstance(values, Mapping):
            raise (place / section).error(values, "not a mapping", "NAME: VALUE, as in the subsystem's parameter file")
        for name, value in values.items():
            if not isinstance(name, str) or not isinstance(value, bool | int | float | str | list):
                raise (place / section / str(name)).error(value, "no parameter's value", "a number, text or list")
    return {section: dict(values) for section, values in given.items()}


def _self_contained(content: Mapping[str, Any], name: str, flat: Any) -> dict[str, Any]:
    """The description with its name, and a net from files written out."""
    result = {"name": name, **{key: value for key, value in content.items() if key not in ("name", "based_on")}}
    net = content["net"]
    if net.get("file") is not None:
        table = graph_tables(flat.nodes, flat.threads, flat.rest_lengths)
        result["net"] = {"graph": table, **{key: value for key, value in net.items() if key != "file"}}
    return result
