"""MuJoCo: rigid bodies with torsional and rolling friction (condim 4 and 6), and a flex of 6 x 6 x 6 nodes as the elastic cube.

The ball is a free body of 1 kg that a spring and damper (outside of the timed call) pull after the prescribed pose; integral action brings it to the depth asked for. A rigid contact has no
area and no modulus: its stiffness is set so that the force is right at 3 mm, its torsional friction (a length) to the full-slip torque at 3 mm.
"""

import math

import mujoco
import numpy as np

import common
from common import DT, MU, RADIUS, SIDE

PEER, VERSION = "MuJoCo", mujoco.__version__
# of the full slip under Hertz pressure at 3 mm, as a length: torque per normal force [m]
TORSION = MU * 3.0 * math.pi / 16.0 * common.truth(0.5, 0.003)["a_m"]
# of the coupling: as stiff as explicit integration of 1 kg and 1.6e-4 kg m^2 at 1 kHz bears
STIFF, DAMP, STIFF_TURN, DAMP_TURN = 2.0e5, 600.0, 20.0, 0.08
VARIANTS = {"condim 4": (4, ""), "condim 6": (6, ""), "condim 4, impratio 10, noslip 10": (4, 'impratio="10" noslip_iterations="10"')}

HEAD = '<mujoco><option timestep="0.001" gravity="0 0 0" cone="elliptic" {option}/><worldbody>'
TOOL = '<body name="tool" pos="0 0 {z}"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1.6e-4 1.6e-4 1.6e-4"/>{balls}</body></worldbody>{rest}</mujoco>'
GEOM = '<geom type="sphere" size="{radius}" pos="{p}" {contact}/>'


def rigid(body: str, centres: list[np.ndarray], radius: float, condim: int, option: str, stiffness: float) -> mujoco.MjModel:
    """Balls on a rigid box or ellipsoid; z = 0 is its top."""
    contact = f'condim="{condim}" friction="{MU} {TORSION} 0.0001" solref="{-stiffness} -300"'
    size = [SIDE] * 3 if body == "cube" else common.BOX
    kind, half = ("ellipsoid", common.ELLIPSOID) if body == "ellipsoid" else ("box", [s / 2.0 for s in size])
    text = HEAD.format(option=option) + f'<geom type="{kind}" size="{half[0]} {half[1]} {half[2]}" pos="0 0 {-half[2]}" {contact}/>'
    balls = "".join(GEOM.format(radius=radius, p=" ".join(map(str, p)), contact=contact) for p in centres)
    return mujoco.MjModel.from_xml_string(text + TOOL.format(z=0.0, balls=balls, rest=""))


def flex_text() -> str:
    """The cube as 6 x 6 x 6 nodes, its base held."""
    spacing, contact = SIDE / 5.0, f'condim="4" friction="{MU} {TORSION} 0.0001"'
    text = HEAD.format(option='integrator="discrete" impratio="100"')
    text += (f'<flexcomp name="cube" type="grid" dim="3" count="6 6 6" spacing="{spacing} {spacing} {spacing}" pos="0 0 {-SIDE / 2.0}" radius="0.0001" mass="1.1">'
             f'<contact selfcollide="none" {contact} solref="0.002 1"/><edge equality="false"/>'
             f'<elasticity young="{common.E}" poisson="0.45" damping="0.005"/><pin gridrange="0 0 0 5 5 0"/></flexcomp>')
    ball = GEOM.format(radius=RADIUS, p=f"0 0 {RADIUS}", contact=contact + ' solref="0.002 1"')
    return text + TOOL.format(z=0.002, balls=ball, rest="")


def flex() -> mujoco.MjModel:
    """The elastic cube and the ball."""
    return mujoco.MjModel.from_xml_string(flex_text())


class Hand:
    """Pulls the tool after a pose, steps, and reads the contact."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        self.tool = model.body("tool").id
        joint = model.body_jntadr[self.tool]
        self.q, self.v = model.jnt_qposadr[joint], model.jnt_dofadr[joint]
        self.lift = 0.0

    def pull(self, x: float, y: float, depth: float, angle: float) -> None:
        """The coupling's wrench for the next step."""
        d, q, v = self.data, self.q, self.v
        frame, lag = d.xmat[self.tool].reshape(3, 3), np.zeros(3)
        mujoco.mju_subQuat(lag, np.array([math.cos(angle / 2.0), 0.0, 0.0, math.sin(angle / 2.0)]), d.qpos[q + 3 : q + 7])
        error = np.array([x, y, self.lift - depth]) - d.qpos[q : q + 3]
        wrench = d.xfrc_applied[self.tool]
        wrench[:3] = STIFF * error - DAMP * d.qvel[v : v + 3]
        # the turn that is missing and the spin are in the tool's own axes
        wrench[3:] = frame @ (STIFF_TURN * lag - DAMP_TURN * d.qvel[v + 3 : v + 6])

    def step(self) -> None:
        """What is timed: one step."""
        mujoco.mj_step(self.model, self.data)

    @property
    def angle(self) -> float:
        """Turn of the tool about z."""
        return 2.0 * math.atan2(self.data.qpos[self.q + 6], self.data.qpos[self.q + 3])

    @property
    def depth(self) -> float:
        """How deep the tool is."""
        return -self.data.qpos[self.q + 2]

    def felt(self) -> np.ndarray:
        """Force of all contacts on the tool, and their torque about its origin: as large as what the object gets, whichever is first of the pair."""
        total, f = np.zeros(6), np.zeros(6)
        for i, contact in enumerate(self.data.contact):
            mujoco.mj_contactForce(self.model, self.data, i, f)
            frame = contact.frame.reshape(3, 3)
            force, torque = frame.T @ f[:3], frame.T @ f[3:]
            sign = 1.0 if force[2] > 0.0 else -1.0
            at = contact.pos - self.data.qpos[self.q : self.q + 3]
            total += sign * np.concatenate([force, torque + np.cross(at, force)])
        return total

    def press(self, depth: float, ticks: int = 400) -> None:
        """Goes down to a depth and stays there."""
        for tick in range(ticks):
            wanted = depth * min(1.0, 2.0 * tick / ticks)
            self.pull(0.0, 0.0, wanted, 0.0)
            self.step()
            if self.data.ncon:
                self.lift += 0.05 * (self.depth - wanted)


