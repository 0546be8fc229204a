"""Descriptions of shapes: there and back, and errors that name the entry."""

from __future__ import annotations

import pytest

from tethernet_core.shapes import ShapeError, shape_from

GOOD = {
    "cylinder": {"kind": "cylinder", "radius_m": 1.95, "length_m": 11.1},
    "box": {"kind": "box", "size_m": [1.0, 2.0, 3]},
    "sphere": {"kind": "sphere", "radius_m": 2},
    "capsule": {"kind": "capsule", "radius_m": 1.0, "length_m": 4.0},
    "cone": {"kind": "cone", "base_radius_m": 1.0, "length_m": 2.0, "top_radius_m": 0.5},
    "compound": {
        "kind": "compound",
        "parts": [
            {"shape": {"kind": "sphere", "radius_m": 1.0}, "mass_share": 0.25},
            {
                "shape": {"kind": "box", "size_m": [1.0, 1.0, 1.0]},
                "position_m": [1.0, 0.0, 0.0],
                "attitude": [0.0, 0.0, 0.6, 0.8],
                "mass_share": 0.75,
            },
        ],
    },
}


@pytest.mark.parametrize("kind", GOOD)
def test_a_description_makes_a_shape_and_the_shape_its_description(kind):
    shape = shape_from(GOOD[kind])
    assert shape.kind == kind
    again = shape_from(shape.entries())
    assert again == shape and again.digest == shape.digest


def test_the_tip_of_a_cone_may_be_left_out():
    assert shape_from({"kind": "cone", "base_radius_m": 1.0, "length_m": 2.0}).entries()["top_radius_m"] == 0.0


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ("cylinder", "debris.shape = 'cylinder': no description"),
        ({}, "debris.shape lacks kind; allowed: one of box, capsule"),
        ({"kind": "torus"}, "debris.shape.kind = 'torus': unknown; allowed: one of box"),
        ({"kind": ["box"]}, r"debris.shape.kind = \['box'\]: unknown"),
        ({"kind": "sphere"}, "debris.shape: a sphere lacks radius_m"),
        ({"kind": "sphere", "radius_m": 1, "colour": 2}, "a sphere has no entry 'colour'; it has: radius_m"),
        ({"kind": "sphere", "radius_m": -1}, "debris.shape.radius_m = -1: out of range; allowed: 0.001 to 1000 m"),
        ({"kind": "sphere", "radius_m": float("nan")}, "debris.shape.radius_m = nan: out of range"),
        ({"kind": "sphere", "radius_m": True}, "debris.shape.radius_m = True: not a number"),
        ({"kind": "sphere", "radius_m": "1"}, "debris.shape.radius_m = '1': not a number"),
        ({"kind": "box", "size_m": [1, 2]}, r"debris.shape.size_m = \[1, 2\]: not 3 numbers"),
        ({"kind": "box", "size_m": [1, 2, 0]}, r"debris.shape.size_m\[2\] = 0: out of range"),
        ({"kind": "capsule", "radius_m": 1, "length_m": 1.5}, "debris.shape.length_m = 1.5: shorter than its two"),
        ({"kind": "compound", "parts": []}, "debris.shape.parts = .*: no parts"),
        ({"kind": "compound", "parts": [3]}, r"debris.shape.parts\[0\] = 3: no part"),
        ({"kind": "compound", "parts": [{}]}, r"debris.shape.parts\[0\] lacks shape"),
        ({"kind": "compound", "shapes": []}, "a compound has no entry 'shapes'; it has: parts"),
        (
            {"kind": "compound", "parts": [{"shape": {"kind": "box", "size_m": [1, 2, "x"]}}]},
            r"debris.shape.parts\[0\].shape.size_m\[2\] = 'x': not a number",
        ),
        (
            {"kind": "compound", "parts": [{"shape": {"kind": "sphere", "radius_m": 1}, "attitude": [0, 0, 0, 0.5]}]},
            r"debris.shape.parts\[0\].attitude = \[0, 0, 0, 0.5\]: of norm 0.5; allowed: a unit quaternion",
        ),
        (
            {"kind": "compound", "parts": [{"shape": {"kind": "sphere", "radius_m": 1}, "at": [0, 0, 0]}]},
            r"debris.shape.parts\[0\] has no entry 'at'; it has: shape, position_m",
        ),
        (
            {
                "kind": "compound",
                "parts": [{"shape": {"kind": "sphere", "radius_m": 1}, "mass_share": s} for s in (0.5, 0.6)],
            },
            "debris.shape.parts: their mass_share sum to 1.1; allowed: 1",
        ),
        (
            {
                "kind": "compound",
                "parts": [{"shape": {"kind": "sphere", "radius_m": 1}} | m for m in ({"mass_share": 1.0}, {})],
            },
            r"debris.shape.parts\[1\] lacks mass_share; allowed: mass_share in all parts or in none",
        ),
    ],
)
def test_an_error_names_the_entry_and_what_is_allowed(entries, message):
    with pytest.raises(ShapeError, match=message):
        shape_from(entries, where="debris.shape")
