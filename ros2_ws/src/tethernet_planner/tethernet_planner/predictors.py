"""Predictors of the capture's outcome at the start of closing, by their names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tethernet_core.errors import InputError
from tethernet_core.shown import SHORT, shown
from tethernet_core.system import System
from tethernet_planner.inference import shipped_models
from tethernet_planner.inference.prediction import Predictor

NONE = "none"

SURROGATE = "surrogate"
"""The trained surrogate that is shipped for the system."""

_FACTORIES: dict[str, Callable[[System], Predictor]] = {}


class PredictorError(InputError):
    """No predictor has this name, or it cannot be loaded."""


def register(name: str, factory: Callable[[System], Predictor]) -> None:
    """Make a predictor known by its name.

    Args:
        name: value of the assessor's parameter ``predictor``.
        factory: makes the predictor for a system.
    """
    _FACTORIES[name] = factory


def make(name: str, system: System) -> Predictor | None:
    """The predictor with this name; None for ``none``.

    Args:
        name: a name, or the path of a surrogate's file.
        system: that it is for.

    Raises:
        PredictorError: saying what is wrong and what is allowed.
    """
    if name == NONE:
        return None
    if name in _FACTORIES:
        return _FACTORIES[name](system)
    if name == SURROGATE or shipped_models.means_file(name):
        return _trained(name, system)
    allowed = ", ".join([NONE, *sorted([*_FACTORIES, SURROGATE])])
    raise PredictorError(
        f"no predictor named {shown(repr(name), SHORT)}; allowed: {allowed}, "
        f"or the path of a surrogate{shipped_models.SUFFIX}"
    )


def fingerprint(name: str, system: System) -> str | None:
    """Short hash of a surrogate's file; None for a predictor without one.

    Raises:
        PredictorError: when there is no such file.
    """
    if name in (NONE, *_FACTORIES):
        return None
    from tethernet_planner.inference.model_file import file_fingerprint

    return file_fingerprint(_file(name, system))


def _trained(name: str, system: System) -> Predictor:
    from tethernet_planner.inference.surrogate_file import ModelFileError, Surrogate
    from tethernet_planner.inference.surrogate_predictor import SurrogatePredictor

    file = _file(name, system)
    try:
        surrogate = Surrogate.load(file)
        return SurrogatePredictor(surrogate, system)
    except ModelFileError as error:
        raise PredictorError(f"predictor {shown(name, SHORT)}: {error}") from error


def _file(name: str, system: System) -> Path:
    try:
        return shipped_models.find(shipped_models.SURROGATE, name, SURROGATE, system.name)
    except FileNotFoundError as error:
        raise PredictorError(f"predictor {shown(name, SHORT)}: {error}; {NONE} needs none") from error
