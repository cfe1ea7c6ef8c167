"""Hidden checks of lab 03, continued: who flies, and what a change of world does to numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from grader.material import hidden
from uavlab import frames, so3
from uavlab.exercises import draw
from uavlab.exercises.expect import expect_name, of_shapes
from uavlab.exercises.kalman_bank import arbitrate, moved_reference, shift_between
from uavlab.exercises.spec import Function, expect, expect_close
from uavlab.types import Array, Hypothesis, Shift

CANARY = "canary-13d9e2800fc00c41118bb2f3"

NAMES = ("gnss", "rtk", "slam", "flow", "flow+slam")


def crowd(
    rng: np.random.Generator, spreads: Array, sick: tuple[int, ...] = ()
) -> dict[str, Hypothesis]:
    """Hypotheses with these traces [m²], in any order, under any name."""
    names = rng.permutation(NAMES)[: len(spreads)]
    made = [draw.hypothesis(rng, spread=s, reliable=i not in sick) for i, s in enumerate(spreads)]
    order = rng.permutation(len(spreads))
    return {str(names[i]): made[i] for i in order}


def by_spread(told: dict[str, Hypothesis]) -> list[str]:
    """Names, the most certain of its position first."""
    return sorted(told, key=lambda name: np.trace(told[name].P[:, 0, 0] * np.eye(3)))


@hidden(arbitrate)
def a_request_first(f: Function, rng: np.random.Generator) -> None:
    """A request must be obeyed even where others are more certain, but not if what it asks for is not reliable."""
    told = crowd(rng, rng.uniform(1.0, 1.5) * np.array((0.1, 0.4, 2.0, 9.0)), sick=(2,))
    best, second, sick, last = by_spread(told)
    for current, request, want in (
        (best, last, last), (best, second, second), (sick, last, last),
        (best, sick, best), (sick, sick, best), (last, last, last),
    ):  # fmt: skip
        expect_name(f(told, current, request), want)


@hidden(arbitrate, weight=2.0)
def the_most_certain_of_the_reliable(f: Function, rng: np.random.Generator) -> None:
    """Without a request the most certain of the reliable must fly, once it is twice as certain as a healthy one."""
    told = crowd(rng, rng.uniform(1.0, 1.5) * np.array((0.1, 1.0, 1.2, 1.4, 5.0)), sick=(0, 2))
    sick, second, ill, third, last = by_spread(told)
    for current, want in (
        (sick, second), (ill, second), (last, second), (third, third), (second, second),
    ):  # fmt: skip
        expect_name(f(told, current, ""), want)


@hidden(arbitrate)
def only_positions_count(f: Function, rng: np.random.Generator) -> None:
    """Only covariances of positions may be compared, not of velocities, accelerations and headings."""
    told = crowd(rng, np.array((0.1, 1.0, 9.0)))
    best, second, last = by_spread(told)
    for name, size in ((best, 1e3), (last, 1e-3)):
        x = told[name]
        scale = np.array((1.0, size, size))
        told[name] = x._replace(P=x.P * scale * scale[:, None], P_h=size * x.P_h)
    expect_name(f(told, last, ""), best)
    expect_name(f(told, second, ""), best)
    expect_name(f(told, best, ""), best)
    expect_name(f(told, best, last), last)


@hidden(arbitrate)
def nobody_is_reliable(f: Function, rng: np.random.Generator) -> None:
    """If nobody is reliable the current one must fly on, whatever is asked for; once one is, it must take over."""
    told = crowd(rng, np.array((0.1, 1.0, 9.0)), sick=(0, 1, 2))
    best, second, last = by_spread(told)
    expect_name(f(told, last, best), last)
    expect_name(f(told, second, ""), second)
    told[last] = told[last]._replace(reliable=True)
    expect_name(f(told, best, ""), last)
    expect_name(f(told, second, best), last)


@hidden(arbitrate, weight=0.5)
def nobody_of_that_name(f: Function, rng: np.random.Generator) -> None:
    """A name that is not among the hypotheses must raise a LookupError; the ones that are must not."""
    told = crowd(rng, np.array((0.1, 1.0, 9.0)))
    best, second, last = by_spread(told)
    expect_name(f(told, second, last), last)
    expect_name(f(told, last, ""), best)
    for names in (("nobody", best), (best, "nobody"), ("nobody", "")):
        try:
            f(told, *names)
        except LookupError:
            continue
        expect(False, "It must raise a LookupError.")


def shift(got: Any) -> Shift:
    """What was got as a shift, if it is one."""
    r, heading = of_shapes(got, (3,), ())
    return Shift(r, float(heading))


@hidden(shift_between)
def there_and_on(f: Function, rng: np.random.Generator) -> None:
    """From the first world to the second and on to the third must be the way from the first to the third."""
    a, b, c = (draw.hypothesis(rng) for _ in range(3))
    first, second, whole = (shift(f(*two)) for two in ((a, b), (b, c), (a, c)))
    both = frames.compose(second, first)
    expect_close(whole.r, both.r)
    expect_close(frames.wrap(whole.heading - both.heading), 0.0)
    expect_close(so3.about_z(first.heading) @ a.x[:, 0] + first.r, b.x[:, 0])


@hidden(shift_between)
def across_the_seam_of_headings(f: Function, rng: np.random.Generator) -> None:
    """The turn must be told in [−π, π), also where one heading is just below π and the other just above −π."""
    for one, other in ((3.1, -3.1), (-3.0, 3.0), (2.0, -2.5), (-1.0, 2.5)):
        a, b = draw.hypothesis(rng), draw.hypothesis(rng)
        a, b = a._replace(h=np.array((one, 1.0))), b._replace(h=np.array((other, 1.0)))
        r, turn = of_shapes(f(a, b), (3,), ())
        expect_close(turn, frames.wrap(other - one))
        expect_close(r, b.x[:, 0] - so3.about_z(other - one) @ a.x[:, 0])


@hidden(shift_between)
def back_again(f: Function, rng: np.random.Generator) -> None:
    """The way back must undo the way there, and from a world to itself there is no way to go."""
    for _ in range(2):
        a, b = draw.hypothesis(rng), draw.hypothesis(rng)
        there, back = (shift(f(*two)) for two in ((a, b), (b, a)))
        expect_close(back.r, frames.inverse(there).r)
        expect_close(frames.wrap(back.heading + there.heading), 0.0)
        expect_close(so3.about_z(there.heading) @ a.x[:, 0] + there.r, b.x[:, 0])
        none = shift(f(a, a))
        expect_close(np.append(none.r, none.heading), np.zeros(4))


SHAPES = ((3,), (3,), (3,), (3,), (), ())


@hidden(moved_reference)
def points_and_vectors(f: Function, rng: np.random.Generator) -> None:
    """A point must be turned and shifted, a vector only turned."""
    for _ in range(2):
        old, way = draw.reference(rng), Shift(draw.vector(rng, 3.0), draw.angle(rng))
        got = of_shapes(f(old, way), *SHAPES)
        turn = so3.about_z(way.heading)
        expect_close(got[0], turn @ old.r + way.r)
        for was, now in zip(old[1:4], got[1:4], strict=True):
            expect_close(now, turn @ was)


@hidden(moved_reference)
def there_and_back(f: Function, rng: np.random.Generator) -> None:
    """Moved to another world and back, a reference must be what it was; moved twice, what one way makes of it."""
    old = draw.reference(rng)
    first, second = (Shift(draw.vector(rng, 3.0), float(rng.uniform(0.3, 1.4))) for _ in range(2))
    once = type(old)(*of_shapes(f(old, first), *SHAPES))  # type: ignore[arg-type]
    expect_close(once.v, so3.about_z(first.heading) @ old.v)
    for was, now in zip(old, of_shapes(f(once, frames.inverse(first)), *SHAPES), strict=True):
        expect_close(now, was)
    whole = of_shapes(f(old, frames.compose(second, first)), *SHAPES)
    for one, two in zip(whole, of_shapes(f(once, second), *SHAPES), strict=True):
        expect_close(two, one)


@hidden(
    moved_reference, weight=8.0
)  # heavy: a shipped helper that wraps headings passes all others
def wound_up(f: Function, rng: np.random.Generator) -> None:
    """A heading that has wound up some turns must go on from there, and its rate stay as it is."""
    for turns in (-2, 0, 3):
        old, way = draw.reference(rng), Shift(draw.vector(rng, 3.0), 3.0)
        eta = float(rng.uniform(1.0, 3.0)) + 2.0 * np.pi * turns
        got = of_shapes(f(old._replace(heading=eta), way), *SHAPES)
        expect_close(got[4], eta + 3.0)
        expect_close(got[5], old.heading_rate)
