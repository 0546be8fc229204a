"""When what a person gives as a unit quaternion is one, in a description, a parameter file or on a command line.

Quaternions in messages are judged more mildly, see :data:`.rotation.NORM_TOLERANCE`: there rounding is no mistake.
"""

TOLERANCE = 1e-6
"""[-] So far from 1 may the norm be: numbers are given with seven digits or more."""


def is_unit(norm: float) -> bool:
    """Whether a norm is 1, as far as given digits can tell; NaN is not."""
    return abs(norm - 1.0) <= TOLERANCE
