"""What the MUs measure: true position and velocity plus Gaussian noise (paper: 3 sigma = 0.1 m and 0.1 m/s per axis,
20 Hz).
"""

from __future__ import annotations

import numpy as np

from tethernet_core.settings import ControlParameters

AHEAD = 100
"""Control ticks drawn at once."""


class OdometryNoise:
    """The noise of one scenario, control tick by control tick.

    One seed gives one sequence, whoever draws it and in pieces of whatever size.
    """

    def __init__(self, seed: int, mu_count: int, control: ControlParameters):
        """Args:
        seed: of the scenario, not negative.
        mu_count: number of units.
        control: gives the standard deviations.
        """
        self._generator = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, mu_count])))
        self._shape = (mu_count, 2, 3)
        self._sigma = np.array([[control.position_sigma_m], [control.velocity_sigma_m_s]])
        self._ahead, self._used = np.zeros((0, *self._shape)), 0

    def draw_next(self) -> np.ndarray:
        """Noise of the next control tick, shape (M, 2, 3); not to be mixed with :meth:`draw`, because it draws ahead:
        many small draws take ten times as long.
        """
        if self._used == len(self._ahead):
            self._ahead, self._used = self.draw(AHEAD), 0
        self._used += 1
        return self._ahead[self._used - 1]

    def draw(self, ticks: int) -> np.ndarray:
        """Noise of the next ``ticks`` control ticks, shape (ticks, M, 2, 3): position [m], velocity [m/s]."""
        return self._generator.standard_normal((ticks, *self._shape)) * self._sigma
