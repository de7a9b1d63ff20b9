"""What every program of the comparison shares: scenes, motion, truth, clocks, and the lines it prints.

SI units, torques about the ball's centre, angles in radians unless a name says otherwise. Scenes and motion are those of `haptor bench` (tools/haptor/src/bench/cases.rs):
a ball of 20 mm on a cube of 0.1 m, and k balls of 10 mm on a ring of 50 mm on a box or an ellipsoid. Truth: finite elements, tests/truth/B5_twist_cube.json.
"""

import gc
import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[3]
MU = 0.75
E = 3.0e6
RADIUS = 0.02
SIDE = 0.1
BALL, RING = 0.01, 0.05
BOX = (0.2, 0.2, 0.1)
ELLIPSOID = (0.12, 0.1, 0.08)
COUNTS = (1, 2, 5, 10)
DEPTHS = (0.001, 0.003, 0.005)
ROUND = 1024
DT = 1.0e-3
# reach of the motion: depth, its wave, shift, angle
DEEP = (0.003, 5.0e-4, 1.0e-3, 0.5)
SHALLOW = (0.001, 3.0e-4, 5.0e-4, 0.05)
# speed of the twist of the physics, and how long it is held afterwards
SPIN = math.radians(120.0)
HOLD = 0.5
TWIST = math.radians(60.0)
TWIST_TICKS = round(TWIST / SPIN / DT)
# twist while dragging: two radians a second, the drag such that the rim moves as fast as the centre
DRAG_DEPTH, DRAG_SPIN, DRAG_TIME = 0.003, 2.0, 1.0
# calls that are run before any counts
WARM = 20
# fewest calls that count, however slow they are
FEWEST = 30


def pose(tick: int, reach: tuple[float, float, float, float] = DEEP) -> tuple[float, float, float, float]:
    """Shift along x and y, depth and angle of a tick of the timed motion."""
    depth, wave, shift, angle = reach
    t = 2.0 * math.pi * (tick % ROUND) / ROUND
    return shift * math.sin(t), 0.7 * shift * math.cos(2.0 * t), depth + wave * math.sin(3.0 * t), angle * math.sin(t + 0.3)


def velocity(tick: int, reach: tuple[float, float, float, float] = DEEP) -> np.ndarray:
    """Rate of change of `pose`."""
    return (np.array(pose(tick + 1, reach)) - np.array(pose(tick, reach))) / DT


def ring(body: str, count: int) -> list[np.ndarray]:
    """Centres of the balls relative to the middle of the object's top, each ball touching where it stands."""
    centres = []
    for i in range(count):
        x, y = RING * math.cos(2.0 * math.pi * i / count), RING * math.sin(2.0 * math.pi * i / count)
        normal, z = np.array([0.0, 0.0, 1.0]), 0.0
        if body == "ellipsoid":
            a, b, c = ELLIPSOID
            z = c * math.sqrt(1.0 - (x / a) ** 2 - (y / b) ** 2)
            normal = np.array([x / a**2, y / b**2, z / c**2])
            normal /= np.linalg.norm(normal)
            z -= c
        centres.append(np.array([x, y, z]) + BALL * normal)
    return centres


def truth(nu: float, depth: float) -> dict:
    """Finite elements: force, contact radius, torque against twist."""
    rows = json.loads((ROOT / "tests/truth/B5_twist_cube.json").read_text())["rows"]
    row = min(rows, key=lambda row: abs(row["nu"] - nu) * 1.0e3 + abs(row["delta_m"] - depth) * 1.0e6)
    # the table turns back after its largest twist
    outward = row["twist_deg"].index(max(row["twist_deg"])) + 1
    return row | {"twist_deg": row["twist_deg"][:outward], "T_Nm": row["T_Nm"][:outward]}


def drag_path(a: float, seconds: float = DRAG_TIME) -> Iterator[tuple[float, float]]:
    """Shift and angle, tick by tick, of a steady drag with twist; `a` is the contact radius."""
    for tick in range(round(seconds / DT) + 1):
        t = tick * DT
        yield DRAG_SPIN * a * (t - 0.75 * seconds), DRAG_SPIN * t


def sliding_truth() -> tuple[float, float]:
    """Coulomb friction under Hertz pressure when the rim turns as fast as the centre slides: force / (mu F), torque / (full-slip torque)."""
    r, w = np.polynomial.legendre.leggauss(400)
    r, w = (r + 1.0) / 2.0, w / 2.0
    angles = (np.arange(720) + 0.5) * math.pi / 360.0
    x, y = r[:, None] * np.cos(angles), r[:, None] * np.sin(angles)
    speed = np.hypot(1.0 - y, x)
    weight = (w * r * np.sqrt(1.0 - r * r))[:, None] * 1.5 / 720.0 * 2.0
    force = np.sum(weight * (1.0 - y) / speed)
    torque = np.sum(weight * (x * x - y * (1.0 - y)) / speed)
    return float(force), float(torque / (3.0 * math.pi / 16.0))


