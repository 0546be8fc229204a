"""One number for a system's hardware, by which models know what they were made for."""

from __future__ import annotations

import hashlib
import json
from typing import Any

import numpy as np

from .hardware import Hardware

_DIGITS = 12
"""Significant digits that count: sines and cosines differ in the last bits from one machine to another."""


def hardware_digest(hardware: Hardware) -> str:
    """SHA-256 of everything that the hardware is made of, in hexadecimal digits.

    It does not depend on how the hardware is described (comments, order and defaults of entries, names, files or
    tables), nor on name, description and parameters.
    """
    return hashlib.sha256(json.dumps(_content(hardware), sort_keys=True).encode()).hexdigest()


def _content(hardware: Hardware) -> dict[str, Any]:
    net, thread, closing, debris = hardware.net, hardware.net.material, hardware.closing, hardware.debris
    return {
        "net": {
            "nodes": _array(net.nodes),
            "threads": _array(np.sort(net.threads, axis=1)),
            "rest_lengths": _array(net.rest_lengths),
            "center": net.center_node,
            "thread": _numbers(
                thread.radius_m, thread.modulus_pa, thread.density_kg_m3, thread.damping_ratio, thread.strength_pa
            ),
            "masses": [[point.node, *_numbers(point.mass_kg)] for point in net.point_masses],
        },
        "units": [
            [
                unit.node,
                *_numbers(
                    unit.thread_length_m, unit.thread_stiffness_n_m, unit.thread_damping_n_s_m, unit.mass_kg,
                    *unit.box_m, unit.radius_m, unit.thrust_limit_n, unit.specific_impulse_s, unit.propellant_kg,
                ),
            ]
            for unit in hardware.units
        ],
        "closing": [
            closing.kind,
            list(closing.ring),
            list(closing.winches),
            _numbers(
                closing.docking_distance_m, closing.draw_in_m_s, closing.pull_n, closing.winch_speed_m_s,
                closing.winch_tension_n, closing.winch_stiffness_n_m,
            ),
        ],
        "launch": [hardware.launch.kind, list(hardware.launch.particles), _array(hardware.launch.velocities)],
        "debris": {
            "shape": [debris.shape.kind, debris.shape.digest],
            "center_of_mass": _array(debris.center_of_mass),
            "mass": _numbers(debris.mass_kg),
            "inertia": _array(debris.inertia),
            "cqi": _numbers(debris.given_volume_m3, debris.given_area_m2, debris.given_length_m),
        },
        "chaser": _numbers(hardware.chaser.mass_kg, hardware.chaser.side_m),
        # A strength counts only where it is given, so that systems described before there was one keep their number.
        "tether": _numbers(
            hardware.tether.stiffness_n_m, hardware.tether.damping_n_s_m,
            *([] if hardware.tether.strength_n is None else [hardware.tether.strength_n]),
        ),
        "capture": [
            hardware.capture.required_locked_pairs,
            hardware.capture.center_of_mass,
            *_numbers(hardware.capture.cqi_threshold),
        ],
        "aiming": _array(hardware.aiming.offsets),
    }  # fmt: skip


def _numbers(*values: float | None) -> list[str | None]:
    # A zero has one sign here; what rounding leaves of a difference is none.
    return [None if value is None else f"{value + 0.0:.{_DIGITS}g}" for value in values]


def _array(array: np.ndarray) -> list[Any]:
    if array.dtype.kind == "i":
        return list(array.tolist())
    clean = np.where(np.abs(array) < 1e-12 * max(float(np.abs(array).max(initial=0.0)), 1e-300), 0.0, array)
    return [list(array.shape), _numbers(*clean.ravel().tolist())]
