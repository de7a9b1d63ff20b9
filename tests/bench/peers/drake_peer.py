"""Drake, hydroelastic contact: a rigid ball on a compliant box or ellipsoid, contact surface and wrench of a prescribed pose and velocity.

The pressure field is Drake's own, its modulus set to Young's modulus, friction 0.75, dissipation its default. Depth, twist and drag are prescribed, so that nothing but the
contact is timed and judged.
"""

import importlib.metadata
import math

import numpy as np
from pydrake.all import (
    AddCompliantHydroelasticProperties, AddContactMaterial, AddMultibodyPlant, AddRigidHydroelasticProperties, Box, CoulombFriction, DiagramBuilder, Ellipsoid,
    MultibodyPlantConfig, ProximityProperties, RigidTransform, Sphere, SpatialInertia,
)

import common

PEER = "Drake hydroelastic"
VERSION = importlib.metadata.version("drake")
POLYGONS, TRIANGLES = "polygon", "triangle"


class Rig:
    """A ball or several on the object, posed by hand. The origin is the middle of the object's top."""

    def __init__(self, body: str, hint: float, centres: list[np.ndarray], radius: float, kind: str = POLYGONS) -> None:
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(time_step=0.0, contact_model="hydroelastic", contact_surface_representation=kind)
        self.plant, _ = AddMultibodyPlant(config, builder)
        size = [common.SIDE] * 3 if body == "cube" else common.BOX
        shape, height = (Ellipsoid(*common.ELLIPSOID), 2.0 * common.ELLIPSOID[2]) if body == "ellipsoid" else (Box(*size), size[2])
        soft = ProximityProperties()
        AddCompliantHydroelasticProperties(hint, common.E, soft)
        AddContactMaterial(friction=CoulombFriction(common.MU, common.MU), properties=soft)
        self.plant.RegisterCollisionGeometry(self.plant.world_body(), RigidTransform([0.0, 0.0, -height / 2.0]), shape, "object", soft)
        self.tool = self.plant.AddRigidBody("tool", SpatialInertia.SolidSphereWithMass(1.0, 0.02))
        for i, centre in enumerate(centres):
            hard = ProximityProperties()
            AddRigidHydroelasticProperties(min(hint, radius / 4.0), hard)
            AddContactMaterial(friction=CoulombFriction(common.MU, common.MU), properties=hard)
            self.plant.RegisterCollisionGeometry(self.tool, RigidTransform(centre), Sphere(radius), f"ball{i}", hard)
        self.plant.Finalize()
        self.diagram = builder.Build()
        self.context = self.diagram.CreateDefaultContext()
        self.own = self.plant.GetMyMutableContextFromRoot(self.context)
        self.results = self.plant.get_contact_results_output_port()

    def tick(self, place: tuple[float, float, float, float], speed: np.ndarray) -> np.ndarray:
        """Torque and force on the tool about its origin, and nothing else, at shift, depth and angle and their rates."""
        x, y, depth, angle = place
        q = np.array([math.cos(angle / 2.0), 0.0, 0.0, math.sin(angle / 2.0), x, y, -depth])
        v = np.array([0.0, 0.0, speed[3], speed[0], speed[1], -speed[2]])
        self.plant.SetPositionsAndVelocities(self.own, np.concatenate([q, v]))
        results = self.results.Eval(self.own)
        wrench, origin = np.zeros(6), q[4:]
        for i in range(results.num_hydroelastic_contacts()):
            info = results.hydroelastic_contact_info(i)
            at, spatial = info.contact_surface().centroid(), info.F_Ac_W()
            # geometry A is that of the lower number: the object
            wrench[:3] -= spatial.rotational() + np.cross(at - origin, spatial.translational())
            wrench[3:] -= spatial.translational()
        return wrench


BALL = [np.array([0.0, 0.0, common.RADIUS])]
STILL = np.zeros(4)


def judge(hint: float) -> None:
    """Force and torque of the ball, at rest and turning."""
    rig, case = Rig("cube", hint, BALL, common.RADIUS), f"hint {1e3 * hint:g} mm, polygons"
    turning = np.array([0.0, 0.0, 0.0, common.SPIN])
    for depth in common.DEPTHS:
        force = rig.tick((0.0, 0.0, depth, 0.0), STILL)[5]
        curve = []
        for tick in range(0, common.TWIST_TICKS + 1, 20):
            angle = common.SPIN * tick * common.DT
            curve.append((angle, abs(rig.tick((0.0, 0.0, depth, angle), turning)[2])))
        held = abs(rig.tick((0.0, 0.0, depth, common.TWIST), STILL)[2]) / curve[-1][1]
        common.physics(PEER, VERSION, case, 0.5, depth, force, curve, held)
    a = common.truth(0.5, common.DRAG_DEPTH)["a_m"]
    wrench = rig.tick((0.0, 0.0, common.DRAG_DEPTH, 0.0), np.array([common.DRAG_SPIN * a, 0.0, 0.0, common.DRAG_SPIN]))
    common.dragged(PEER, VERSION, case, 0.5, wrench[5], abs(wrench[3]), abs(wrench[2]))


def clock(scene: str, case: str, rig: Rig, reach: tuple, seconds: float) -> None:
    """Times surface and wrench along the motion."""
    common.measure(PEER, VERSION, scene, case, lambda tick: rig.tick(common.pose(tick, reach), common.velocity(tick, reach)), seconds)


def main() -> None:
    what, seconds = common.job()
    if what == "physics":
        for hint in (0.01, 0.0025, 0.001):
            judge(hint)
        common.cannot(PEER, VERSION, "a twist that is held", "friction is a function of the slip velocity: at rest the torque is 0 at every angle")
        common.cannot(PEER, VERSION, "tangential compliance, stick", "the torque has its value from the first instant of the motion: no angle enters")
        common.cannot(PEER, VERSION, "the deformed surface", "the contact surface is where two pressure fields of undeformed bodies meet")
        common.cannot(PEER, VERSION, "Hertz's force with modulus = E", "force grows with about the square of the depth; a fitted modulus is right at one depth")
        return
    for hint, kind in ((0.01, POLYGONS), (0.005, POLYGONS), (0.0025, POLYGONS), (0.001, POLYGONS), (0.0025, TRIANGLES)):
        clock("ball-on-cube", f"hint {1e3 * hint:g} mm, {kind}s", Rig("cube", hint, BALL, common.RADIUS, kind), common.DEEP, seconds)
    for body in ("box", "ellipsoid"):
        for k in common.COUNTS:
            clock(f"{body}-k{k}", "hint 5 mm, polygons", Rig(body, 0.005, common.ring(body, k), common.BALL), common.SHALLOW, seconds)


if __name__ == "__main__":
    main()
