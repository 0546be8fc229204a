"""A trained surrogate as the assessor's predictor."""

from __future__ import annotations

from tethernet_core.layout import KNOT_ROWS
from tethernet_planner.inference.net_features import features
from tethernet_planner.inference.net_sample import NetSample
from tethernet_planner.inference.prediction import Prediction
from tethernet_planner.inference.surrogate_file import Surrogate


class SurrogatePredictor:
    """Asks a surrogate what the capture will come to, by what the net looks like at the start of closing."""

    def __init__(self, surrogate: Surrogate):
        """Args:
        surrogate: made for the mission's number of MUs.
        """
        self._surrogate = surrogate

    def predict(self, sample: NetSample) -> Prediction:
        """See :class:`.prediction.Predictor`.

        Raises:
            ValueError: for a net that the surrogate was not made for.
        """
        knots = len(sample.knot_positions)
        if knots != KNOT_ROWS**2:
            raise ValueError(f"a net of {knots} knots; surrogates are made for {KNOT_ROWS} x {KNOT_ROWS}")
        row = features(
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
