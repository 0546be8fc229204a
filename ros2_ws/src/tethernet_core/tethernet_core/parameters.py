"""Typed, described, range-checked parameters: one frozen dataclass per subsystem, its values in one ROS 2 parameter
file.

The YAML file next to a package holds the numbers, the dataclass holds type, unit, allowed range and reason. The same
dataclass is read from a file here and declared on a node in :mod:`tethernet_ros.parameters`.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import typing
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar

import yaml

from tethernet_core.errors import InputError
from tethernet_core.shown import SHORT, shown

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


class ShippedParameters(Protocol):
    """A parameter class with default values."""

    FILE: ClassVar[Path]
    """Where they are."""
    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]


T = TypeVar("T", bound="DataclassInstance")
Shipped = TypeVar("Shipped", bound=ShippedParameters)


class ParameterError(InputError):
    """A parameter is unknown, missing, of the wrong type or out of range."""


def parameter(
    description: str,
    *,
    unit: str = "-",
    low: float | None = None,
    high: float | None = None,
    choices: Iterable[str | int] = (),
) -> Any:
    """Describe a dataclass field as a parameter.

    Args:
        description: what it is and why it has its value.
        unit: SI unit, or "-".
        low: smallest allowed value.
        high: largest allowed value.
        choices: allowed values of a string or a whole number.
    """
    return dataclasses.field(
        metadata={"description": description, "unit": unit, "low": low, "high": high, "choices": tuple(choices)}
    )


def field_types(cls: type) -> dict[str, type]:
    """Parameter names of ``cls`` with their Python types (float, int, bool, str, or tuple for an array of floats)."""
    hints = typing.get_type_hints(cls)
    return {
        f.name: (tuple if typing.get_origin(hints[f.name]) is tuple else hints[f.name]) for f in dataclasses.fields(cls)
    }


def allowed_text(field: dataclasses.Field[Any]) -> str:
    """The allowed values of a parameter in words."""
    meta = field.metadata
    if meta["choices"]:
        return "one of " + ", ".join(str(choice) for choice in meta["choices"])
    if field.type in ("str", "bool"):  # annotations are text
        return {"str": "text", "bool": "true or false"}[field.type]
    unit = "" if meta["unit"] == "-" else f" {meta['unit']}"
    if meta["low"] is not None and meta["high"] is not None:
        return f"{meta['low']:g} to {meta['high']:g}{unit}"
    if meta["low"] is not None:
        return f"at least {meta['low']:g}{unit}"
    if meta["high"] is not None:
        return f"at most {meta['high']:g}{unit}"
    return "any finite value" + (f" in {meta['unit']}" if unit else "")


def _check(cls: type, field: dataclasses.Field[Any], kind: type, value: Any) -> Any:
    def fail(why: str) -> ParameterError:
        return ParameterError(
            f"{cls.__name__}.{field.name} = {shown(repr(value), SHORT)}: {why}; allowed: {allowed_text(field)}"
        )

    if kind is tuple:
        if not isinstance(value, list | tuple):
            raise fail("not an array of numbers")
        return tuple(_check(cls, field, float, item) for item in value)
    if kind is float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise fail("not a number")
        try:
            value = float(value)
        except OverflowError:  # a whole number with more digits than a float has
            value = math.inf
        if not math.isfinite(value):
            raise fail("not finite")
    elif kind is int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise fail("not a whole number")
    elif not isinstance(value, kind):
        raise fail(f"not a {kind.__name__}")
    meta = field.metadata
    if meta["choices"] and value not in meta["choices"]:
        raise fail("unknown")
    if (meta["low"] is not None and value < meta["low"]) or (meta["high"] is not None and value > meta["high"]):
        raise fail("out of range")
    return value


def build(cls: type[T], values: Mapping[str, Any]) -> T:
    """Make ``cls`` from a complete mapping of its parameters.

    Raises:
        ParameterError: naming the key and what is allowed, for an unknown or missing key, a wrong type, a value out
            of range.
    """
    kinds = field_types(cls)
    fields = {f.name: f for f in dataclasses.fields(cls)}
    for key in values:
        if key not in kinds:
            if (place := moved(key)) is not None:
                raise ParameterError(f"{cls.__name__} has no parameter {key!r} any more: it is {place} of the system")
            raise ParameterError(
                f"{cls.__name__} has no parameter {shown(repr(key), SHORT)}; it has: {', '.join(sorted(kinds))}"
            )
    missing = [key for key in kinds if key not in values]
    if missing:
        raise ParameterError(f"{cls.__name__} lacks {', '.join(missing)}")
    return cls(**{key: _check(cls, fields[key], kind, values[key]) for key, kind in kinds.items()})


MOVED_TO_SYSTEM = {
    "mesh_m": "net.square.mesh_m",
    "thread_radius_m": "net.thread.radius_m",
    "thread_modulus_pa": "net.thread.modulus_pa",
    "thread_density_kg_m3": "net.thread.density_kg_m3",
    "thread_damping_ratio": "net.thread.damping_ratio",
    "mu_mass_kg": "unit.mass_kg",
    "known_mass_kg": "unit.mass_kg",
    "mu_radius_m": "unit.radius_m",
    "thrust_limit_n": "unit.thrust_limit_n",
    "specific_impulse_s": "unit.specific_impulse_s",
    "propellant_kg": "unit.propellant_kg",
    "debris_mass_kg": "debris.mass_kg",
    "debris_radius_m": "debris.shape.radius_m",
    "debris_length_m": "debris.shape.length_m",
    "target_radius_m": "debris.shape.radius_m",
    "target_length_m": "debris.shape.length_m",
    "chaser_mass_kg": "chaser.mass_kg",
    "chaser_side_m": "chaser.side_m",
    "tether_stiffness_n_m": "tether.stiffness_n_m",
    "tether_damping_n_s_m": "tether.damping_n_s_m",
    "winch_speed_m_s": "closing.winch.speed_m_s",
    "winch_tension_n": "closing.winch.tension_n",
    "winch_stiffness_n_m": "closing.winch.stiffness_n_m",
    "joint_draw_in_m_s": "closing.docking.draw_in_m_s",
    "joint_pull_n": "closing.docking.pull_n",
    "docking_distance_m": "closing.docking.docking_distance_m (or closing.winch.docking_distance_m)",
    "debris_volume_m3": "debris.cqi.volume_m3",
    "debris_area_m2": "debris.cqi.area_m2",
    "characteristic_length_m": "debris.cqi.length_m",
    "cqi_threshold": "capture.cqi_threshold",
    "center_of_mass": "capture.center_of_mass",
}
"""Hardware, which descriptions of systems hold: names that were parameters, and their entries there."""


def moved(name: str) -> str | None:
    """The entry of a system's description that a name of former parameters stands for; None for any other name."""
    return MOVED_TO_SYSTEM.get(name)


