"""Shapes of rigid bodies: signed distance, rays, mass properties, triangles. A new shape is one file and its test."""

from .box import Box
from .capsule import Capsule
from .compound import Compound, Part
from .cone import Cone
from .cylinder import Cylinder
from .mesh import Mesh
from .registry import shape_from, shape_kinds, surface_functions
from .shape import Primitive, Shape, ShapeError
from .sphere import Sphere

__all__ = [
    "Box", "Capsule", "Compound", "Cone", "Cylinder", "Mesh", "Part", "Primitive", "Shape", "ShapeError", "Sphere",
    "shape_from", "shape_kinds", "surface_functions",
]  # fmt: skip
