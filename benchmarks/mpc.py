"""Quadratic programmes of lab 06, a hundred a second: what flies beside OSQP at its defaults and Clarabel.

All is end to end in Python, numbers in, first inputs out, on the same problems in the same order, each contestant warm
where it can be. Whoever measures on a shared machine measures others, too: so a problem's time is the least of all
rounds, and `worst` is the worst problem; `raw` is whatever was seen.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np
from tqdm import tqdm

from uavlab.limits import ForceLimits, limit_group
from uavlab.qp import QP, Plan, cost, slacked, without_slacks
from uavlab.solutions.mpc import MpcTracker, build_force_qp, build_soft_qp, discretize
from uavlab.solvers import Affine, Solver, affine
from uavlab.types import Array, Estimate, Reference
from uavlab.weights import (
    HORIZONTAL,
    VERTICAL,
    InputBounds,
    LandingWeights,
    landing_model,
    soft_limits,
    with_endless_horizon,
)

PAPER = 709.5  # [µs] mean of Tzoumanikas et al. 2019 with CVXGEN, on an Intel NUC i7-7567U
TICKS, DT, N = 400, 0.05, 26
LIMITS = ForceLimits()
AXES = ((LIMITS.horizontal, 0.0, HORIZONTAL),) * 2 + ((LIMITS.vertical, 0.5, VERTICAL),)


class Contestant(Protocol):
    """Problems in order, from `reset` on."""

    def reset(self) -> None:
        """Forget what was solved."""

    def __call__(self, numbers: Array) -> Array:
        """First inputs for what a problem is built from."""


# Contestants ------------------------------------------------------------------------------------------


class Daqp:
    """What flies in uavlab: small dense problems with soft rows, an active set."""

    def __init__(self, families: Sequence[Affine], inputs: int, warm: bool = True) -> None:
        self.families, self.inputs, self.warm = families, inputs, warm
        made = {id(f): Solver(f.qp) for f in families}
        self.solvers = [made[id(f)] for f in families]
        self.reset()

    def reset(self) -> None:
        """Begin cold."""
        self.plans: list[Plan | None] = [None] * len(self.families)

    def __call__(self, numbers: Array) -> Array:
        """First inputs of all families."""
        each = numbers.reshape(len(self.families), -1)
        for i, family in enumerate(self.families):
            plan = self.solvers[i].solve(*family(each[i]), self.plans[i] if self.warm else None)
            self.plans[i] = plan
        return np.concatenate([p.z[: self.inputs] for p in self.plans if p is not None])


class OsqpDefaults:
    """OSQP as it comes, warm from the problem before; hard rows only, so soft ones have slacks."""

    def __init__(self, family: Affine, read: slice) -> None:
        self.family, self.read = family, read
        self.reset()

    def reset(self) -> None:
        """Begin cold."""
        import osqp
        from scipy.sparse import csc_matrix, triu

        qp = self.family.qp
        self.model = osqp.OSQP()
        self.model.setup(csc_matrix(triu(qp.P)), qp.q, csc_matrix(qp.A), qp.l, qp.u, verbose=False)

    def __call__(self, numbers: Array) -> Array:
        """What `read` takes from the solution."""
        q, l, u = self.family(numbers)
        self.model.update(q=q, l=l, u=u)
        return self.model.solve(raise_error=False).x[self.read]


class Clarabel:
    """Clarabel with new sides for the same matrices; interior points do not start warm."""

    def __init__(self, family: Affine, read: slice, tol: float = 1e-8) -> None:
        import clarabel
        from scipy.sparse import csc_matrix, triu

        qp, self.family, self.read = family.qp, family, read
        equal = (qp.l == qp.u) & np.isfinite(qp.l)
        self.equal, self.above = equal, np.isfinite(qp.u) & ~equal & (qp.u < 1e29)
        self.below = np.isfinite(qp.l) & ~equal & (qp.l > -1e29)
        A = np.vstack((qp.A[equal], qp.A[self.above], -qp.A[self.below]))
        settings = clarabel.DefaultSettings()
        settings.verbose, settings.presolve_enable = False, False  # else sides cannot be changed
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tol
        cones = [
            clarabel.ZeroConeT(int(equal.sum())),
            clarabel.NonnegativeConeT(int(len(A) - equal.sum())),
        ]
        self.model = clarabel.DefaultSolver(
            csc_matrix(triu(qp.P)), qp.q, csc_matrix(A), self._sides(qp.l, qp.u), cones, settings
        )

    def _sides(self, l: Array, u: Array) -> Array:
        return np.concatenate((u[self.equal], u[self.above], -l[self.below]))

    def reset(self) -> None:
        """It always begins cold."""

    def __call__(self, numbers: Array) -> Array:
        """What `read` takes from the solution."""
        q, l, u = self.family(numbers)
        self.model.update(q=q, b=self._sides(l, u))
        return np.array(self.model.solve().x[self.read])


# The force MPC ----------------------------------------------------------------------------------------


def nine_states(x0: Array, last: Array) -> QP:
    """MRS (40)-(52) as they stand, with slacks for the speeds: variables x_1..x_N (9 N), u (3 N), slacks (3 N)."""
    A, B = np.zeros((9, 9)), np.zeros((9, 3))
    for i, (_, p, _) in enumerate(AXES):
        A[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = ((1, DT, DT**2 / 2), (0, 1, DT), (0, 0, p))
        B[3 * i + 2, i] = 1.0 - p
    Q, S = (np.concatenate([getattr(w, name) for *_, w in AXES]) for name in "QS")
    nx, nu, size = 9 * N, 3 * N, 15 * N
    P = np.diag(2.0 * np.concatenate((np.tile(Q, N - 1), S, np.zeros(6 * N))))
    q = np.concatenate((np.zeros(nx + nu), np.full(3 * N, 1e4)))
    v, a = (np.tile([getattr(x, name) for x, *_ in AXES], N) for name in "va")
    model = np.zeros((nx, size))
    model[:, :nx] = np.eye(nx) - np.kron(np.eye(N, k=-1), A)
    model[:, nx : nx + nu] = -np.kron(np.eye(N), B)
    start = np.concatenate((A @ x0.ravel(), np.zeros(nx - 9)))
    speeds, slack = np.zeros((3 * N, size)), np.zeros((3 * N, size))
    speeds[np.arange(3 * N), 3 * np.arange(3 * N) + 1] = 1.0
    slack[:, nx + nu :] = np.eye(3 * N)
    inputs = np.eye(size)[nx : nx + nu]
    flat = np.arange(nu) % 3 < 2
    steps = (inputs - np.vstack((np.zeros((3, size)), inputs[:-3])))[flat]
    most = np.full(2 * N, 5.0 * DT)
    most[:2] = 5.0 * 0.01
    before = np.concatenate((last[:2], np.zeros(2 * N - 2)))
    free, none = np.full(3 * N, np.inf), np.zeros(3 * N)
    rows = np.vstack((model, speeds - slack, speeds + slack, slack, inputs, steps))
    l = np.concatenate((start, -free, -v, none, -a, before - most))
    u = np.concatenate((start, v, free, free, a, before + most))
    return QP(P, q, rows, l, u, np.full(len(l), np.inf))


def condensed(i: int) -> Affine:
    """One axis, as the exercise builds it, of (position error, velocity, acceleration, last input)."""
    limits, p, weights = AXES[i]
    build = partial(_one_axis, limits=limits, N=N, dt=DT, p=p, weights=weights)
    return affine(build, ((3,), ()))


def _one_axis(x0: Array, last: float, **more: object) -> QP:
    return build_force_qp(x0, np.zeros((N, 3)), last, **more)  # type: ignore[arg-type]


def force_problems(ours: Daqp, seed: int = 0) -> Array:
    """Closed loop on a noisy estimate: two ways to go, and a jump of the estimate by 5 m: (TICKS, 12).

    A point with a lag of 0.1 s flies what is planned.
    """
    rng, x, u, goal, jump = np.random.default_rng(seed), np.zeros((3, 3)), np.zeros(3), 0.0, 0.0
    problems = np.zeros((TICKS, 3, 4))
    for k in range(TICKS):
        goal = np.array((3.0, -2.0, 1.0)) if 20 <= k < 250 else np.zeros(3)
        jump = np.array((5.0, 0.0, 0.0)) if k >= 150 else np.zeros(3)
        noise = rng.normal(size=(3, 3)) * (0.02, 0.05, 0.1)
        problems[k, :, :3] = x.T + noise
        problems[k, :, 0] += jump - goal
        problems[k, :, 3] = u
        u = ours(problems[k].ravel())
        x = np.array((x[0] + 0.01 * x[1], x[1] + 0.01 * x[2], x[2] + 0.1 * (u - x[2])))
    return problems.reshape(TICKS, 12)


def _told(numbers: Array) -> Array:
    """A problem of three axes in the order of `nine_states`."""
    each = numbers.reshape(3, 4)
    return np.concatenate((each[:, :3].ravel(), each[:, 3]))


class Reordered:
    """A contestant that takes the numbers of three axes in another order."""

    def __init__(self, inner: Contestant) -> None:
        self.inner, self.reset = inner, inner.reset

    def __call__(self, numbers: Array) -> Array:
        """First inputs of all axes."""
        return self.inner(_told(numbers))


class PerAxis:
    """One contestant for each axis."""

    def __init__(self, inner: Sequence[Contestant]) -> None:
        self.inner = inner

    def reset(self) -> None:
        """All begin cold."""
        for one in self.inner:
            one.reset()

    def __call__(self, numbers: Array) -> Array:
        """First inputs of all axes."""
        each = numbers.reshape(len(self.inner), -1)
        return np.concatenate([one(x) for one, x in zip(self.inner, each, strict=True)])


def force(rounds: int) -> None:
    """The force MPC, three axes, N = 26."""
    flat = condensed(0)
    families = (flat, flat, condensed(2))
    large = affine(nine_states, ((9,), (3,)))
    first = slice(9 * N, 9 * N + 3)
    small = [
        f._replace(qp=slacked(f.qp), M=_slacked_map(f, f.M), c=_slacked_map(f, f.c[:, None])[:, 0])
        for f in families
    ]
    ours = Daqp(families, 1)
    problems = force_problems(ours)
    exact = _answers(PerAxis([Clarabel(f, slice(1), 1e-11) for f in small]), problems)
    field: dict[str, Contestant] = {
        "uavlab: 3 x 26 inputs, DAQP": ours,
        "the same, each problem cold": Daqp(families, 1, warm=False),
        "OSQP at its defaults, 9 states, sparse": Reordered(OsqpDefaults(large, first)),
        "OSQP at its defaults, 3 x 26 inputs": PerAxis([OsqpDefaults(f, slice(1)) for f in small]),
        "Clarabel, 9 states, sparse": Reordered(Clarabel(large, first)),
    }
    print(f"\nForce MPC of MRS, 3 axes, N = {N}: {TICKS} problems at 100 Hz, first inputs [m/s²]")
    found = race(field, problems, exact, rounds)
    names = list(field)
    slower = min(found[n].mean for n in names[2:4])
    print(f"  OSQP's better form takes {slower / found[names[0]].mean:.1f} times as long")
    _target("mean < 70 µs", found[names[0]].mean < 70.0)
    _target("worst problem < 300 µs", found[names[0]].worst < 300.0)
    _target("8 x OSQP at its defaults", slower / found[names[0]].mean >= 8.0)
    _target("error < 1e-6 m/s²", found[names[0]].error < 1e-6)


def _slacked_map(family: Affine, columns: Array) -> Array:
    """Columns of an affine map, for the problem with slacks (`slacked`)."""
    qp, n, m = family.qp, family.qp.q.size, family.qp.l.size
    soft = np.flatnonzero(np.isfinite(qp.soft))
    k, linear = soft.size, columns is family.M
    q, l, u = columns[:n], columns[n : n + m].copy(), columns[n + m :]
    of_slacks = np.zeros((k, columns.shape[1])) if linear else qp.soft[soft, None]
    huge = np.zeros_like(of_slacks) if linear else np.full_like(of_slacks, 1e30)
    again = l[soft].copy()
    l[soft] = -huge
    zero = np.zeros_like(of_slacks)
    return np.vstack((q, of_slacks, l, again, zero, u, huge, huge))


# The landing ------------------------------------------------------------------------------------------


def landing(rounds: int) -> None:
    """The landing MPC with soft rows for N = 2, 10, 20."""
    for n in (2, 10, 20):
        weights = with_endless_horizon(LandingWeights(), DT)
        build = partial(_landing, n=n, weights=weights)
        whole = affine(build, ((10,),))
        small = affine(lambda x, b=build, k=3 * n: without_slacks(b(x), k), ((10,),))
        all_of, ours = slice(3 * n), Daqp((small,), 3 * n)
        problems = landing_problems(ours)
        exact = _answers(Clarabel(whole, all_of, 1e-11), problems)
        field: dict[str, Contestant] = {
            f"uavlab: {3 * n} inputs, DAQP": ours,
            f"OSQP at its defaults, {13 * n} variables": OsqpDefaults(whole, all_of),
            f"Clarabel, {13 * n} variables": Clarabel(whole, all_of),
        }
        print(f"\nLanding MPC, N = {n}: {TICKS} problems at 20 Hz, plans [rad], [m/s²]")
        turns = rounds if n < 20 else min(rounds, 3)  # OSQP takes its time
        found = race(field, problems, exact, turns, beside=PAPER)
        for name, contestant in field.items():
            contestant.reset()
            above = _above(small, problems, _answers(contestant, problems), exact)
            print(f"  costs at most {above:7.0e} more than the oracle's plan, relative: {name}")
        best = found[next(iter(field))]
        most, worst = (60.0, 150.0) if n == 2 else (120.0, 1000.0)
        _target(f"mean < {most:g} µs", best.mean < most)
        _target(f"worst problem < {worst:g} µs", best.worst < worst)


def _above(family: Affine, problems: Array, plans: Array, exact: Array) -> float:
    """The most by which a plan costs more than the oracle's, relative, inputs within their bounds."""
    worst = 0.0
    for numbers, z, best in zip(problems, plans, exact, strict=True):
        q, l, u = family(numbers)
        qp, n = family.qp._replace(q=q, l=l, u=u), len(q)
        costs = [cost(qp, x.clip(l[:n], u[:n])) for x in (z, best)]
        worst = max(worst, (costs[0] - costs[1]) / (1.0 + abs(costs[1])))
    return worst


