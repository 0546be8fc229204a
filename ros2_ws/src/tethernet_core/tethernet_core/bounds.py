"""Beyond all measure: no body of a mission is ever so far off or so fast, whatever a message or a simulation says.

One set of limits for both: what a simulation may publish, nobody refuses, and what it must not, it stops at.
"""

FARTHEST_M = 1e6
"""Of any coordinate [m]: a mission happens within 100 m; at this distance squares and sums are still exact enough."""

FASTEST_M_S = 1e5
"""Of any velocity [m/s]: nothing that an MU meets is faster than in orbit."""

FASTEST_RAD_S = 1e3
"""Of any angular rate [rad/s]."""
