"""Parameters on a node: declared from the dataclasses of a subsystem, typed, described, range-checked, read-only."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar, cast, overload

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from tethernet_core.parameters import ParameterError, allowed_text, build, defaults, field_types

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

A = TypeVar("A")
B = TypeVar("B")
C = TypeVar("C")
D = TypeVar("D")


class NodeOptions(TypedDict):
    """Keyword arguments of ``Node.__init__``."""

    automatically_declare_parameters_from_overrides: bool


NODE_OPTIONS: NodeOptions = {"automatically_declare_parameters_from_overrides": True}
"""Give these to ``Node.__init__``: only then does a node know of overrides that it did not ask for."""

_BUILT_IN = ("use_sim_time", "start_type_description_service", "qos_overrides.")
_TYPES = {
    float: Parameter.Type.DOUBLE,
    int: Parameter.Type.INTEGER,
    bool: Parameter.Type.BOOL,
    str: Parameter.Type.STRING,
    tuple: Parameter.Type.DOUBLE_ARRAY,
}


@overload
def declare(node: Node, first: type[A], /) -> A: ...


@overload
def declare(node: Node, first: type[A], second: type[B], /) -> tuple[A, B]: ...


@overload
def declare(node: Node, first: type[A], second: type[B], third: type[C], /) -> tuple[A, B, C]: ...


@overload
def declare(node: Node, first: type[A], second: type[B], third: type[C], fourth: type[D], /) -> tuple[A, B, C, D]: ...


@overload
def declare(node: Node, /, *classes: type) -> Any: ...


def declare(node: Node, /, *classes: type) -> Any:
    """Declare a node's parameters from their dataclasses, with the values given to it.

    A class without a ``FILE`` has no default values: all its parameters must be given. A whole number is accepted
    where a float is expected.

    Args:
        node: made with :data:`NODE_OPTIONS`.
        classes: all parameter classes of the node; their names must differ.

    Returns:
        One instance for each class: a tuple, or the instance itself when there is one class.

    Raises:
        ParameterError: naming the parameter and what is allowed: unknown, missing, of the wrong type or out of range.
    """
    # rclpy 7.1.6 says that these are the values, and gives the parameters.
    parameters = cast("dict[str, Parameter]", node.get_parameters_by_prefix(""))
    given = {name: parameter.value for name, parameter in parameters.items() if not _built_in(name)}
    known = {name for cls in classes for name in field_types(cls)}
    unknown = sorted(set(given) - known)
    if unknown:
        raise ParameterError(f"{node.get_name()} has no parameter {unknown[0]!r}; it has: {', '.join(sorted(known))}")
    built = tuple(_build(node, cls, given) for cls in classes)
    for instance in built:
        _declare(node, instance)
    return built if len(built) > 1 else built[0]


def _built_in(name: str) -> bool:
    return name.startswith(_BUILT_IN)


def _build(node: Node, cls: type, given: dict[str, Any]) -> Any:
    kinds = field_types(cls)
    values = defaults(cls) if hasattr(cls, "FILE") else {}
    values.update((name, _plain(given[name])) for name in kinds if name in given)
    missing = [name for name in kinds if name not in values]
    if missing:
        raise ParameterError(f"{node.get_name()} needs the parameter {missing[0]}: --ros-args -p {missing[0]}:=VALUE")
    return build(cls, values)


def _plain(value: Any) -> Any:
    """ROS arrays come as array.array or NumPy arrays; the dataclasses know lists."""
    return value if isinstance(value, bool | int | float | str) else list(value)


def _declare(node: Node, instance: DataclassInstance) -> None:
    kinds = field_types(type(instance))
    for field in dataclasses.fields(instance):
        value = getattr(instance, field.name)
        kind = _TYPES[kinds[field.name]]
        if node.has_parameter(field.name):
            node.undeclare_parameter(field.name)  # declared from an override, without a description
        parameter = Parameter(field.name, kind, list(value) if kind == Parameter.Type.DOUBLE_ARRAY else value)
        node.declare_parameter(field.name, parameter.value, _descriptor(field, kind), ignore_override=True)


def _descriptor(field: dataclasses.Field[Any], kind: Parameter.Type) -> ParameterDescriptor:
    meta = field.metadata
    unit = "" if meta["unit"] == "-" else f" [{meta['unit']}]"
    descriptor = ParameterDescriptor(
        name=field.name,
        type=kind.value,
        description=meta["description"] + unit,
        additional_constraints=allowed_text(field),
        read_only=True,
    )
    low, high = meta["low"], meta["high"]
    if kind == Parameter.Type.DOUBLE and (low is not None or high is not None):
        widest = math.inf
        descriptor.floating_point_range.append(
            FloatingPointRange(
                from_value=-widest if low is None else float(low), to_value=widest if high is None else float(high)
            )
        )
    elif kind == Parameter.Type.INTEGER and (low is not None or high is not None):
        widest = 2**63 - 1
        descriptor.integer_range.append(
            IntegerRange(
                from_value=-widest if low is None else int(low), to_value=widest if high is None else int(high), step=0
            )
        )
    return descriptor
