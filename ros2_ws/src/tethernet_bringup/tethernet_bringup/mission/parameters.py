"""All parameters of one mission in one file: shipped values, a parameter file, flags.

All are checked against the dataclasses of all nodes before any process starts. A flag goes before the parameter file,
the parameter file before the shipped values.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from tethernet_bringup.mission.parameter_checks import (
    ALL_NODES,
    MissionParametersError,
    Values,
    check_flight_time,
    check_physics,
    check_recording,
    check_shared,
)
from tethernet_bringup.mission.supervisor_settings import SupervisorParameters
from tethernet_bringup.mission.trained_models import check_models, choose_models
from tethernet_bringup.nodes import ASSESSOR, MONITOR, PLANNER, RECORDER, SIM, VIEWER, controller, mu_of
from tethernet_core.parameters import ParameterError, build, defaults, field_types, moved, read_yaml
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.shown import SHORT, shown
from tethernet_core.system import DescriptionError, System, load_system
from tethernet_planner.mission_rules import check_debris_position
from tethernet_sim.settings import ScenarioParameters

IDENTITY = "mu"
"""A controller's parameter that has no default: which unit it controls."""
SYSTEM = "system"
"""The parameter of all nodes that says what is flown."""

_SCENARIO_FLAGS = {
    "debris_position": "debris",
    "debris_attitude": "attitude",
    "debris_rate": "tumble",
    "seed": "seed",
    "pace": "pace",
}
_RULE_FLAGS = {"hold_s": "hold", "tow_n": "tow"}
"""Of the mission's rules."""


@dataclass(frozen=True)
class MissionSetup:
    """One mission's parameters, complete and checked."""

    system: System
    """What is flown."""
    scenario: ScenarioParameters
    policy: str
    """The policy that chooses the aiming points: a name, or the absolute path of its file."""
    models: dict[str, str]
    """Short hashes of the trained models that fly along, ``policy`` and ``predictor``."""
    simulated: bool
    """Whether the simulator runs."""
    external: tuple[int, ...]
    """Units with a driver of their own."""
    supervisor: SupervisorParameters
    control: ControlParameters
    """The rhythm of control, the same for all nodes."""
    nodes: Values
    """What each node gets."""

    @property
    def patience(self) -> SupervisorParameters:
        """The supervisor's patience on top of that of the nodes, which wait for each other themselves."""
        planner, sim = self.nodes[PLANNER], self.nodes[SIM]
        return dataclasses.replace(
            self.supervisor,
            launch_timeout_s=self.supervisor.launch_timeout_s
            + planner["plan_timeout_s"]
            + planner["confirm_timeout_s"],
            silence_timeout_s=self.supervisor.silence_timeout_s + sim["answer_timeout_s"],
        )

    @property
    def longest_s(self) -> float:
        """From launch to the end of the longest mission that the rules allow [s]."""
        planner = self.nodes[PLANNER]
        return planner["launch_delay_s"] + planner["give_up_s"] + planner["capture_duration_s"] + self.hold_s

    @property
    def hold_s(self) -> float:
        """Length of the hold test that is asked for [s]; 0: none."""
        return float(self.nodes[PLANNER]["hold_s"])

    @property
    def tow_n(self) -> float:
        """Tension of the main tether that the chaser tows with in it [N]."""
        return float(self.nodes[PLANNER]["tow_n"])

    @property
    def view_memory_mb(self) -> int:
        """Most memory for pictures of the mission, where it is shown [MB]."""
        return int(self.nodes[VIEWER]["memory_mb"])

    def shown_in(self, output: str) -> MissionSetup:
        """The same mission, shown there: the address of a Rerun server, or the path of a file."""
        nodes = {**self.nodes, VIEWER: {**self.nodes[VIEWER], "output": output}}
        return dataclasses.replace(self, nodes=nodes)

    def recorded_in(self, bag: Path, run_info: Path, description: Path) -> MissionSetup:
        """The same mission, recorded in this folder with the facts from this JSON file; all nodes read what is flown
        from this description.
        """
        nodes = {
            node: {**values, SYSTEM: str(description)} if node != MONITOR else values
            for node, values in self.nodes.items()
        }
        nodes[RECORDER] |= {"output": str(bag), "run_info": str(run_info)}
        return dataclasses.replace(self, nodes=nodes)

    def yaml(self) -> str:
        """A ROS 2 parameter file with all of it, fit for the nodes and for ``--params``."""
        content = {node: {"ros__parameters": values} for node, values in self.nodes.items()}
        head = "# The parameters of one mission, complete. Fly it again: python run_mission.py --params THIS_FILE\n"
        return head + yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=120)


