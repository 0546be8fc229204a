"""The debris, whatever its representation: which kernel serves is settled when a step is compiled."""

from __future__ import annotations

from typing import Any

from tethernet_sim.kernels import cylinder_body, dispatch, general_body
from tethernet_sim.kernels.options import INLINED

_KERNELS = {cylinder_body.CylinderBody: cylinder_body, general_body.GeneralBody: general_body}
Body = cylinder_body.CylinderBody | general_body.GeneralBody


def surface(body: Body, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Signed distance [m] and outward unit normal at a point of the body frame, from the centre of mass [m]."""
    raise NotImplementedError


def reach(body: Body) -> float:
    """Its farthest point from its centre of mass [m]."""
    raise NotImplementedError


def farthest(body: Body) -> float:
    """A bound of the distance of its farthest point from its centre of mass that a rotation moves [m]."""
    raise NotImplementedError


def frame(body: Body, matrix: Any) -> Any:
    """What :func:`within` needs of the attitude ``matrix`` (3, 3)."""
    raise NotImplementedError


def inflated(body: Body, size: float) -> Any:
    """What :func:`within` needs of the body made larger by ``size`` [m]."""
    raise NotImplementedError


def within(body: Body, frame: Any, limits: Any, dx: float, dy: float, dz: float) -> bool:
    """Whether a point is in the inflated body, or misses it by little; its place from the centre of mass [m], launch
    frame.
    """
    raise NotImplementedError


def parts(body: Body) -> int:
    """How many parts :func:`part_surface` knows: those along whose surfaces a thread is looked at one by one."""
    raise NotImplementedError


def span(body: Body, part: int) -> tuple[float, float]:
    """The share of a thread's length that is looked at, from and to: all of it for a convex part."""
    raise NotImplementedError


def part_surface(body: Body, part: int, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """:func:`surface` of one part."""
    raise NotImplementedError


def decides(body: Body, part: int, x: float, y: float, z: float, distance: float) -> bool:
    """Whether the body is no nearer to a point than the part is, which is so far away."""
    raise NotImplementedError


def rate(body: Body, state: Any, matrix: Any, output: Any) -> None:
    """Write the angular rate in the launch frame [rad/s] to ``output`` (3,)."""
    raise NotImplementedError


def drift(body: Body, state: Any, matrix: Any, duration: float) -> None:
    """Move the body state (13,) freely for ``duration`` [s], any; ``matrix`` is brought up to date."""
    raise NotImplementedError


def step(body: Body, state: Any, matrix: Any, duration: float) -> None:
    """Move the body state (13,) freely for one step of the integration [s]; ``matrix`` is brought up to date."""
    raise NotImplementedError


for _function in (
    surface, reach, farthest, frame, inflated, within, parts, span, part_surface, decides, rate, drift, step
):  # fmt: skip
    dispatch.serve_by_module(_function, _KERNELS, INLINED)
