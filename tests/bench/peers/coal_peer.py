"""coal (the successor of hpp-fcl): detection only. Balls against a mesh of the object, all contacts up to 200."""

import math

import coal
import numpy as np

import common

PEER, VERSION = "coal", coal.__version__
# as many contacts as are asked for at most
CONTACTS = 200


def mesh(body: str, triangles: int) -> coal.BVHModelOBBRSS:
    """A mesh of the object with its tree of boxes."""
    vertices, corners = common.grid_mesh(body, triangles)
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(corners), len(vertices))
    model.addVertices(vertices)
    model.addTriangles(corners)
    model.endModel()
    return model


def placed(x: float, y: float, z: float) -> coal.Transform3s:
    """A place without a turn: balls look the same from all sides."""
    transform = coal.Transform3s()
    transform.setTranslation(np.array([x, y, z]))
    return transform


def run(scene: str, case: str, body: str, triangles: int, centres: list[np.ndarray], radius: float, reach: tuple, seconds: float) -> None:
    """Times the search for all contacts of all balls along the motion."""
    model, ball, home = mesh(body, triangles), coal.Sphere(radius), coal.Transform3s()
    request = coal.CollisionRequest(coal.CONTACT, CONTACTS)
    result = coal.CollisionResult()

    def find(tick: int) -> int:
        x, y, depth, angle = common.pose(tick, reach)
        c, s, found = math.cos(angle), math.sin(angle), 0
        for p in centres:
            result.clear()
            found += coal.collide(model, home, ball, placed(x + c * p[0] - s * p[1], y + s * p[0] + c * p[1], p[2] - depth), request, result)
        return found

    assert find(0) > 0, "the balls touch"
    common.measure(PEER, VERSION, scene, case, find, seconds)


def main() -> None:
    what, seconds = common.job()
    if what == "physics":
        common.cannot(PEER, VERSION, "force, torque, friction, deformation", "a library of collision detection: contacts, depths and normals, no physics")
        return
    for count in (1_000, 10_000):
        run("ball-on-cube", f"detection, {count // 1000}k triangles", "cube", count, [np.array([0.0, 0.0, common.RADIUS])], common.RADIUS, common.DEEP, seconds)
    for body in ("box", "ellipsoid"):
        for k in common.COUNTS:
            run(f"{body}-k{k}", "detection, 10k triangles", body, 10_000, common.ring(body, k), common.BALL, common.SHALLOW, seconds)


if __name__ == "__main__":
    main()
