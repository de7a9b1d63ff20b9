"""The strongest baseline that needs no package: finite elements of the cube, factored once, condensed to the patch under the ball, and projected Gauss-Seidel on it.

Hexahedra on a graded grid, mean dilatation (nu = 0.45 does not lock), base held. Offline: one sparse factorisation, one solve per direction of a patch node; what stays is the
patch's compliance, dense. Online, each tick: contact and Coulomb friction node by node, a fixed number of sweeps, warm start, friction remembered by the surface's displacement.
The tick is compiled (numba).
"""

import math

import numba
import numpy as np
import scipy
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

import common
from common import DT, E, MU, RADIUS, SIDE

PEER = "condensed FE + Coulomb sweeps"
VERSION = f"scipy {scipy.__version__}, numba {numba.__version__}"
NU = 0.45
SWEEPS = 4
# half width of the finely meshed square under the ball [m]
FINE = 0.0135
# edges of the finest elements [m], elements outwards, elements down
GRIDS = {"coarse": (0.0045, 3, 6), "fine": (0.00225, 5, 10)}


def lines(fine: float, outwards: int, down: int) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of the grid: across, the same for both, and heights; from the fine square they grow geometrically."""
    inner = np.linspace(-FINE, FINE, round(2.0 * FINE / fine) + 1)
    outer = FINE + (SIDE / 2.0 - FINE) * graded(fine / (SIDE / 2.0 - FINE), outwards)
    heights = SIDE * (1.0 - graded(fine / SIDE, down))[::-1]
    return np.concatenate([-outer[::-1], inner, outer]), np.append(heights, SIDE)


def graded(first: float, count: int) -> np.ndarray:
    """Places in (0, 1] of `count` steps, the first of them `first`, each longer than the one before by one factor."""
    low, high = 1.0, 10.0
    for _ in range(60):
        ratio = 0.5 * (low + high)
        low, high = (ratio, high) if first * sum(ratio**k for k in range(count)) < 1.0 else (low, ratio)
    steps = np.cumsum([first * low**k for k in range(count)])
    return steps / steps[-1]


def element(edges: np.ndarray) -> np.ndarray:
    """Stiffness of bricks with these edges [count, 3]: shear part with 2 x 2 x 2 points, volume part with the mean dilatation."""
    shear, bulk = E / (2.0 * (1.0 + NU)), E / (3.0 * (1.0 - 2.0 * NU))
    signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
    volume = np.prod(edges, axis=1)
    stiffness, mean = np.zeros((len(edges), 24, 24)), np.zeros((len(edges), 24))
    points = [np.array([x, y, z]) / math.sqrt(3.0) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    for p in points:
        slopes = np.stack([signs[:, k] * np.prod([1.0 + signs[:, m] * p[m] for m in range(3) if m != k], axis=0) / 8.0 for k in range(3)])
        gradient = slopes[None] * 2.0 / edges[:, :, None]
        b = np.zeros((len(edges), 6, 24))
        for k in range(3):
            b[:, k, k::3] = gradient[:, k]
            i, j = (k + 1) % 3, (k + 2) % 3
            b[:, 3 + k, i::3], b[:, 3 + k, j::3] = gradient[:, j], gradient[:, i]
        dilatation = b[:, :3].sum(axis=1)
        b[:, :3] -= dilatation[:, None] / 3.0
        moduli = shear * np.array([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
        stiffness += np.einsum("eki,k,ekj->eij", b, moduli, b) * (volume / 8.0)[:, None, None]
        mean += dilatation / 8.0
    return stiffness + bulk * volume[:, None, None] * mean[:, :, None] * mean[:, None, :]


class Condensed:
    """The patch under the ball: places of its nodes and their compliance."""

    def __init__(self, grid: str) -> None:
        across, heights = lines(*GRIDS[grid])
        n, m = len(across), len(heights)
        self.nodes = n * n * m
        number = np.arange(self.nodes).reshape(m, n, n)
        corner = [number[k : m - 1 + k, j : n - 1 + j, i : n - 1 + i].ravel() for k in (0, 1) for j in (0, 1) for i in (0, 1)]
        dofs = (3 * np.stack(corner, axis=1)[:, :, None] + np.arange(3)).reshape(-1, 24)
        steps = np.diff(across), np.diff(heights)
        z, y, x = np.meshgrid(steps[1], steps[0], steps[0], indexing="ij")
        blocks = element(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1))
        rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, 24).ravel()
        stiffness = coo_matrix((blocks.ravel(), (rows, columns))).tocsc()
        held = 3 * n * n
        self.factor = splu(stiffness[held:, held:], permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        near = np.abs(across) < FINE + 1.0e-9
        top = number[-1][np.ix_(near, near)].ravel()
        gy, gx = np.meshgrid(across[near], across[near], indexing="ij")
        self.place = np.stack([gx.ravel(), gy.ravel()], axis=1)
        patch = (3 * top[:, None] + np.arange(3)).ravel() - held
        load = np.zeros((self.nodes * 3 - held, len(patch)))
        load[patch, np.arange(len(patch))] = 1.0
        self.compliance = np.ascontiguousarray(self.factor.solve(load)[patch])
        self.patch = patch


@numba.njit(cache=True)
def displace(compliance, u, near, i, d0, d1, d2):
    """Moves the nodes `near` by a change of the force on node i."""
    a = 3 * i
    for j in near:
        for row in range(3 * j, 3 * j + 3):
            u[row] += compliance[row, a] * d0 + compliance[row, a + 1] * d1 + compliance[row, a + 2] * d2


@numba.njit(cache=True)
def sweep(compliance, goal, f, u, near):
    """One sweep of Coulomb contact over the nodes `near`: goal is where the ball wants them; f and u are updated. A force pulls nowhere and drags within the cone."""
    for i in near:
        a = 3 * i
        n = min(f[a + 2] + (goal[i, 2] - u[a + 2]) / compliance[a + 2, a + 2], 0.0)
        t0, t1 = f[a] + (goal[i, 0] - u[a]) / compliance[a, a], f[a + 1] + (goal[i, 1] - u[a + 1]) / compliance[a + 1, a + 1]
        size, limit = math.sqrt(t0 * t0 + t1 * t1), -MU * n
        if size > limit:
            share = limit / size if size > 0.0 else 0.0
            t0, t1 = t0 * share, t1 * share
        d0, d1, d2 = t0 - f[a], t1 - f[a + 1], n - f[a + 2]
        f[a], f[a + 1], f[a + 2] = t0, t1, n
        if d0 != 0.0 or d1 != 0.0 or d2 != 0.0:
            displace(compliance, u, near, i, d0, d1, d2)


@numba.njit(cache=True)
def contact(compliance, place, f, u, known, goal, before, now):
    """One tick: from the ball's shift, depth and angle before to those now."""
    near = np.empty(len(place), np.int64)
    count, turn = 0, now[3] - before[3]
    c, s = math.cos(turn) - 1.0, math.sin(turn)
    for i in range(len(place)):
        x, y = place[i, 0] - now[0], place[i, 1] - now[1]
        r2 = x * x + y * y
        gap = RADIUS - now[2] - math.sqrt(RADIUS * RADIUS - r2) if r2 < RADIUS * RADIUS else RADIUS
        if gap >= 0.0 and f[3 * i + 2] == 0.0:
            known[i] = False
            continue
        if not known[i]:
            # the sweeps have not followed it so far
            for row in range(3 * i, 3 * i + 3):
                u[row] = np.dot(compliance[row], f)
            known[i] = True
        x, y = place[i, 0] - before[0], place[i, 1] - before[1]
        goal[i, 0] = u[3 * i] + c * x - s * y + now[0] - before[0]
        goal[i, 1] = u[3 * i + 1] + s * x + c * y + now[1] - before[1]
        goal[i, 2] = gap
        near[count] = i
        count += 1
    for _ in range(SWEEPS):
        sweep(compliance, goal, f, u, near[:count])


