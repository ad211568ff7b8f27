"""Where the passes lie, roughly: rigid curves placed by the survey, and which of them fit.

Each pass comes with one or more candidate curves.  For one candidate a pass the
survey's equations are linear in the start points once the heading is known,
and the heading has a closed form; combinations are compared by the sum of the
readings' costs and the survey's misfit.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from georibbon.arrays import FloatArray, IntArray
from georibbon.fitting.strip import linear_cost
from georibbon.geometry.frames import interpolated
from georibbon.rotations import about_z

# Beside the observation's own sigma: how far a single pass's curve drifts (about 4 mm in 1 m).
DRIFT_SIGMA = 0.005
MOST_COMBINATIONS = 256
# Shapes whose costs differ by less than this are not told apart (twice the log of about 150).
AMBIGUOUS_WITHIN = 10.0
_ROUNDS = 4
_LINK_LIMIT = 3.0
_RIDGE = 1e-2  # 1/m²: it settles only what nothing else does


@dataclass(frozen=True, eq=False)
class Curves:
    """Candidate curves of p passes in magnetic axes.

    nodes: (n + 1,).  owner: (k,) the pass of each candidate.  cost: (k,).
    points: (k, n + 1, 3) from the origin.  frames: (k, n + 1, 3, 3).
    """

    nodes: FloatArray
    owner: IntArray
    cost: FloatArray
    points: FloatArray
    frames: FloatArray

    def point(self, candidate: int, s: float) -> FloatArray:
        """(3,) the point at s."""
        return self._interpolate(self.points[candidate], s)

    def left(self, candidate: int, s: float, first: int) -> FloatArray:
        """(3,) the conormal at s, turned round where the curve runs against the first one."""
        along = np.sum(self.frames[candidate, :, :, 0] * self.frames[first, :, :, 0])
        v = self._interpolate(self.frames[candidate, :, :, 1], s)
        return np.asarray(np.copysign(1.0, along) * v / np.linalg.norm(v))

    def _interpolate(self, values: FloatArray, s: float) -> FloatArray:
        return np.asarray(interpolated(np.array([s]), self.nodes, values)[0])


@dataclass(frozen=True)
class Link:
    """X_j(t) - X_i(s) = target, roughly; j None: X_i(s) = target, a place in the workpiece.

    target: a vector in the workpiece frame; or, with `side`, this many metres
    to the left of the two points, as seen along the first pass.
    """

    i: int
    s: float
    sigma: float
    j: int | None = None
    t: float = 0.0
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    side: float = 0.0


@dataclass(frozen=True, eq=False)
class Placing:
    """A choice of candidates (p,) with its heading, origins (p, 3) and total cost.

    heading: radians; heading_sigma: how well the survey tells it.
    """

    choice: IntArray
    heading: float
    heading_sigma: float
    origins: FloatArray
    cost: float

    def response(self, links: list[Link]) -> tuple[FloatArray, FloatArray]:
        """How origins answer: (p, k) to a shift of each link, and (p,) m² to the links' noise."""
        design, weight = _design(links, len(self.choice))
        rows = design * weight[:, None]
        normal = rows.T @ rows + _RIDGE * np.eye(design.shape[1])
        shifts = np.asarray(np.linalg.solve(normal, rows.T * weight), dtype=np.float64)
        noise = np.array([link.sigma for link in links])
        return shifts, np.sum((shifts * noise) ** 2, axis=1)


def place_rigidly(
    curves: Curves, links: list[Link], heading: float | None, choice: IntArray
) -> Placing:
    """The best placing of one candidate a pass; `heading` where it is known.

    Workpiece = Rz(-heading) magnetic.  Passes that nothing holds stay at the
    origin.  A link that contradicts the
    others (a slip of the pen) loses its weight over a few rounds.
    """
    design, weight = _design(links, len(choice))
    turned, fixed = _sides(curves, links, choice)
    trust = np.ones(len(links))
    for _ in range(_ROUNDS):
        solution = _solve_links(design, weight * trust, turned, fixed, heading)
        away = np.linalg.norm(_misfit(design, turned, fixed, solution), axis=1) * weight
        trust = _LINK_LIMIT / np.maximum(away, _LINK_LIMIT)
    angle, sigma, origins = solution
    misfit = float(np.sum(linear_cost(away**2)))
    return Placing(choice, angle, sigma, origins, misfit + float(curves.cost[choice].sum()))