def resolve(options: argparse.Namespace) -> MissionSetup:
    """Make the parameters of a mission from the command line.

    Args:
        options: from :func:`tethernet_bringup.mission.arguments.parse`.

    Raises:
        MissionParametersError: for an unknown node or parameter, a wrong type, a value out of range; names the key and
            what is allowed.
    """
    given = _read(options.params) if options.params is not None else {}
    simulated = not options.no_sim
    system = _system(options, given)
    if options.no_sim and not system.units:
        raise MissionParametersError(
            f"--no-sim: system {system.name} has no units, so nothing real would fly; allowed: a system with units"
        )
    classes = node_classes(system, simulated)
    values: Values = {
        node: {k: v for cls in kinds for k, v in defaults(cls).items()} for node, kinds in classes.items()
    }
    sources = _apply_system(values, classes, system)
    _apply_file(values, given, options, system, sources)
    _apply_flags(values, options, system, sources)
    options.notices += choose_models(values, system, sources)
    built = {node: _build(node, kinds, values[node], sources) for node, kinds in classes.items()}
    check_shared(values)
    check_recording(values[RECORDER]["extra_topics"], system, sources)
    check_flight_time(built, sources)
    models = check_models(values, system, sources)
    scenario = next(instance for instance in built[SIM] if isinstance(instance, ScenarioParameters))
    rules = next(instance for instance in built[PLANNER] if isinstance(instance, MissionParameters))
    check_physics(built[SIM], system, sources)
    try:
        external = scenario.external_units(system)
    except ParameterError as error:
        raise MissionParametersError(f"{sources.get((SIM, 'external_mus'), '')}{error}") from error
    try:
        check_debris_position(scenario.debris_position, rules)
    except ValueError as error:
        raise MissionParametersError(f"{sources.get((SIM, 'debris_position'), '')}{error}") from error
    for mu in range(1, system.unit_count + 1):
        values[controller(mu)] = {IDENTITY: mu, SYSTEM: values[SIM][SYSTEM], **values[controller(mu)]}
    return MissionSetup(
        system=system,
        scenario=scenario,
        policy=values[PLANNER]["policy"],
        models=models,
        simulated=simulated,
        external=tuple(range(1, system.unit_count + 1)) if not simulated else external,
        supervisor=built[MONITOR][0],
        control=next(instance for instance in built[PLANNER] if isinstance(instance, ControlParameters)),
        nodes={node: _typed(classes[node], node_values) for node, node_values in values.items()},
    )


def node_classes(system: System, simulated: bool = True) -> dict[str, tuple[type, ...]]:
    """The parameter classes of each node; a controller has its number and its system besides.

    Args:
        system: that is flown: one controller for each unit.
        simulated: whether the simulator runs; its scenario is checked in any case, because it says where the debris is.
    """
    from tethernet_bringup.recorder.settings import RecorderParameters
    from tethernet_bringup.view.settings import ViewerParameters
    from tethernet_planner.settings import AssessorParameters, PlannerParameters
    from tethernet_sim.settings import PhysicsParameters, SimNodeParameters

    return {
        SIM: (ScenarioParameters, SimNodeParameters, PhysicsParameters, ControlParameters),
        **{controller(mu): (ControlParameters,) for mu in range(1, system.unit_count + 1)},
        PLANNER: (PlannerParameters, MissionParameters, ControlParameters),
        ASSESSOR: (AssessorParameters, ControlParameters),
        RECORDER: (RecorderParameters,),
        VIEWER: (ViewerParameters,),
        MONITOR: (SupervisorParameters,),
    }


