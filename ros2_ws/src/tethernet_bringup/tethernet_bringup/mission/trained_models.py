"""Which trained models fly along: chosen where none was asked for, loaded once before anything starts."""

from __future__ import annotations

from tethernet_bringup.mission.parameter_checks import MissionParametersError, Sources, Values
from tethernet_bringup.nodes import ASSESSOR, PLANNER
from tethernet_core.system import System


def choose_models(values: Values, system: System, sources: Sources) -> list[str]:
    """Where no trained model is shipped for the system and none was asked for, fly without.

    Args:
        values: the nodes' parameters; changed.
        system: that is flown.
        sources: of those that were given.

    Returns:
        What there is to say of it.
    """
    from tethernet_planner import policies
    from tethernet_planner import predictors as prediction
    from tethernet_planner.inference import shipped_models

    notices = []
    for node, key, kind, shipped, without, what in (
        (PLANNER, "policy", shipped_models.POLICY, policies.RL, policies.NOMINAL, "the nominal points are flown"),
        (
            ASSESSOR,
            "predictor",
            shipped_models.SURROGATE,
            prediction.SURROGATE,
            prediction.NONE,
            "nothing is predicted",
        ),
    ):
        if values[node][key] == shipped and (node, key) not in sources and not _is_shipped(kind, system):
            values[node][key] = without
            if system.units:
                notices.append(f"no {key} is shipped for system {system.name}: {what}")
    return notices


def check_models(values: Values, system: System, sources: Sources) -> dict[str, str]:
    """Load what is trained.

    Paths become absolute: the nodes need not run in this folder, and the mission may be flown again from another one.

    Args:
        values: the nodes' parameters; changed.
        system: that is flown.
        sources: of those that were given.

    Returns:
        The hashes of the models' files, by the parameter that names them.

    Raises:
        MissionParametersError: for a model that there is not, or that cannot be loaded or used for this system.
    """
    from tethernet_planner import policies
    from tethernet_planner import predictors as prediction
    from tethernet_planner.inference import shipped_models

    hashes: dict[str, str | None] = {}
    policy, predictor = values[PLANNER]["policy"], values[ASSESSOR]["predictor"]
    try:
        policies.check(policy, system)
        hashes["policy"] = policies.fingerprint(policy, system)
    except ValueError as error:
        raise MissionParametersError(f"{sources.get((PLANNER, 'policy'), PLANNER + ': ')}{error}") from error
    try:
        prediction.make(predictor, system)
        hashes["predictor"] = prediction.fingerprint(predictor, system)
    except ValueError as error:
        raise MissionParametersError(f"{sources.get((ASSESSOR, 'predictor'), ASSESSOR + ': ')}{error}") from error
    values[PLANNER]["policy"] = shipped_models.absolute(policy)
    values[ASSESSOR]["predictor"] = shipped_models.absolute(predictor)
    return {key: value for key, value in hashes.items() if value}


def _is_shipped(kind: str, system: System) -> bool:
    from tethernet_planner.inference import shipped_models

    return shipped_models.place(kind, system.name).is_file()
