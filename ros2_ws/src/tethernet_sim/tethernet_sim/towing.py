"""How the chaser tows in a hold test: it takes up what is slack slowly, and then keeps the tension.

Chaser and debris are two masses m_c and m_t that a soft net and a tether connect. With F the chaser's thrust away from
the debris, T the tension and d their distance, m d'' = F m_t / (m_c + m_t) - T, m = m_c m_t / (m_c + m_t). The thrust
makes the distance grow at a rate in proportion to the tension that is missing, so that it is small when tether and net
become taut: a stop at the rate v jerks with v sqrt(k m), 230 N at 0.2 m/s with a tether of 1000 N/m and a chaser of
1600 kg.
"""

from __future__ import annotations

LARGEST_SHARE = 5.0
"""The largest thrust, forward or braking, as so many times what steady towing takes [A]."""
TAKE_UP_M_S = 0.2
"""Rate at which the distance to the debris grows while nothing is taut [A]."""
LAG_S = 1.0
"""Time in which the rate follows; about one over the natural rate of such a tether, chaser and debris."""


def steady_thrust(tension: float, chaser_kg: float, towed_kg: float) -> float:
    """Thrust that tows with a steady tension, all bodies accelerating as one [N].

    Args:
        tension: of the main tether [N].
        chaser_kg: mass of the chaser [kg].
        towed_kg: mass of net, units and debris [kg].
    """
    return tension * (chaser_kg + towed_kg) / towed_kg


def thrust(asked: float, tension: float, rate: float, chaser_kg: float, towed_kg: float) -> float:
    """The chaser's thrust away from the debris for the next control period [N]; negative: it brakes.

    Args:
        asked: tension that the tether is to carry [N]; 0: no thrust.
        tension: that it carries now [N].
        rate: of the distance between chaser and debris [m/s].
        chaser_kg: mass of the chaser [kg].
        towed_kg: mass of net, units and debris [kg].
    """
    if asked <= 0.0:
        return 0.0
    largest, reduced = LARGEST_SHARE * steady_thrust(asked, chaser_kg, towed_kg), chaser_kg * towed_kg
    reduced /= chaser_kg + towed_kg
    wanted = TAKE_UP_M_S * max(1.0 - tension / asked, -1.0)
    force = steady_thrust(reduced * (wanted - rate) / LAG_S + min(tension, asked), chaser_kg, towed_kg)
    return min(max(force, -largest), largest)