def _read(path: str) -> Values:
    try:
        return {
            node if node == ALL_NODES else node.lstrip("/"): values for node, values in read_yaml(Path(path)).items()
        }
    except ParameterError as error:
        raise MissionParametersError(f"--params: {error}") from error


def _system(options: argparse.Namespace, given: Values) -> System:
    """What is flown: as the flag says, else the parameter file, else the default scenario."""
    if options.system is not None:
        source, word = f"--system {shown(options.system, SHORT)}: ", options.system
    else:
        named = {node: values[SYSTEM] for node, values in given.items() if SYSTEM in values}
        if len(set(map(repr, named.values()))) > 1:
            raise MissionParametersError(
                f"--params {shown(options.params)}: several systems: "
                + ", ".join(f"{shown(repr(word), SHORT)} for {node}" for node, word in named.items())
                + f"; allowed: one for all, give it under {ALL_NODES}"
            )
        source = f"--params {shown(options.params)}: {next(iter(named))}: {SYSTEM}: " if named else ""
        word = next(iter(named.values()), defaults(ScenarioParameters)[SYSTEM])
    try:
        return load_system(word)
    except DescriptionError as error:
        raise MissionParametersError(f"{source}{error}") from error


def _apply_system(values: Values, classes: Mapping[str, Sequence[type]], system: System) -> dict[tuple[str, str], str]:
    """Put in the parameters that the system is flown with; return where each came from."""
    from tethernet_sim.settings import PhysicsParameters

    subsystems = {
        "control": ControlParameters, "mission": MissionParameters, "physics": PhysicsParameters,
        "scenario": ScenarioParameters,
    }  # fmt: skip
    sources: dict[tuple[str, str], str] = {}
    for section, parameters in system.parameters.items():
        kind = subsystems[section]
        place = f"system {system.name}: parameters.{section}: "
        for key, value in parameters.items():
            if key not in field_types(kind) or key == SYSTEM:
                allowed = ", ".join(sorted(set(field_types(kind)) - {SYSTEM}))
                raise MissionParametersError(f"{place}no parameter {shown(repr(key), SHORT)}; it has: {allowed}")
            for node, kinds in classes.items():
                if kind in kinds:
                    values[node][key] = value
                    sources[node, key] = place
    return sources


def _apply_file(
    values: Values,
    given: Values,
    options: argparse.Namespace,
    system: System,
    sources: dict[tuple[str, str], str],
) -> None:
    """Put the file's values in, and where each came from."""
    file = f"--params {shown(options.params)}"
    for node in sorted(given, key=lambda name: name != ALL_NODES):
        if node != ALL_NODES and node not in values:
            hint = f" (system {system.name} has {system.unit_count} units)" if mu_of(node) else ""
            raise MissionParametersError(
                f"{file}: no node {node!r} in this mission{hint}; there are: {', '.join(values)}, and {ALL_NODES}"
            )
        for key, value in given[node].items():
            if key == SYSTEM:
                continue  # read before all others
            if key == IDENTITY and mu_of(node):
                _check_identity(file, node, value)
                continue
            takers = [name for name in values if key in values[name]] if node == ALL_NODES else [node]
            if not takers or key not in values[takers[0]]:
                raise MissionParametersError(f"{file}: {_unknown(node, key, values)}")
            for taker in takers:
                values[taker][key] = value
                sources[taker, key] = f"{file}: {node}: "


