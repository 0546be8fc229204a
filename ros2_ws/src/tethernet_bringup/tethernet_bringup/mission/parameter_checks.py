"""What the parameters of several nodes must keep together, checked before any process starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tethernet_bringup.nodes import PLANNER, RECORDER, SIM, mu_of
from tethernet_core.parameters import ParameterError, field_types
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.system import System

ALL_NODES = "/**"
Values = dict[str, dict[str, Any]]
"""Parameters by node and name."""
Sources = Mapping[tuple[str, str], str]
"""Where parameters were given, by node and name, as errors begin."""


class MissionParametersError(ValueError):
    """A parameter cannot be used: which, where it was given, what is allowed."""


def check_recording(extra_topics: str, system: System, sources: Sources) -> None:
    """Every topic to record is one, of a type that is installed."""
    from tethernet_bringup.recorder.recorded_topics import wanted_topics

    try:
        wanted_topics(system.unit_count, extra_topics)
    except ParameterError as error:
        raise MissionParametersError(f"{sources.get((RECORDER, 'extra_topics'), RECORDER + ': ')}{error}") from error


def check_physics(built: Sequence[Any], system: System, sources: Sources) -> None:
    """The time step is stable for the system and divides the control period."""
    from tethernet_sim.settings import PhysicsParameters, check_together
    from tethernet_sim.stability import check_stable

    of_kind = {type(instance): instance for instance in built}
    physics = of_kind[PhysicsParameters]
    try:
        check_together(physics, of_kind[ControlParameters])
        check_stable(system, physics)
    except ParameterError as error:
        raise MissionParametersError(f"{sources.get((SIM, 'time_step_s'), f'{SIM}: ')}{error}") from error


def check_shared(values: Values) -> None:
    """The mission's rules and the rhythm of control are the same for all: nodes that disagree cannot fly together."""
    for key in (*field_types(MissionParameters), "control_period_s", "watchdog_periods"):
        told = {node: _plain(node_values[key]) for node, node_values in values.items() if key in node_values}
        if len(set(told.values())) > 1:
            first = next(iter(told))
            other = next(node for node in told if told[node] != told[first])
            raise MissionParametersError(
                f"{key} is {told[first]} for {first} and {told[other]} for {other}; "
                f"allowed: one value for all, give it under {ALL_NODES}"
            )


def check_flight_time(built: Mapping[str, list[Any]], sources: Sources) -> None:
    """A controller must not end a flight that the mission's rules allow; in a hold test it is off."""
    rules = next(instance for instance in built[PLANNER] if isinstance(instance, MissionParameters))
    needed_s = rules.give_up_s + rules.capture_duration_s
    for node, instances in built.items():
        for control in instances:
            if isinstance(control, ControlParameters) and mu_of(node) and control.longest_flight_s <= needed_s:
                source = sources.get((node, "longest_flight_s"), f"{node}: ")
                raise MissionParametersError(
                    f"{source}longest_flight_s = {control.longest_flight_s:g} s; "
                    f"allowed: more than give_up_s and capture_duration_s together, {needed_s:g} s"
                )


def _plain(value: Any) -> Any:
    """Numbers without a decimal point that says nothing: 10 and 10.0 are the same rule."""
    return int(value) if isinstance(value, float) and value.is_integer() else value