def measure(peer: str, version: str, scene: str, case: str, call: Callable[[int], object], seconds: float, before: Callable[[int], object] | None = None) -> None:
    """Times `call(tick)` by itself on both clocks for about `seconds`, and prints the line. Reading the clocks is taken off; `before(tick)` is not timed."""
    nothing = lambda tick: None
    own = _spent(nothing, nothing, 0.0, 500)
    before = before or nothing
    for tick in range(WARM):
        before(tick)
        call(tick)
    spent = np.maximum(_spent(call, before, seconds, FEWEST) - np.median(own, axis=0), 0.0)
    line = {"peer": peer, "version": version, "scene": scene, "case": case, "n": len(spent)}
    for column, prefix in ((0, ""), (1, "cpu_")):
        times = np.sort(spent[:, column]) / 1.0e3
        for name, share in (("median", 0.5), ("p99", 0.99), ("max", 1.0)):
            line[f"{prefix}{name}_us"] = round(float(times[max(math.ceil(share * len(times)), 1) - 1]), 3)
    say(line)


def _spent(call: Callable[[int], object], before: Callable[[int], object], seconds: float, least: int) -> np.ndarray:
    """Wall and CPU time of each call [ns]; without the collector of garbage, which is Python's and not the program's."""
    spent, end, tick = [], time.perf_counter() + seconds, WARM
    gc.disable()
    while len(spent) < least or time.perf_counter() < end:
        before(tick)
        cpu, wall = time.thread_time_ns(), time.perf_counter_ns()
        call(tick)
        wall, cpu = time.perf_counter_ns() - wall, time.thread_time_ns() - cpu
        spent.append((wall, cpu))
        tick += 1
    gc.enable()
    return np.array(spent, float)


def physics(peer: str, version: str, case: str, nu: float, depth: float, force: float, curve: list[tuple[float, float]], held: float | None) -> None:
    """Prints what a program finds for the ball at one depth: force, torque at the twists of the truth, share of the torque after the hold."""
    angles, torques = np.array(curve).T if curve else (np.zeros(1), np.zeros(1))
    twists = truth(nu, depth)["twist_deg"]
    found = np.interp(np.radians(twists), angles, torques)
    say({"physics": "press-twist", "peer": peer, "version": version, "case": case, "nu": nu, "depth_mm": 1.0e3 * depth, "force_N": force,
         "twist_deg": twists, "torque_Nm": [float(t) for t in found], "held": held})


def dragged(peer: str, version: str, case: str, nu: float, normal: float, force: float, torque: float) -> None:
    """Prints what a program finds at the end of the drag with twist."""
    say({"physics": "drag-twist", "peer": peer, "version": version, "case": case, "nu": nu, "normal_N": normal, "drag_N": force, "torque_Nm": torque})


def cannot(peer: str, version: str, what: str, reason: str) -> None:
    """Prints what a program cannot do, and how that was seen."""
    say({"cannot": what, "peer": peer, "version": version, "reason": reason})


def say(line: dict) -> None:
    """One line of JSON."""
    print(json.dumps(line), flush=True)


def job() -> tuple[str, float]:
    """`time SECONDS` or `physics`, from the command line; one thread for every library."""
    what = sys.argv[1] if len(sys.argv) > 1 else ""
    if what not in ("time", "physics"):
        sys.exit(f"usage: {os.path.basename(sys.argv[0])} time SECONDS | physics")
    return what, float(sys.argv[2]) if what == "time" else 0.0


def grid_mesh(body: str, triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed mesh of about so many triangles: vertices relative to the middle of the top, corners. Boxes in squares, the ellipsoid's by mapping a cube's."""
    n = max(round(math.sqrt(triangles / 12.0)), 1)
    steps = np.linspace(-1.0, 1.0, n + 1)
    vertices, corners = [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            first = len(vertices)
            for u in steps:
                for v in steps:
                    p = np.empty(3)
                    p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = sign, u, v
                    vertices.append(p)
            for i in range(n):
                for j in range(n):
                    a, b, c, d = (first + i * (n + 1) + j, first + (i + 1) * (n + 1) + j, first + (i + 1) * (n + 1) + j + 1, first + i * (n + 1) + j + 1)
                    corners += [(a, b, c), (a, c, d)] if sign > 0.0 else [(a, c, b), (a, d, c)]
    p = np.array(vertices)
    if body == "ellipsoid":
        p = p / np.linalg.norm(p, axis=1, keepdims=True) * np.array(ELLIPSOID)
        return p - np.array([0.0, 0.0, ELLIPSOID[2]]), np.array(corners)
    size = np.array([SIDE] * 3 if body == "cube" else BOX)
    return p * size / 2.0 - np.array([0.0, 0.0, size[2] / 2.0]), np.array(corners)