def _unknown(node: str, key: str, values: Values) -> str:
    """Why there is no such parameter: hardware is described, not a parameter."""
    if key == "mu_count":
        return f"no node has a parameter {key!r} any more: how many units there are follows from {SYSTEM}"
    if (entry := moved(key)) is not None:
        return (
            f"no node has a parameter {key!r} any more: it is {entry} of the system's description; "
            "fly a description of your own with --system FILE, such as one that is based_on a shipped one"
        )
    if node == ALL_NODES:
        return f"no node has a parameter {key!r}"
    return f"{node} has no parameter {key!r}; it has: {', '.join(sorted(values[node]))}"


def _check_identity(file: str, node: str, value: Any) -> None:
    if value != mu_of(node):
        raise MissionParametersError(f"{file}: {node}: {IDENTITY} = {value!r}; allowed: {mu_of(node)}, its own number")


def _apply_flags(
    values: Values, options: argparse.Namespace, system: System, sources: dict[tuple[str, str], str]
) -> None:
    mu_count = system.unit_count
    scenario = values[SIM]
    for key, name in _SCENARIO_FLAGS.items():
        flag = getattr(options, name)
        if flag is not None:
            scenario[key] = list(flag) if isinstance(flag, tuple) else flag
            sources[SIM, key] = f"--{name}: "
    for key, name in _RULE_FLAGS.items():
        if (flag := getattr(options, name)) is not None:
            values[PLANNER][key] = flag
            sources[PLANNER, key] = f"--{name}: "
    if options.no_sim and values[PLANNER]["tow_n"]:
        options.notices.append(
            "--tow: without a simulator the real chaser tows, which has to follow /mission/state (phase HOLDING, tow)"
        )
    if options.external_mu:
        too_large = [mu for mu in options.external_mu if mu > mu_count]
        if too_large:
            allowed = f"1 to {mu_count}" if mu_count else "none"
            raise MissionParametersError(
                f"--external-mu {too_large[0]}: system {system.name} has {mu_count} units; allowed: {allowed}"
            )
        scenario["external_mus"] = " ".join(map(str, options.external_mu))
    if options.no_sim:
        scenario["external_mus"] = " ".join(str(mu) for mu in range(1, mu_count + 1))
        if scenario["pace"] != "realtime":
            raise MissionParametersError(
                f"pace {scenario['pace']!r} with --no-sim: no simulator waits; allowed: realtime"
            )
    # What several nodes must know is said once, by the scenario, and handed to all that ask for it.
    shared = {
        SYSTEM: system.name if options.system is None else options.system,
        "seed": scenario["seed"],
        "pace": scenario["pace"],
        "external_mus": scenario["external_mus"],
    }
    shared["simulated"] = not options.no_sim
    if options.no_sim:
        shared["debris_position"] = scenario["debris_position"]
    if options.policy is not None:
        shared["policy"] = options.policy
        sources[PLANNER, "policy"] = f"--policy {shown(options.policy, SHORT)}: "
    for node_values in values.values():
        node_values.update((key, value) for key, value in shared.items() if key in node_values)


def _build(
    node: str, classes: Iterable[type], values: Mapping[str, Any], sources: Mapping[tuple[str, str], str]
) -> list[Any]:
    built: list[Any] = []
    for cls in classes:
        try:
            built.append(build(cls, {name: values[name] for name in field_types(cls)}))
        except ParameterError as error:
            named = next(
                (source for (taker, key), source in sources.items() if taker == node and f".{key} " in str(error)), ""
            )
            raise MissionParametersError(f"{named or node + ': '}{error}") from error
    return built


def _typed(classes: Iterable[type], values: Mapping[str, Any]) -> dict[str, Any]:
    """The values as ROS reads them: it tells 10 from 10.0."""
    kinds = {name: kind for cls in classes for name, kind in field_types(cls).items()}
    result: dict[str, Any] = {}
    for name, value in values.items():
        if kinds.get(name) is float:
            result[name] = float(value)
        elif kinds.get(name) is not tuple:
            result[name] = value
        elif value:  # ROS cannot read an empty array from a file; left out, it is the default
            result[name] = [float(item) for item in value]
    return result