LARGEST_FILE_BYTES = 256 * 1024
"""All parameters of a mission take 8 KiB; a parser in Python takes seconds for this many."""

_DEEPEST = 20
"""Levels of nesting; a parameter file has three, and an array in it one more."""


class StrictLoader(yaml.SafeLoader):
    """YAML as ROS 2 reads it: without aliases, which can stand for more than any memory, and without keys twice."""

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            raise yaml.composer.ComposerError(None, None, "aliases are not allowed", self.peek_event().start_mark)
        self._depth += 1
        if self._depth > _DEEPEST:
            problem = f"nested in more than {_DEEPEST} levels"
            raise yaml.composer.ComposerError(None, None, problem, self.peek_event().start_mark)
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key in (key for key, _ in node.value if isinstance(key, yaml.ScalarNode)):
            if key.value in seen:
                problem = f"{shown(key.value, SHORT)} is given twice"
                raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)


def _cause(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def read_yaml(path: str | Path) -> dict[str, dict[str, Any]]:
    """Read a ROS 2 parameter file: {node name: {parameter: value}}.

    Raises:
        ParameterError: when the file cannot be read or has not the form of a ROS 2 parameter file.
    """
    try:
        with Path(path).open("rb") as file:
            data = file.read(LARGEST_FILE_BYTES + 1)
        if len(data) > LARGEST_FILE_BYTES:
            raise ParameterError(
                f"{shown(path)} is no parameter file: it holds more than {LARGEST_FILE_BYTES // 1024} KiB; "
                "allowed: a ROS 2 parameter file"
            )
        content = yaml.load(data.decode("utf-8-sig"), StrictLoader)
    except (OSError, UnicodeDecodeError) as error:
        raise ParameterError(f"cannot read parameter file {shown(path)}: {_cause(error)}") from error
    except (yaml.YAMLError, ValueError) as error:  # a date that is none, a number of five thousand digits
        if isinstance(error, ParameterError):
            raise
        raise ParameterError(f"{shown(path)} is not YAML: {shown(' '.join(str(error).split()))}") from error
    form = "expected 'NODE: {ros__parameters: {NAME: VALUE}}'"
    if not isinstance(content, dict):
        raise ParameterError(f"{shown(path)}: {form}, got {type(content).__name__}")
    result = {}
    for node, body in content.items():
        if (
            not isinstance(body, dict)
            or set(body) != {"ros__parameters"}
            or not isinstance(body["ros__parameters"], dict)
        ):
            raise ParameterError(f"{shown(path)}: {form} under {shown(repr(node), SHORT)}")
        result[str(node)] = body["ros__parameters"]
    return result


def defaults(cls: type[ShippedParameters]) -> dict[str, Any]:
    """The default values of ``cls``, from the file that its ``FILE`` names; a copy of its own for each caller."""
    return dict(_shipped(cls.FILE))


@functools.cache
def _shipped(path: Path) -> dict[str, Any]:
    """The values in a file of this package, which does not change while it runs: read once, not for every scenario."""
    return next(iter(read_yaml(path).values()))


def load(cls: type[Shipped], overrides: Mapping[str, Any] | None = None) -> Shipped:
    """Make ``cls`` from its own file, with some values replaced.

    Raises:
        ParameterError: as :func:`build`.
    """
    return build(cls, {**defaults(cls), **(overrides or {})})