class Ball:
    """The ball on the patch, tick by tick."""

    def __init__(self, body: Condensed) -> None:
        self.body = body
        count = len(body.place)
        self.f, self.u, self.goal = np.zeros(3 * count), np.zeros(3 * count), np.zeros((count, 3))
        self.known = np.zeros(count, bool)
        self.before: tuple[float, float, float, float] | None = None

    def tick(self, x: float, y: float, depth: float, angle: float) -> None:
        """One tick: the ball at a shift, depth and angle."""
        now = (x, y, depth, angle)
        contact(self.body.compliance, self.body.place, self.f, self.u, self.known, self.goal, self.before or now, now)
        self.before = now

    def felt(self) -> tuple[float, float, float]:
        """Normal force, drag force and torque about the ball's axis, as the object holds them."""
        f = self.f.reshape(-1, 3)
        off = self.body.place - self.before[:2]
        return -float(f[:, 2].sum()), float(f[:, 0].sum()), float((off[:, 0] * f[:, 1] - off[:, 1] * f[:, 0]).sum())


def press_twist(body: Condensed, depth: float) -> tuple[float, list[tuple[float, float]], float]:
    """Force, torque against twist, share of the torque after the hold."""
    ball, curve = Ball(body), []
    for tick in range(201):
        ball.tick(0.0, 0.0, depth * tick / 200.0, 0.0)
    for tick in range(common.TWIST_TICKS + 1):
        angle = common.SPIN * tick * DT
        ball.tick(0.0, 0.0, depth, angle)
        curve.append((angle, ball.felt()[2]))
    for _ in range(round(common.HOLD / DT)):
        ball.tick(0.0, 0.0, depth, common.TWIST)
    return ball.felt()[0], curve, ball.felt()[2] / curve[-1][1]


def main() -> None:
    what, seconds = common.job()
    for grid in GRIDS:
        body = Condensed(grid)
        case = f"{body.nodes} nodes, {len(body.place)} in the patch"
        if what == "time":
            ball = Ball(body)
            common.measure(PEER, VERSION, "ball-on-cube", case, lambda tick: ball.tick(*common.pose(tick)), seconds)
            load = np.zeros(body.factor.shape[0])

            def whole(tick: int) -> None:
                ball.tick(*common.pose(tick))
                load[body.patch] = ball.f
                body.factor.solve(load)

            common.measure(PEER, VERSION, "ball-on-cube", f"{case}, whole shape", whole, seconds)
            continue
        for depth in common.DEPTHS:
            common.physics(PEER, VERSION, case, NU, depth, *press_twist(body, depth))
        ball, path = Ball(body), common.drag_path(common.truth(NU, common.DRAG_DEPTH)["a_m"])
        for x, angle in path:
            ball.tick(x, 0.0, common.DRAG_DEPTH, angle)
        common.dragged(PEER, VERSION, case, NU, *ball.felt())
    if what == "physics":
        common.cannot(PEER, VERSION, "nu = 0.5", "the bulk modulus divides by 1 - 2 nu; 0.45 is used, against the truth for 0.45")
        common.cannot(PEER, VERSION, "contact anywhere on the body", "the patch is chosen before the run: this one is a square of 27 mm in the middle of the top")
        common.cannot(PEER, VERSION, "the whole shape within a tick", "needs a solve with the whole factor, timed as `whole shape`")
        common.cannot(PEER, VERSION, "several regions", "one patch is condensed here; k patches need their mutual compliance too, at the square of the cost")


if __name__ == "__main__":
    main()
