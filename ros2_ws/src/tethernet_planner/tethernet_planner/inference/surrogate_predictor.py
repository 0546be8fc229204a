"""A trained surrogate as the assessor's predictor."""

from __future__ import annotations

from tethernet_core.system import System
from tethernet_planner.inference.net_features import features_of
from tethernet_planner.inference.net_sample import NetSample
from tethernet_planner.inference.prediction import Prediction
from tethernet_planner.inference.surrogate_file import Surrogate


class SurrogatePredictor:
    """Asks a surrogate what the capture will come to, by what the net looks like at the start of closing."""

    def __init__(self, surrogate: Surrogate, system: System):
        """Args:
        surrogate: made for the mission's system.
        system: that one.

        Raises:
            ModelFileError: when it was made for another.
        """
        surrogate.check_system(system)
        self._surrogate, self._system = surrogate, system

    def predict(self, sample: NetSample) -> Prediction:
        """See :class:`.prediction.Predictor`.

        Raises:
            ValueError: for a net that the surrogate was not made for.
        """
        nodes, expected = len(sample.knot_positions), self._system.net.node_count
        if nodes != expected:
            raise ValueError(f"a net of {nodes} nodes; that of system {self._system.name} has {expected}")
        row = features_of(
            self._surrogate.arrays["nodes"],
            sample.knot_positions,
            sample.knot_velocities,
            sample.mu_positions,
            sample.mu_velocities,
            sample.debris_position,
            sample.debris_velocity,
        )
        predicted = self._surrogate.predict_many(row[None])
        return Prediction(
            float(predicted.cqi[0]), float(predicted.locked_pairs[0]), float(predicted.capture_probability[0])
        )