def _solve_links(
    design: FloatArray,
    weight: FloatArray,
    turned: FloatArray,
    fixed: FloatArray,
    heading: float | None,
) -> tuple[float, float, FloatArray]:
    """Heading, its sigma and origins (p, 3) of weighted least squares, in closed form.

    With the origins eliminated the misfit is |Rz(-h) u - v|², whose minimum
    over h is at atan2 of the cross and the level products of u and v.
    """
    rows = design * weight[:, None]
    normal = rows.T @ rows + _RIDGE * np.eye(design.shape[1])
    both = np.concatenate([turned, fixed], axis=1) * weight[:, None]
    solved = np.linalg.solve(normal, rows.T @ both)
    rest = both - rows @ solved
    pu, pv = rest[:, :3], rest[:, 3:]
    level = float(np.sum(pv[:, :2] * pu[:, :2]))
    cross = float(np.sum(pv[:, 0] * pu[:, 1] - pv[:, 1] * pu[:, 0]))
    sigma = float(1 / np.sqrt(max(np.hypot(level, cross), 1e-12)))
    if heading is None:
        heading = float(np.arctan2(cross, level))
    origins = solved[:, 3:] - solved[:, :3] @ about_z(-heading).T
    return heading, sigma, origins


def _misfit(
    design: FloatArray,
    turned: FloatArray,
    fixed: FloatArray,
    solution: tuple[float, float, FloatArray],
) -> FloatArray:
    """(k, 3) metres, each link's misfit."""
    heading, _, origins = solution
    return np.asarray(design @ origins + turned @ about_z(-heading).T - fixed)


def _design(links: list[Link], passes: int) -> tuple[FloatArray, FloatArray]:
    """(k, p) which origins each link takes with which sign, and (k,) 1/sigma."""
    design = np.zeros((len(links), passes))
    for row, link in enumerate(links):
        design[row, link.i] = 1.0 if link.j is None else -1.0
        if link.j is not None:
            design[row, link.j] = 1.0
    return design, np.array([1 / np.hypot(link.sigma, DRIFT_SIGMA) for link in links])


def _sides(curves: Curves, links: list[Link], choice: IntArray) -> tuple[FloatArray, FloatArray]:
    """Parts of each link that turn with the heading (k, 3) and those that don't (k, 3)."""
    turned, fixed = np.zeros((len(links), 3)), np.zeros((len(links), 3))
    for row, link in enumerate(links):
        one = int(choice[link.i])
        fixed[row] = link.target
        if link.j is None:
            turned[row] = curves.point(one, link.s)
            continue
        other = int(choice[link.j])
        turned[row] = curves.point(other, link.t) - curves.point(one, link.s)
        if link.side:
            first = int(choice[0])
            left = curves.left(one, link.s, first) + curves.left(other, link.t, first)
            turned[row] -= link.side * left / max(float(np.linalg.norm(left)), 1e-9)
    return turned, fixed


def best_placings(
    curves: Curves, links: list[Link], heading: float | None, within: float
) -> list[Placing]:
    """The placings of all combinations of candidates within a cost of the best, best first."""
    passes = int(curves.owner.max()) + 1
    options = [np.flatnonzero(curves.owner == p).astype(np.int64) for p in range(passes)]
    combinations = _combinations(curves, links, heading, options)
    placings = [place_rigidly(curves, links, heading, choice) for choice in combinations]
    placings.sort(key=lambda placing: placing.cost)
    return [placing for placing in placings if placing.cost <= placings[0].cost + within]


def _combinations(
    curves: Curves, links: list[Link], heading: float | None, options: list[IntArray]
) -> list[IntArray]:
    """All combinations, or where they are too many those around the best found by turns."""
    if np.prod([float(len(part)) for part in options]) <= MOST_COMBINATIONS:
        return [np.array(choice) for choice in product(*options)]
    best = np.array([part[np.argmin(curves.cost[part])] for part in options])
    for _ in range(3):
        for p, part in enumerate(options):
            tried = [_with(best, p, candidate) for candidate in part]
            costs = [place_rigidly(curves, links, heading, choice).cost for choice in tried]
            best = tried[int(np.argmin(costs))]
    around = [
        _with(best, p, candidate)
        for p, part in enumerate(options)
        for candidate in part
        if candidate != best[p]
    ]
    return [best, *around]


def _with(choice: IntArray, p: int, candidate: int) -> IntArray:
    out = choice.copy()
    out[p] = candidate
    return out
