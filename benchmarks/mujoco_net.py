#!/usr/bin/env python3
"""MuJoCo peer model of a tether net flown by maneuverable units (MUs).

An independent check of a purpose-written net simulator: the same physics, built from MuJoCo's own parts and stepped by
MuJoCo's own integrators. It shares no code and no number with the simulator.

Physics (SI units, zero gravity)
  * 23 x 23 knots, 1 m mesh, 1012 threads; a knot carries half the mass of each thread that ends on it (thread:
    r = 0.5 mm, rho = 1390 kg/m^3).
  * A thread carries tension only:  T = max(0, k (l - L0) + c dl/dt) for l > L0, else 0;  k = E A / 1 m,
    c = 2 zeta sqrt(k m_thread),  E = 70 GPa (--young), zeta = 0.106.  No bending, no contact.
  * 4 or 8 point MUs of 2.5 kg on massless threads with the same k and c: corners sqrt(2) m, side mid-points 0.71 m.
  * Start: net folded flat to 5 % of its size at z = z0, MUs on their knots.
  * Each MU follows a straight line to its place round the debris in 25 s under a 20 Hz PID (Kp 10, Ki 6, Kd 6 on
    velocity, zero-order hold, no noise), clipped to 5.1 N per axis.

MuJoCo representation
  Knots and MUs: one body each, three slide joints, no geoms (MuJoCo recognises these as "simple" bodies: the mass
  matrix is diagonal).  All constraint and contact stages are switched off.  Threads, chosen with --threads:

  actuator  (default) spatial tendon + affine-bias actuator, force = clip(k L0 - k l - c dl/dt, -1e9, 0).  Native, and
            tension only *including the damper*.  It differs from the law above only while l < L0 and
            c dl/dt > k (L0 - l), i.e. it takes up load at most c/k = 30 us before the thread is taut: less than one
            step.
  tendon    spring dead-band [0, L0] + tendon damping.  Native, but MuJoCo's tendon damper also acts on a slack thread
            and can push: unfaithful, offered to show how much that matters.
  tendon0   spring dead-band, no damping.
  callback  no tendons: a compiled (numba) mjcb_passive callback with exactly the law above.  MuJoCo then only
            integrates; this is the floor of its cost for 1611 slide joints.  Explicit in both stiffness and damping.
  flex      1-D flex (edge stiffness/damping).  Speed comparison only: flex edges also carry compression, so a folded
            net would burst open; rest lengths are left at the folded lengths and the physics is a different net.

Integrators: Euler (semi-implicit, = symplectic Euler here), implicitfast, implicit, RK4, discrete (MuJoCo 4: implicit
in tendon stiffness and damping).  implicit/implicitfast keep only the block-diagonal part of the damping derivative,
because every knot is its own kinematic tree; this acts as added inertia and makes the net lag.  discrete is stable at
any step (tried to 50 ms); MuJoCo caps its inner solve at --iterations, and stops short of --tolerance at 2 ms and above
(counted and printed); its steps were accurate to 5 ms.

Example:
  python -m benchmarks.mujoco_net --dt 1e-4 --tend 25 --mus 8 --integrator Euler --out run.npz

The .npz holds t, mu_pos (n, M, 3), mu_vel, net_com (n, 3), thrust (n, M, 3), max_speed (n,) and the settings, one row
per control period (20 Hz).
"""

from __future__ import annotations

import argparse
import math
import resource
import sys
import time
from collections.abc import Iterable, Sequence
from typing import Any

import mujoco
import numpy as np

from tethernet_core.system.option import family