def _landing(x0: Array, *, n: int, weights: LandingWeights) -> QP:
    return build_soft_qp(
        x0, np.zeros(10), weights=weights, bounds=InputBounds(), soft=soft_limits(2.5, 1.0, 0.3),
        N=n, dt=DT,
    )  # fmt: skip


def landing_problems(ours: Daqp, seed: int = 1) -> Array:
    """Closed loop on the linear model, with noise, and a kick now and then: states (TICKS, 10) less what is wanted."""
    rng, x = np.random.default_rng(seed), np.zeros(10)
    A, B = discretize(*landing_model(), DT)
    problems = np.zeros((TICKS, 10))
    for k in range(TICKS):
        if k % 40 == 0:  # another goal, and a gust
            x = x + rng.normal(size=10) * (4.0, 1.5, 0.1, 0.5, 4.0, 1.5, 0.1, 0.5, 2.0, 1.0)
        problems[k] = x + 0.02 * rng.normal(size=10)
        x = A @ x + B @ ours(problems[k])[:3]
    return problems


# The tracker ------------------------------------------------------------------------------------------


class Asked(NamedTuple):
    """A programme that a tracker made in flight."""

    qp: QP
    plan: Plan


def tracker(rounds: int) -> None:
    """Whole steps of the MPC tracker, and its programmes, N = 40."""
    part = MpcTracker(limit_group("fast"))
    start = Estimate(np.zeros(3), np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3))
    goals = {0: (20.0, -10.0, 3.0), 150: (-5.0, 4.0, 1.0), 300: (-5.0, 4.5, 1.0)}
    least, raw, asked = np.full(TICKS, np.inf), [], []
    for turn in range(rounds + 1):
        memory = part.init(start, None)
        with _Recorder(asked if turn == 0 else None):
            for k in range(TICKS):
                goal = _stand(goals[k]) if k in goals else None
                before = time.perf_counter()
                memory, _ = part.step(memory, start, goal, 0.01)
                took = 1e6 * (time.perf_counter() - before)
                if turn:
                    least[k] = min(least[k], took)
                    raw.append(took)
    print(f"\nMPC tracker, 3 axes and heading, N = {part.N}: {TICKS} whole steps at 100 Hz")
    line(Times(least.mean(), least.max(), np.array(raw), 0.0), "uavlab: MpcTracker.step")
    _target("worst step < 1 ms", float(least.max()) < 1000.0)
    some = asked[:: max(1, len(asked) // 40)]
    print(
        f"{len(some)} of its {len(asked)} programmes, alone; error: cost above the least, relative"
    )
    _programmes(some, rounds)


def _programmes(some: Sequence[Asked], rounds: int) -> None:
    from uavlab.solvers import Osqp

    made: dict[int, tuple[Solver, Osqp]] = {}
    for x in some:
        key = id(x.qp.P)
        if key not in made:
            made[key] = Solver(x.qp), Osqp(x.qp, eps=1e-3, iterations=4000)
    for which, name in enumerate(("uavlab: DAQP, cold", "OSQP to 1e-3, cold")):
        least, raw, above = np.full(len(some), np.inf), [], np.zeros(len(some))
        for _ in range(rounds):
            for i, x in enumerate(some):
                before = time.perf_counter()
                plan = made[id(x.qp.P)][which].solve(x.qp.q, x.qp.l, x.qp.u)
                took = 1e6 * (time.perf_counter() - before)
                least[i] = min(least[i], took)
                raw.append(took)
                best = cost(x.qp, x.plan.z)
                above[i] = (cost(x.qp, plan.z) - best) / (1.0 + abs(best))
        line(Times(least.mean(), least.max(), np.array(raw), float(above.max())), name)


def _stand(r: tuple[float, float, float]) -> Reference:
    zero = np.zeros(3)
    return Reference(np.array(r), zero, zero, zero, 0.5, 0.0)


class _Recorder:
    """While it is open, every programme that a `Solver` solves is kept."""

    def __init__(self, to: list[Asked] | None) -> None:
        self.to, self.solve = to, Solver.solve

    def __enter__(self) -> None:
        if self.to is None:
            return
        to, solve = self.to, self.solve

        def kept(solver: Solver, q: Array, l: Array, u: Array, warm: Plan | None = None) -> Plan:
            plan = solve(solver, q, l, u, warm)
            to.append(Asked(solver.qp._replace(q=q.copy(), l=l.copy(), u=u.copy()), plan))
            return plan

        Solver.solve = kept  # type: ignore[method-assign]

    def __exit__(self, *_: object) -> None:
        Solver.solve = self.solve  # type: ignore[method-assign]


# Times ------------------------------------------------------------------------------------------------


class Times(NamedTuple):
    """What one contestant took [µs], and how far off it was."""

    mean: float  # over problems, of the least of all rounds
    worst: float  # problem, of the least of all rounds
    raw: Array  # every sample
    error: float


def race(
    field: dict[str, Contestant], problems: Array, exact: Array, rounds: int, beside: float = 0.0
) -> dict[str, Times]:
    """All contestants in turn, round by round, on the same problems."""
    least = {name: np.full(len(problems), np.inf) for name in field}
    raw: dict[str, list[Array]] = {name: [] for name in field}
    error = dict.fromkeys(field, 0.0)
    for _ in tqdm(range(rounds), desc="rounds", leave=False):
        for name, contestant in field.items():
            contestant.reset()
            times, got = _timed(contestant, problems)
            least[name] = np.minimum(least[name], times)
            raw[name].append(times)
            error[name] = max(error[name], float(np.abs(got - exact).max()))
    found = {
        n: Times(least[n].mean(), least[n].max(), np.concatenate(raw[n]), error[n]) for n in field
    }
    first = next(iter(found.values())).mean
    for name, times in found.items():
        line(times, name, times.mean / first)
    if beside:
        print(
            f"  {beside:8.1f}{'':47}{beside / first:7.1f} x  the paper, CVXGEN on its own computer"
        )
    return found


def _timed(contestant: Callable[[Array], Array], problems: Array) -> tuple[Array, Array]:
    times, got = np.zeros(len(problems)), []
    for k, numbers in enumerate(problems):
        before = time.perf_counter()
        answer = contestant(numbers)
        times[k] = time.perf_counter() - before
        got.append(answer)
    return 1e6 * times, np.array(got)


def _answers(contestant: Contestant, problems: Array) -> Array:
    return np.array([contestant(numbers) for numbers in problems])


def line(times: Times, name: str, ratio: float = 1.0) -> None:
    """One row: mean, worst problem; raw mean, 99.9 % and worst; error; ratio."""
    late = np.quantile(times.raw, 0.999)
    print(
        f"  {times.mean:8.1f} {times.worst:9.1f} | {times.raw.mean():8.1f} {late:8.0f} {times.raw.max():8.0f}"
        f" | {times.error:7.0e} {ratio:7.1f} x  {name}"
    )


def _target(text: str, met: bool) -> None:
    print(f"  {'met' if met else 'MISSED'}: {text}")


def report(rounds: int) -> None:
    """All three."""
    print(
        "\nµs: mean and worst problem, each the least of all rounds | raw mean, 99.9 %, worst |"
        " largest error, time as a multiple of the first"
    )
    force(rounds)
    tracker(rounds)
    landing(rounds)