def judge(case: str, model: mujoco.MjModel, nu: float) -> None:
    """Force and torque of the ball at all depths, and dragged."""
    for depth in common.DEPTHS:
        hand, curve = Hand(model), [(0.0, 0.0)]
        hand.press(depth)
        force = float(hand.felt()[2])
        for tick in range(common.TWIST_TICKS + 1):
            hand.pull(0.0, 0.0, depth, common.SPIN * tick * DT)
            hand.step()
            curve.append((hand.angle, abs(float(hand.felt()[5]))))
        for _ in range(round(common.HOLD / DT)):
            hand.pull(0.0, 0.0, depth, common.TWIST)
            hand.step()
        held = abs(float(hand.felt()[5])) / max(curve[-1][1], 1.0e-12)
        common.physics(PEER, VERSION, case, nu, depth, force, sorted(curve), held)
    hand = Hand(model)
    hand.press(common.DRAG_DEPTH)
    a, tail = common.truth(nu, common.DRAG_DEPTH)["a_m"], []
    start = next(iter(common.drag_path(a)))[0]
    for x, angle in common.drag_path(a):
        hand.pull(x - start, 0.0, common.DRAG_DEPTH, angle)
        hand.step()
        tail.append(hand.felt())
    mean = np.mean(tail[-200:], axis=0)
    common.dragged(PEER, VERSION, case, nu, float(mean[2]), abs(float(mean[0])), abs(float(mean[5])))


def calibrated(condim: int, option: str) -> float:
    """Stiffness of the contact with which the force at 3 mm is the truth's."""
    stiffness, wanted = 3.0e4, common.truth(0.5, 0.003)["F_N"]
    for _ in range(3):
        hand = Hand(rigid("cube", BALL, RADIUS, condim, option, stiffness))
        hand.press(0.003)
        stiffness *= wanted / float(hand.felt()[2])
    return stiffness


BALL = [np.array([0.0, 0.0, RADIUS])]


def clock(scene: str, case: str, model: mujoco.MjModel, reach: tuple, seconds: float) -> None:
    """Times mj_step alone; the coupling's wrench is set between two calls."""
    hand = Hand(model)
    hand.press(reach[0])
    common.measure(PEER, VERSION, scene, case, lambda tick: hand.step(), seconds, before=lambda tick: hand.pull(*common.pose(tick, reach)))


def main() -> None:
    what, seconds = common.job()
    stiffness = {name: calibrated(*variant) for name, variant in VARIANTS.items()}
    if what == "physics":
        for name, variant in VARIANTS.items():
            judge(f"rigid, {name}", rigid("cube", BALL, RADIUS, *variant, stiffness[name]), 0.5)
        judge("flex 6 x 6 x 6", flex(), 0.45)
        tell_limits(stiffness["condim 4"])
        return
    for name, variant in VARIANTS.items():
        clock("ball-on-cube", f"rigid, {name}", rigid("cube", BALL, RADIUS, *variant, stiffness[name]), common.DEEP, seconds)
    clock("ball-on-cube", "flex 6 x 6 x 6", flex(), common.DEEP, seconds)
    for body in ("box", "ellipsoid"):
        for k in common.COUNTS:
            clock(f"{body}-k{k}", "rigid, condim 4", rigid(body, common.ring(body, k), common.BALL, 4, "", stiffness["condim 4"]), common.SHALLOW, seconds)


def tell_limits(stiffness: float) -> None:
    """What it cannot do; what it refuses is asked for, and its own words are the reason."""
    for what, option in (("flex with an implicit integrator", 'integrator="implicitfast"'), ("flex with the noslip pass", 'integrator="discrete" noslip_iterations="10"')):
        common.cannot(PEER, VERSION, what, refusal(option))
    common.cannot(PEER, VERSION, "force from Young's modulus (rigid)", "the contact is a solver parameter, linear in the depth; fitted to the truth at 3 mm")
    common.cannot(PEER, VERSION, "twist without changing the normal force (rigid)", risen(stiffness))
    common.cannot(PEER, VERSION, "contact area, pressure, deformation (rigid)", "a contact is a point; torsional friction is a constant length, right at one depth")


def risen(stiffness: float) -> str:
    """What a twist does to the force at 1 mm, the handle's height unchanged."""
    hand = Hand(rigid("cube", BALL, RADIUS, *VARIANTS["condim 4"], stiffness))
    hand.press(0.001)
    before = float(hand.felt()[2])
    for tick in range(100):
        hand.pull(0.0, 0.0, 0.001, common.SPIN * tick * DT)
        hand.step()
    return f"at 1 mm the force goes from {before:.1f} to {float(hand.felt()[2]):.1f} N when the ball begins to turn, and the torque's limit with it"


def refusal(option: str) -> str:
    """What is said when the flex is compiled and stepped with these options."""
    xml = flex_text().replace('integrator="discrete"', option)
    try:
        model = mujoco.MjModel.from_xml_string(xml)
        hand = Hand(model)
        hand.press(0.001, 50)
        return "accepted" if np.isfinite(hand.data.qpos).all() else "diverges"
    except (ValueError, mujoco.FatalError) as error:
        return " ".join(str(error).split())


if __name__ == "__main__":
    main()