ROWS = 23  # knots per side
MESH = 1.0  # [m]
RADIUS, RHO, ZETA = 0.5e-3, 1390.0, 0.106  # [m], [kg/m^3], [-]
MU_MASS = 2.5  # [kg]
FOLD, Z0 = 0.05, -1.5  # initial fold factor and height [m]
KP, KI, KD, FMAX = 10.0, 6.0, 6.0, 5.1  # [N/m], [N/(m s)], [N s/m], [N]
CONTROL_PERIOD, T_FLIGHT = 0.05, 25.0  # [s]
TOO_FAST = 500.0  # [m/s]: the state has blown up
TARGET_XY = np.array(
    [[-12, -12], [12, -12], [-12, 12], [12, 12], [0, -11.71], [11.71, 0], [-11.71, 0], [0, 11.71]], float
)
"""MU targets relative to the debris, x and y [m]."""
MU_LENGTH = [math.sqrt(2)] * 4 + [0.71] * 4
"""Lengths of the MUs' threads [m]."""
MU_KNOT = [(0, 0), (0, 22), (22, 0), (22, 22), (0, 11), (11, 22), (11, 0), (22, 11)]
"""(row, column) of the knot each MU hangs on; rows run along y, columns along x."""
THREADS = ("actuator", "tendon", "tendon0", "callback", "flex")
INTEGRATORS = ("Euler", "implicitfast", "implicit", "RK4", "discrete")


