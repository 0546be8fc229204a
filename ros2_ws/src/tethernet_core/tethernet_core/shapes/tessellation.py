"""Triangles of bodies of revolution and boxes."""

from __future__ import annotations

import math

import numpy as np

AROUND = 64
"""Corners of the polygon that stands for a circle."""


def revolved(profile: np.ndarray, around: int = AROUND) -> tuple[np.ndarray, np.ndarray]:
    """Revolve a polyline round the z axis.

    Args:
        profile: (radius, z) from the lowest to the highest point [m], both on the axis, shape (P, 2).
        around: corners of each circle.

    Returns:
        Vertices [m], shape (V, 3); faces, counter-clockwise from outside, shape (F, 3).
    """
    angle = np.arange(around) * (2.0 * math.pi / around)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = [np.array([[0.0, 0.0, profile[0, 1]]])]
    for radius, z in profile[1:-1]:
        vertices.append(np.column_stack([radius * circle, np.full(around, z)]))
    vertices.append(np.array([[0.0, 0.0, profile[-1, 1]]]))
    here = np.arange(around)
    then = (here + 1) % around
    top = 1 + (len(profile) - 2) * around
    faces = [np.column_stack([np.zeros(around, int), 1 + then, 1 + here])]
    for ring in range(len(profile) - 3):
        low, high = 1 + ring * around, 1 + (ring + 1) * around
        faces.append(np.column_stack([low + here, low + then, high + then]))
        faces.append(np.column_stack([low + here, high + then, high + here]))
    last = top - around
    faces.append(np.column_stack([last + here, last + then, np.full(around, top)]))
    return np.concatenate(vertices), np.concatenate(faces)


def cuboid(half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The twelve triangles of a box of given half sides [m], shape (3,)."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))])
    return corners, faces
