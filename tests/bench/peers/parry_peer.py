"""parry, the contact search of Rust's game and robot engines: detection only. Writes the scenes for the program `parry-peer` (parry.rs) and passes on what it prints."""

import json
import math
import os
import re
import subprocess

import numpy as np

import common

PEER = "parry3d-f64"
VERSION = re.search(r'name = "parry3d-f64"\nversion = "([^"]*)"', (common.ROOT / "Cargo.lock").read_text())[1]


def scene(name: str, body: str, triangles: int, centres: list[np.ndarray], radius: float, reach: tuple, seconds: float) -> str:
    """One scene as a line of JSON."""
    vertices, corners = common.grid_mesh(body, triangles)
    places = []
    for tick in range(common.ROUND):
        x, y, depth, angle = common.pose(tick, reach)
        c, s = math.cos(angle), math.sin(angle)
        places.append([[x + c * p[0] - s * p[1], y + s * p[0] + c * p[1], p[2] - depth] for p in centres])
    return json.dumps({"peer": PEER, "version": VERSION, "scene": name, "case": f"detection, {triangles // 1000}k triangles", "seconds": seconds, "radius": radius,
                       "vertices": vertices.tolist(), "triangles": corners.tolist(), "places": places})


def main() -> None:
    what, seconds = common.job()
    if what == "physics":
        common.cannot(PEER, VERSION, "force, torque, friction, deformation", "a library of collision detection: contacts, depths and normals, no physics")
        return
    ball = [np.array([0.0, 0.0, common.RADIUS])]
    scenes = [scene("ball-on-cube", "cube", count, ball, common.RADIUS, common.DEEP, seconds) for count in (1_000, 10_000)]
    scenes += [scene(f"{body}-k{k}", body, 10_000, common.ring(body, k), common.BALL, common.SHALLOW, seconds) for body in ("box", "ellipsoid") for k in common.COUNTS]
    subprocess.run([os.environ["PARRY_PEER"]], input="\n".join(scenes), text=True, check=True)


if __name__ == "__main__":
    main()
