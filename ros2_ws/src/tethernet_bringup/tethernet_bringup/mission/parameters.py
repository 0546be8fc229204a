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

from tethernet_bringup.mission.supervisor_settings import SupervisorParameters
from tethernet_bringup.nodes import ASSESSOR, MONITOR, PLANNER, RECORDER, SIM, controller, mu_of
from tethernet_core.layout import DESIGNS, system_of
from tethernet_core.parameters import ParameterError, build, defaults, field_types, read_yaml
from tethernet_core.settings import ControlParameters, MissionParameters
from tethernet_core.shown import SHORT, shown
from tethernet_planner.mission_rules import check_debris_position
from tethernet_sim.settings import ScenarioParameters

ALL_NODES = "/**"
IDENTITY = "mu"
"""A controller's parameter that has no default: which MU it controls."""

_SCENARIO_FLAGS = {
    "debris_position": "debris",
    "debris_attitude": "attitude",
    "debris_rate": "tumble",
    "seed": "seed",
    "pace": "pace",
}

Values = dict[str, dict[str, Any]]
"""Parameters by node and name."""


class MissionParametersError(ValueError):
    """A parameter cannot be used: which, where it was given, what is allowed."""


@dataclass(frozen=True)
class MissionSetup:
    """One mission's parameters, complete and checked."""

    scenario: ScenarioParameters
    policy: str
    """The policy that chooses the aiming points: a name, or the absolute path of its file."""
    models: dict[str, str]
    """Short hashes of the trained models that fly along, ``policy`` and ``predictor``."""
    simulated: bool
    """Whether the simulator runs."""
    external: tuple[int, ...]
    """MUs with a driver of their own."""
    supervisor: SupervisorParameters
    control: ControlParameters
    """The rhythm of control, the same for all nodes."""
    nodes: Values
    """What each node gets."""

    @property
    def mu_count(self) -> int:
        """4 or 8."""
        return self.scenario.mu_count

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
        return planner["launch_delay_s"] + planner["give_up_s"] + planner["capture_duration_s"]

    def recorded_in(self, bag: Path, run_info: Path) -> MissionSetup:
        """The same mission, recorded in this folder with the facts from this JSON file."""
        recorder = {**self.nodes[RECORDER], "output": str(bag), "run_info": str(run_info)}
        return dataclasses.replace(self, nodes={**self.nodes, RECORDER: recorder})

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
    mu_count = _mu_count(options, given)
    classes = node_classes(mu_count, simulated)
    values: Values = {
        node: {k: v for cls in kinds for k, v in defaults(cls).items()} for node, kinds in classes.items()
    }
    sources = _apply_file(values, given, options, mu_count)
    _apply_flags(values, options, mu_count, sources)
    built = {node: _build(node, kinds, values[node], sources) for node, kinds in classes.items()}
    _check_shared(values)
    _check_recording(values[RECORDER]["extra_topics"], mu_count, sources)
    _check_flight_time(built, sources)
    models = _check_models(values, mu_count, sources)
    scenario = next(instance for instance in built[SIM] if isinstance(instance, ScenarioParameters))
    rules = next(instance for instance in built[PLANNER] if isinstance(instance, MissionParameters))
    _check_physics(built[SIM])
    try:
        check_debris_position(scenario.debris_position, rules)
    except ValueError as error:
        raise MissionParametersError(f"{sources.get((SIM, 'debris_position'), '')}{error}") from error
    for mu in range(1, mu_count + 1):
        values[controller(mu)] = {IDENTITY: mu, **values[controller(mu)]}
    return MissionSetup(
        scenario=scenario,
        policy=values[PLANNER]["policy"],
        models=models,
        simulated=simulated,
        external=tuple(range(1, mu_count + 1)) if not simulated else scenario.external,
        supervisor=built[MONITOR][0],
        control=next(instance for instance in built[PLANNER] if isinstance(instance, ControlParameters)),
        nodes={node: _typed(classes[node], node_values) for node, node_values in values.items()},
    )


def node_classes(mu_count: int, simulated: bool = True) -> dict[str, tuple[type, ...]]:
    """The parameter classes of each node; a controller has its number besides.

    Args:
        mu_count: 4 or 8.
        simulated: whether the simulator runs; its scenario is checked in any case, because it says where the debris is.
    """
    from tethernet_bringup.recorder.settings import RecorderParameters
    from tethernet_planner.settings import AssessorParameters, PlannerParameters
    from tethernet_sim.settings import PhysicsParameters, SimNodeParameters

    return {
        SIM: (ScenarioParameters, SimNodeParameters, PhysicsParameters, ControlParameters),
        **{controller(mu): (ControlParameters,) for mu in range(1, mu_count + 1)},
        PLANNER: (PlannerParameters, MissionParameters, ControlParameters),
        ASSESSOR: (AssessorParameters, ControlParameters),
        RECORDER: (RecorderParameters,),
        MONITOR: (SupervisorParameters,),
    }


def _read(path: str) -> Values:
    try:
        return {
            node if node == ALL_NODES else node.lstrip("/"): values for node, values in read_yaml(Path(path)).items()
        }
    except ParameterError as error:
        raise MissionParametersError(f"--params: {error}") from error


