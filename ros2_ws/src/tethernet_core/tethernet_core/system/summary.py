"""A system in lines of text."""

from __future__ import annotations

from collections import Counter

from .hardware import Hardware
from .mouth_left_open import least_girth_m, widest_loop_m, widest_loop_of_capture_m

_LABEL_WIDTH = 10


def summary_lines(system: Hardware, digest: str) -> list[str]:
    """What a system is, a line or two for each part.

    Args:
        system: any.
        digest: of its hardware.

    Returns:
        Lines without line ends, at most about 120 characters.
    """
    lines = [f"{system.name}: {system.description}" if system.description else system.name]
    for label, texts in (
        ("net", _net(system)),
        ("units", _units(system)),
        ("closing", _closing(system)),
        ("launch", [_launch(system)]),
        ("debris", _debris(system)),
        ("chaser", [f"{system.chaser.mass_kg:g} kg, cube of {system.chaser.side_m:g} m"]),
        ("tether", [_tether(system)]),
        ("captured", [_capture(system)]),
        ("parameters", _parameters(system)),
        ("digest", [digest]),
    ):
        for i, text in enumerate(texts):
            lines.append(f"  {label if i == 0 else '':<{_LABEL_WIDTH}} {text}")
    return lines


def _net(system: Hardware) -> list[str]:
    net, thread = system.net, system.net.material
    size = net.nodes.max(axis=0) - net.nodes.min(axis=0)
    springs = "" if net.own_node_count == net.node_count else f" ({net.own_node_count} of its own, threads in springs)"
    lines = [
        f"{net.kind}, {size[0]:.4g} x {size[1]:.4g} m, mesh {net.mesh_m:g} m: {net.node_count} nodes{springs}, "
        f"{net.thread_count} threads, {net.mass_kg:.3g} kg, tether at node {net.center_node}",
        f"{thread.material or 'thread'}, radius {1000.0 * thread.radius_m:g} mm, E {thread.modulus_pa / 1e9:g} GPa, "
        f"{thread.density_kg_m3:g} kg/m^3, damping ratio {thread.damping_ratio:g}"
        + ("" if thread.strength_n is None else f", breaks at {thread.strength_n:.4g} N"),
    ]
    for mass, count in Counter(point.mass_kg for point in net.point_masses).items():
        lines.append(f"{count} masses of {mass:g} kg")
    return lines


def _units(system: Hardware) -> list[str]:
    if not system.units:
        return ["none"]
    lines = []
    kinds = Counter((u.mass_kg, u.propellant_kg, u.thrust_limit_n, u.specific_impulse_s) for u in system.units)
    for (mass, propellant, thrust, impulse), count in kinds.items():
        lines.append(
            f"{count} of {mass:g} kg with {propellant:g} kg propellant, up to {thrust:g} N along each axis, "
            f"Isp {impulse:g} s"
        )
    hang = ", ".join(f"{unit.node} ({unit.thread_length_m:.3g} m)" for unit in system.units)
    lines.append(f"on nodes (thread): {hang}")
    reach = sorted({f"{value:.4g}" for value in system.unit_reach_m}, key=float)
    lines.append(f"reach {' and '.join(reach) if len(reach) < 3 else reach[0] + ' to ' + reach[-1]} m from the middle")
    return lines


def _closing(system: Hardware) -> list[str]:
    closing = system.closing
    if closing.kind == "docking":
        ring = "-".join(str(unit) for unit in system.closing_ring)
        whole = widest_loop_m(system, [True] * closing.max_locked_pairs)
        needed, worst = system.capture.required_locked_pairs, widest_loop_of_capture_m(system)
        return [
            f"units dock within {closing.docking_distance_m:g} m, ring {ring}, drawn together at "
            f"{closing.draw_in_m_s:g} m/s with up to {closing.pull_n:g} N",
            f"leaves loops of net up to {whole:.1f} m round with all pairs docked, {worst:.1f} m with the {needed} of "
            f"a capture; least girth of the debris: {least_girth_m(system.debris.shape):.1f} m",
        ]
    if closing.kind == "winch":
        return [
            f"{closing.winch_thread_count} winches, ring of {len(closing.ring)} nodes that lock within "
            f"{closing.docking_distance_m:g} m, {closing.winch_speed_m_s:g} m/s, up to {closing.winch_tension_n:g} N"
        ]
    return ["none"]


def _launch(system: Hardware) -> str:
    launch = system.launch
    if launch.kind == "flown":
        return "flown: the units pull the net out"
    speeds = sorted({round(float((v @ v) ** 0.5), 6) for v in launch.velocities})
    speed = f"{speeds[0]:g}" if len(speeds) == 1 else f"{speeds[0]:g} to {speeds[-1]:g}"
    return f"{len(launch.particles)} bodies ejected at {speed} m/s"


def _debris(system: Hardware) -> list[str]:
    debris = system.debris
    moments = ", ".join(f"{debris.inertia[i, i]:.4g}" for i in range(3))
    return [
        f"{debris.shape.kind}, {debris.mass_kg:g} kg, {debris.shape.extent_m:.4g} m from end to end, inertia {moments} "
        "kg m^2",
        f"for the CQI: {debris.cqi_volume_m3:.4g} m^3, {debris.cqi_area_m2:.4g} m^2, {debris.cqi_length_m:.4g} m",
    ]


def _tether(system: Hardware) -> str:
    tether = system.tether
    if tether.stiffness_n_m == 0.0 and tether.damping_n_s_m == 0.0:
        return "none"
    return f"{tether.stiffness_n_m:g} N/m, {tether.damping_n_s_m:g} N s/m when locked"


def _capture(system: Hardware) -> str:
    capture = system.capture
    counted = "units counted" if capture.center_of_mass == "all" else "of the knots alone"
    return (
        f"CQI below {capture.cqi_threshold:g} (centre of mass {counted}) and {capture.required_locked_pairs} of "
        f"{system.closing.max_locked_pairs} pairs locked"
    )


def _parameters(system: Hardware) -> list[str]:
    return [
        f"{section}.{name} = {value}" for section, values in system.parameters.items() for name, value in values.items()
    ]
