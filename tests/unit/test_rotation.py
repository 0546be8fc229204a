"""Rotations against SciPy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tethernet_core import rotation

ATTITUDES = Rotation.random(50, random_state=1).as_quat()
VECTORS = np.random.default_rng(2).normal(size=(50, 3))


def test_rotate_matrix_and_turned_agree_with_scipy():
    wanted = Rotation.from_quat(ATTITUDES).apply(VECTORS)
    assert rotation.rotate(ATTITUDES, VECTORS) == pytest.approx(wanted, abs=1e-14)
    for attitude, vector, result in zip(ATTITUDES, VECTORS, wanted, strict=True):
        assert rotation.matrix(attitude) @ vector == pytest.approx(result, abs=1e-14)
        assert rotation.turned(attitude.tolist(), vector.tolist()) == tuple(rotation.rotate(attitude, vector))


def test_rotate_broadcasts_over_leading_axes():
    attitudes = ATTITUDES.reshape(5, 10, 4)
    assert rotation.rotate(attitudes, np.array([0.0, 0.0, 1.0])).shape == (5, 10, 3)
    back = rotation.rotate(rotation.inverse(attitudes), rotation.rotate(attitudes, VECTORS.reshape(5, 10, 3)))
    assert back == pytest.approx(VECTORS.reshape(5, 10, 3), abs=1e-14)


def test_unit_normalises_what_is_near_and_refuses_the_rest():
    assert rotation.unit((0.0, 0.0, 0.0, 1.0005)) == (0.0, 0.0, 0.0, 1.0)
    for bad in ((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.1), (np.nan, 0.0, 0.0, 1.0), (np.inf, 0.0, 0.0, 1.0)):
        with pytest.raises(ValueError, match="allowed: 1 within"):
            rotation.unit(bad)