def _mu_count(options: argparse.Namespace, given: Values) -> int:
    if options.mus is not None:
        return options.mus
    mu_count = given.get(SIM, {}).get(
        "mu_count", given.get(ALL_NODES, {}).get("mu_count", defaults(ScenarioParameters)["mu_count"])
    )
    if isinstance(mu_count, bool) or not isinstance(mu_count, int) or mu_count not in DESIGNS:
        raise MissionParametersError(
            f"--params {shown(options.params)}: mu_count = {shown(repr(mu_count), SHORT)}: no such design; "
            "allowed: 4 or 8"
        )
    return mu_count


def _apply_file(
    values: Values, given: Values, options: argparse.Namespace, mu_count: int
) -> dict[tuple[str, str], str]:
    """Put the file's values in; return where each came from."""
    sources: dict[tuple[str, str], str] = {}
    file = f"--params {shown(options.params)}"
    for node in sorted(given, key=lambda name: name != ALL_NODES):
        if node != ALL_NODES and node not in values:
            hint = f" (--mus {mu_count})" if mu_of(node) else ""
            raise MissionParametersError(
                f"{file}: no node {node!r} in this mission{hint}; there are: {', '.join(values)}, and {ALL_NODES}"
            )
        for key, value in given[node].items():
            if key == IDENTITY and mu_of(node):
                _check_identity(file, node, value)
                continue
            takers = [name for name in values if key in values[name]] if node == ALL_NODES else [node]
            if not takers:
                raise MissionParametersError(f"{file}: no node has a parameter {key!r}")
            if key not in values[takers[0]]:
                raise MissionParametersError(
                    f"{file}: {node} has no parameter {key!r}; it has: {', '.join(sorted(values[node]))}"
                )
            for taker in takers:
                values[taker][key] = value
                sources[taker, key] = f"{file}: {node}: "
    return sources


def _check_identity(file: str, node: str, value: Any) -> None:
    if value != mu_of(node):
        raise MissionParametersError(f"{file}: {node}: {IDENTITY} = {value!r}; allowed: {mu_of(node)}, its own number")


def _apply_flags(
    values: Values, options: argparse.Namespace, mu_count: int, sources: dict[tuple[str, str], str]
) -> None:
    scenario = values[SIM]
    for key, name in _SCENARIO_FLAGS.items():
        flag = getattr(options, name)
        if flag is not None:
            scenario[key] = list(flag) if isinstance(flag, tuple) else flag
            sources[SIM, key] = f"--{name}: "
    if options.external_mu:
        too_large = [mu for mu in options.external_mu if mu > mu_count]
        if too_large:
            raise MissionParametersError(f"--external-mu {too_large[0]}: out of range; allowed: 1 to {mu_count}")
        scenario["external_mus"] = " ".join(map(str, options.external_mu))
    if options.no_sim:
        scenario["external_mus"] = " ".join(str(mu) for mu in range(1, mu_count + 1))
        if scenario["pace"] != "realtime":
            raise MissionParametersError(
                f"pace {scenario['pace']!r} with --no-sim: no simulator waits; allowed: realtime"
            )
    scenario["mu_count"] = mu_count
    # What several nodes must know is said once, by the scenario, and handed to all that ask for it.
    shared = {
        "mu_count": mu_count,
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


def _check_recording(extra_topics: str, mu_count: int, sources: Mapping[tuple[str, str], str]) -> None:
    from tethernet_bringup.recorder.recorded_topics import wanted_topics

    try:
        wanted_topics(mu_count, extra_topics)
    except ParameterError as error:
        raise MissionParametersError(f"{sources.get((RECORDER, 'extra_topics'), RECORDER + ': ')}{error}") from error


def _check_models(values: Values, mu_count: int, sources: Mapping[tuple[str, str], str]) -> dict[str, str]:
    """Load what is trained once, before anything starts; returns the hashes of their files.

    Paths become absolute: the nodes need not run in this folder, and the mission may be flown again from another one.
    """
    from tethernet_planner import policies
    from tethernet_planner import predictors as prediction
    from tethernet_planner.inference import shipped_models

    hashes = {}
    system = system_of(mu_count)
    named = values[PLANNER]["policy"]
    try:
        policies.check(named, system)
        hashes["policy"] = policies.fingerprint(named, system)
    except policies.PolicyError as error:
        raise MissionParametersError(f"{sources.get((PLANNER, 'policy'), PLANNER + ': ')}{error}") from error
    values[PLANNER]["policy"] = shipped_models.absolute(named)
    named = values[ASSESSOR]["predictor"]
    try:
        prediction.make(named, mu_count)
        hashes["predictor"] = prediction.fingerprint(named, mu_count)
    except prediction.PredictorError as error:
        raise MissionParametersError(f"{sources.get((ASSESSOR, 'predictor'), ASSESSOR + ': ')}{error}") from error
    values[ASSESSOR]["predictor"] = shipped_models.absolute(named)
    return {key: value for key, value in hashes.items() if value}


def _check_physics(built: Sequence[Any]) -> None:
    from tethernet_sim.settings import PhysicsParameters, check_together

    of_kind = {type(instance): instance for instance in built}
    try:
        check_together(*(of_kind[kind] for kind in (PhysicsParameters, ControlParameters)))
    except ParameterError as error:
        raise MissionParametersError(f"{SIM}: {error}") from error


def _check_shared(values: Values) -> None:
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


def _check_flight_time(built: Mapping[str, list[Any]], sources: Mapping[tuple[str, str], str]) -> None:
    """A controller must not end a flight that the mission's rules allow."""
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