class Net:
    """Geometry, masses and threads, independent of MuJoCo."""

    def __init__(self, mus: int, young: float):
        """Args:
        mus: number of units, as in a shipped system.
        young: modulus of the threads [Pa].
        """
        area = math.pi * RADIUS**2
        self.k = young * area / MESH
        thread_mass = RHO * area * MESH
        self.c = 2 * ZETA * math.sqrt(self.k * thread_mass)
        ends = np.zeros((ROWS, ROWS))
        ends[:, :-1] += 0.5
        ends[:, 1:] += 0.5
        ends[:-1] += 0.5
        ends[1:] += 0.5
        self.knot_mass = (ends * thread_mass).ravel()
        grid = (np.arange(ROWS) - ROWS // 2) * MESH * FOLD
        gx, gy = np.meshgrid(grid, grid)  # gx varies along columns
        knots = np.stack([gx.ravel(), gy.ravel(), np.full(gx.size, Z0)], 1)
        self.n_knots = len(knots)
        hang = [r * ROWS + c for r, c in MU_KNOT[:mus]]
        self.pos0 = np.vstack([knots, knots[hang]])
        self.mass = np.concatenate([self.knot_mass, np.full(mus, MU_MASS)])
        index = np.arange(self.n_knots).reshape(ROWS, ROWS)
        along_rows = np.stack([index[:, :-1].ravel(), index[:, 1:].ravel()], 1)
        along_columns = np.stack([index[:-1].ravel(), index[1:].ravel()], 1)
        to_mus = np.array([(knot, self.n_knots + mu) for mu, knot in enumerate(hang)])
        self.pairs = np.vstack([along_rows, along_columns, to_mus])
        self.length = np.concatenate([np.full(len(along_rows) + len(along_columns), MESH), MU_LENGTH[:mus]])


def mjcf(
    net: Net,
    dt: float,
    integrator: str,
    threads: str,
    solver: str = "CG",
    iterations: int = 100,
    tolerance: float = 1e-8,
) -> str:
    """The model as an MJCF string."""
    # 'discrete' applies tendon/actuator stiffness inside its iterative solver, so the constraint stage stays on for it;
    # there are no constraint rows.
    off = "" if integrator == "discrete" else ' constraint="disable"'
    out = [
        f'<mujoco model="net"><compiler autolimits="false"/>'
        f'<option timestep="{dt:.17g}" integrator="{integrator}" gravity="0 0 0" '
        f'solver="{solver}" iterations="{iterations}" tolerance="{tolerance:g}">'
        f'<flag contact="disable" equality="disable" frictionloss="disable" '
        f'limit="disable" sensor="disable" gravity="disable" clampctrl="disable" '
        f'autoreset="disable" island="disable"{off}/></option>'
        f"<worldbody>"
    ]
    for i, (p, m) in enumerate(zip(net.pos0, net.mass, strict=True)):
        out.append(
            f'<body name="b{i}" pos="{_numbers(p)}">'
            f'<inertial pos="0 0 0" mass="{m:.17g}" diaginertia="1e-6 1e-6 1e-6"/>'
            '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
            '<joint type="slide" axis="0 0 1"/>'
            f'<site name="s{i}"/></body>'
        )
    out.append("</worldbody>")
    if threads in ("actuator", "tendon", "tendon0"):
        out += _tendons(net, threads)
    if threads == "flex":
        bodies = " ".join(f"b{i}" for i in range(len(net.mass)))
        elements = " ".join(f"{a} {b}" for a, b in net.pairs)
        out.append(
            f'<deformable><flex name="f" dim="1" radius="0.001" body="{bodies}" element="{elements}">'
            f'<contact contype="0" conaffinity="0" selfcollide="none"/>'
            f'<edge stiffness="{net.k:.17g}" damping="{net.c:.17g}"/></flex></deformable>'
        )
    out.append("</mujoco>")
    return "".join(out)


def _tendons(net: Net, threads: str) -> list[str]:
    out = ["<tendon>"]
    for j, ((a, b), l0) in enumerate(zip(net.pairs, net.length, strict=True)):
        law = ""
        if threads != "actuator":
            c = net.c if threads == "tendon" else 0.0
            law = f' springlength="0 {l0:.17g}" stiffness="{net.k:.17g}" damping="{c:.17g}"'
        out.append(f'<spatial name="t{j}"{law}><site site="s{a}"/><site site="s{b}"/></spatial>')
    out.append("</tendon>")
    if threads == "actuator":
        out.append("<actuator>")
        for j, l0 in enumerate(net.length):
            bias = _numbers((net.k * l0, -net.k, -net.c))
            out.append(
                f'<general tendon="t{j}" gaintype="fixed" gainprm="0" biastype="affine" biasprm="{bias}" '
                'forcelimited="true" forcerange="-1e9 0"/>'
            )
        out.append("</actuator>")
    return out


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{x:.17g}" for x in values)


def install_callback(net: Net, data: Any) -> object:
    """Install a numba-compiled mjcb_passive with the exact thread law.

    Returns:
        Objects that must outlive the simulation.
    """
    import numba
    from numba.core import types
    from numba.extending import intrinsic

    @intrinsic
    def as_pointer(typingctx: Any, address: Any) -> Any:  # numba takes it for a function of the address alone
        sig = types.CPointer(types.float64)(address)

        def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return builder.inttoptr(args[0], context.get_value_type(signature.return_type))

        return sig, codegen

    pointer: Any = as_pointer  # for the type checker: called without the context that numba adds
    n = data.qpos.size
    q_at, v_at, f_at = (x.ctypes.data for x in (data.qpos, data.qvel, data.qfrc_passive))
    a = net.pairs[:, 0].astype(np.int64) * 3
    b = net.pairs[:, 1].astype(np.int64) * 3
    base = (net.pos0[net.pairs[:, 1]] - net.pos0[net.pairs[:, 0]]).copy()
    l0, k, c, m = net.length.copy(), net.k, net.c, len(net.length)

    @numba.njit(fastmath=True, error_model="numpy")
    def force(q: np.ndarray, v: np.ndarray, f: np.ndarray) -> None:
        for j in range(m):
            i1, i2 = a[j], b[j]
            dx = base[j, 0] + q[i2] - q[i1]
            dy = base[j, 1] + q[i2 + 1] - q[i1 + 1]
            dz = base[j, 2] + q[i2 + 2] - q[i1 + 2]
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            e = length - l0[j]
            if e > 0.0:
                rate = ((v[i2] - v[i1]) * dx + (v[i2 + 1] - v[i1 + 1]) * dy + (v[i2 + 2] - v[i1 + 2]) * dz) / length
                t = k * e + c * rate
                if t > 0.0:
                    t /= length
                    f[i1] += t * dx
                    f[i1 + 1] += t * dy
                    f[i1 + 2] += t * dz
                    f[i2] -= t * dx
                    f[i2 + 1] -= t * dy
                    f[i2 + 2] -= t * dz

    @numba.cfunc(types.void(types.voidptr, types.voidptr))
    def callback(model_ptr: int, data_ptr: int) -> None:
        force(numba.carray(pointer(q_at), n), numba.carray(pointer(v_at), n), numba.carray(pointer(f_at), n))

    mujoco.set_mjcb_passive(callback.ctypes)
    return callback, force


def simulate(
    dt: float, tend: float, debris: Sequence[float] = (0.0, 0.0, -50.0), mus: int = 8, integrator: str = "Euler",
    threads: str = "actuator", solver: str = "CG", iterations: int = 100, tolerance: float = 1e-8,
    give_up_s: float | None = None, young: float = 70e9,
) -> dict[str, Any]:  # fmt: skip
    """Fly the net; return a dict of 20 Hz histories and timings.

    Stops early when the state blows up, or after ``give_up_s`` wall seconds.

    Raises:
        ValueError: when ``dt`` does not divide the control period.
    """
    per = round(CONTROL_PERIOD / dt) if dt > 0.0 else 0  # NaN is not greater either
    if per < 1 or abs(per * dt - CONTROL_PERIOD) > 1e-9 * CONTROL_PERIOD:
        raise ValueError(f"dt = {dt:g} s; allowed: what divides the control period of {CONTROL_PERIOD:g} s")
    net = Net(mus, young)
    t_build = time.perf_counter()
    model = mujoco.MjModel.from_xml_string(mjcf(net, dt, integrator, threads, solver, iterations, tolerance))
    data = mujoco.MjData(model)
    # Warnings are counted below; without a handler MuJoCo writes MUJOCO_LOG.TXT.
    mujoco.set_mju_user_warning(lambda message: None)
    keep = install_callback(net, data) if threads == "callback" else None
    try:
        mujoco.mj_forward(model, data)
        t_build = time.perf_counter() - t_build
        histories, costs = _fly(net, model, data, per, tend, np.asarray(debris, float), mus, give_up_s)
    finally:
        if keep:
            mujoco.set_mjcb_passive(None)
    simulated = histories["t"][-1]
    steps = costs["steps"]
    return dict(
        **histories, **costs, build_s=t_build, dt=dt, mus=mus, debris=debris, integrator=integrator, threads=threads,
        solver_warnings=int(data.warning[mujoco.mjtWarning.mjWARN_INERTIA].number),
        wall_per_sim_s=costs["wall_s"] / simulated, us_per_step=costs["wall_s"] / steps * 1e6,
        cpu_per_sim_s=costs["cpu_s"] / simulated, cpu_us_per_step=costs["cpu_s"] / steps * 1e6,
        peak_rss_mib=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    )  # fmt: skip


def _fly(
    net: Net, model: Any, data: Any, per: int, tend: float, debris: np.ndarray, mus: int, give_up_s: float | None
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Step to the end under the PID: histories, and what the steps cost."""
    # Body i owns degrees of freedom 3i..3i+2 (bodies are numbered in file order).
    knots = slice(0, 3 * net.n_knots)
    mu_dof = slice(3 * net.n_knots, 3 * (net.n_knots + mus))
    weight = net.knot_mass / net.knot_mass.sum()
    knot0, mu0 = net.pos0[: net.n_knots], net.pos0[net.n_knots :]
    goal = np.column_stack([debris[:2] + TARGET_XY[:mus], np.full(mus, debris[2])])
    integral = np.zeros((mus, 3))
    warnings = mujoco.mjtWarning
    fatal = (warnings.mjWARN_BADQPOS, warnings.mjWARN_BADQVEL, warnings.mjWARN_BADQACC)
    rows, wall, cpu, steps, ok = [], 0.0, 0.0, 0, True
    for n in range(round(tend / CONTROL_PERIOD)):
        pos = mu0 + data.qpos[mu_dof].reshape(mus, 3)
        vel = data.qvel[mu_dof].reshape(mus, 3).copy()
        wanted = mu0 + min(n * CONTROL_PERIOD / T_FLIGHT, 1.0) * (goal - mu0)
        error = wanted - pos
        integral += error * CONTROL_PERIOD
        thrust = np.clip(KP * error - KD * vel + KI * integral, -FMAX, FMAX)
        data.qfrc_applied[mu_dof] = thrust.ravel()
        start, start_cpu = time.perf_counter(), time.process_time()
        mujoco.mj_step(model, data, per)
        wall += time.perf_counter() - start
        cpu += time.process_time() - start_cpu
        steps += per
        speed = np.abs(data.qvel).max()
        mu_pos = mu0 + data.qpos[mu_dof].reshape(mus, 3)
        mu_vel = data.qvel[mu_dof].reshape(mus, 3).copy()
        com = weight @ (knot0 + data.qpos[knots].reshape(-1, 3))
        rows.append(((n + 1) * CONTROL_PERIOD, mu_pos, mu_vel, com, thrust, speed))
        if not speed < TOO_FAST or any(data.warning[w].number for w in fatal):
            ok = False
            break
        if give_up_s and wall > give_up_s:
            break
    names = ("t", "mu_pos", "mu_vel", "net_com", "thrust", "max_speed")
    histories = {name: np.array(values) for name, values in zip(names, zip(*rows, strict=True), strict=True)}
    return histories, {"finished": ok, "wall_s": wall, "cpu_s": cpu, "steps": steps}


def main(argv: list[str] | None = None) -> int:
    """Command line; exit status 1 when the state blew up."""
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--dt", type=float, default=1e-4, help="time step, s (divides 0.05)")
    p.add_argument("--tend", type=float, default=25.0, help="simulated time, s")
    p.add_argument("--debris", type=float, nargs=3, default=(0.0, 0.0, -50.0), metavar=("X", "Y", "Z"))
    p.add_argument("--young", type=float, default=70e9, help="thread modulus, Pa")
    p.add_argument("--mus", type=int, choices=[system.unit_count for system in family()], default=8)
    p.add_argument("--out", help="write histories to this .npz file")
    p.add_argument("--integrator", choices=INTEGRATORS, default="Euler")
    p.add_argument("--threads", choices=THREADS, default="actuator")
    p.add_argument("--solver", choices=("CG", "Newton"), default="CG", help="used by --integrator discrete only")
    p.add_argument("--iterations", type=int, default=100)
    p.add_argument("--tolerance", type=float, default=1e-8)
    a = p.parse_args(argv)
    try:
        r = simulate(
            a.dt, a.tend, a.debris, a.mus, a.integrator, a.threads, a.solver, a.iterations, a.tolerance, young=a.young
        )
    except ValueError as error:
        p.error(str(error))
    print(
        f"mujoco {mujoco.__version__}  {a.integrator}/{a.threads}  dt {a.dt:g}  "
        f"{'finished' if r['finished'] else 'UNSTABLE'} at t = {r['t'][-1]:.2f} s"
    )
    print(
        f"{r['wall_per_sim_s']:.3f} wall s per simulated s, {r['us_per_step']:.2f} us per step "
        f"(CPU time: {r['cpu_per_sim_s']:.3f} s, {r['cpu_us_per_step']:.2f} us), "
        f"peak memory {r['peak_rss_mib']:.0f} MiB, build {r['build_s']:.2f} s"
    )
    if r["solver_warnings"]:
        print(f"{r['solver_warnings']} steps with an under-converged effective-metric solve")
    print(f"net CoM {np.round(r['net_com'][-1], 4)}  fastest coordinate {r['max_speed'][-1]:.3f} m/s")
    if a.out:
        np.savez_compressed(a.out, **r)
    return 0 if r["finished"] else 1


if __name__ == "__main__":
    sys.exit(main())
