"""haptor itself, through its own tool: `haptor bench --json` for the times, `haptor eval` on the shipped scene of the cube for force and torque."""

import csv
import math
import os
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path

import common
from common import DT

TOOL = os.environ["HAPTOR"]
PEER = "haptor"
VERSION = subprocess.run([TOOL, "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]
NU = 0.5
SETTINGS = (("point", "point", 64), ("paper 64", "paper", 64), ("bristle 16", "bristle", 16), ("bristle 64", "bristle", 64), ("bristle 256", "bristle", 256), ("influence 52", "influence", 52),
            ("influence 112", "influence", 112))


def felt(tier: str, samples: int, path: Iterable[tuple[float, float, float]]) -> list[list[float]]:
    """Force and torque on the ball at each tick of a path of shifts, depths and angles."""
    with tempfile.TemporaryDirectory() as folder:
        poses = Path(folder) / "poses.csv"
        with poses.open("w") as file:
            file.write("t,px,py,pz,qw,qx,qy,qz\n")
            for tick, (x, depth, angle) in enumerate(path):
                z = common.SIDE + common.RADIUS - depth
                file.write(f"{tick * DT:.6f},{x:.9g},0,{z:.9g},{math.cos(angle / 2.0):.9g},0,0,{math.sin(angle / 2.0):.9g}\n")
        scene = common.ROOT / "tests/scenes/cube-twist.toml"
        command = [TOOL, "eval", str(scene), str(poses), "--tier", tier, "--samples", str(samples)]
        table = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [[float(row[name]) for name in ("fx", "fy", "fz", "tx", "ty", "tz")] for row in csv.DictReader(table.splitlines())]


def judge(case: str, tier: str, samples: int) -> None:
    """Force and torque of the ball at all depths, and dragged."""
    for depth in common.DEPTHS:
        press = [(0.0, depth * tick / 200.0, 0.0) for tick in range(201)]
        twist = [(0.0, depth, common.SPIN * tick * DT) for tick in range(common.TWIST_TICKS + 1)]
        hold = [(0.0, depth, common.TWIST)] * round(common.HOLD / DT)
        rows = felt(tier, samples, press + twist + hold)
        curve = [(common.SPIN * tick * DT, -rows[len(press) + tick][5]) for tick in range(common.TWIST_TICKS + 1)]
        held = rows[-1][5] / rows[len(press) + len(twist) - 1][5]
        common.physics(PEER, VERSION, case, NU, depth, rows[-1][2], curve, held)
    path = list(common.drag_path(common.truth(NU, common.DRAG_DEPTH)["a_m"]))
    press = [(path[0][0], common.DRAG_DEPTH * tick / 200.0, 0.0) for tick in range(201)]
    last = felt(tier, samples, press + [(x, common.DRAG_DEPTH, angle) for x, angle in path])[-1]
    common.dragged(PEER, VERSION, case, NU, last[2], -last[0], -last[5])


def main() -> None:
    what, seconds = common.job()
    if what == "time":
        subprocess.run([TOOL, "bench", "--json", "--seconds", str(seconds)], check=True)
        return
    for setting in SETTINGS:
        judge(*setting)
    common.cannot(PEER, VERSION, "finite strain", "linear elasticity: ticks whose contact is wide against the radius carry a flag; neo-Hookean rubber twists 8 % softer at 60 degrees stuck, and pushes back")
    common.cannot(PEER, VERSION, "two elastic bodies, objects that move or swing", "the probe is rigid, the object's base is held, and its own inertia is left out")
    common.cannot(PEER, VERSION, "a surface field from a solve", "the deformed surface is made of closed forms and a beam skeleton, tier green of a table: errors in tests/bench/ACCURACY.md")
    common.cannot(PEER, VERSION, "objects with deep hollows", "a mesh with hollows beyond 5 % of its diagonal is refused")
    common.cannot(PEER, VERSION, "torque in tier paper", "the source's equations as printed: see its row above")


if __name__ == "__main__":
    main()
