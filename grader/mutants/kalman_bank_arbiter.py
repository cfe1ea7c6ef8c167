"""Known wrong answers of lab 03, continued: who flies, and what a change of world does to numbers."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from uavlab import frames
from uavlab.exercises import draw
from uavlab.exercises.kalman_bank import arbitrate, moved_reference, shift_between
from uavlab.so3 import about_z
from uavlab.types import Reference, Shift

CANARY = "canary-02a8060c481c5cbf11774cde"

# arbitrate --------------------------------------------------------------------------------------------


@sample(arbitrate)
def crowds(rng: np.random.Generator) -> list[Arguments]:
    base = (0.1, 1.0, 1.3, 4.0, 9.0)
    told, sick = {}, {}
    moving = (40.0, 30.0, 10.0, 50.0, 20.0)  # how uncertain they are of velocity and acceleration
    for name, spread, more in zip("abcde", base, moving, strict=True):
        told[name] = draw.hypothesis(rng, spread=spread)
        scale = np.array((1.0, more, more))
        told[name] = told[name]._replace(P=told[name].P * scale * scale[:, None])
        sick[name] = told[name]._replace(reliable=False)
    some = {**told, "a": sick["a"], "d": sick["d"]}
    return [
        (told, "a", "e"), (some, "b", "a"), (some, "d", ""), (some, "c", ""), (some, "e", ""),
        (sick, "e", "a"), (told, "e", ""), (some, "e", "d"), (told, "b", "c"), (some, "a", ""),
    ]  # fmt: skip


def spread(x):
    return sum(P[0, 0] for P in x.P)


def pick(told, current, request, *, cost=spread, worth=0.5, best=min, obey=True):
    well = [name for name in told if told[name].reliable]
    if obey and request in well:
        return request
    if not well:
        return current
    first = best(well, key=lambda name: cost(told[name]))
    if current in well and cost(told[first]) >= worth * cost(told[current]):
        return current
    return first


@mutant(arbitrate, hint="The least covariance is asked for, not the largest.")
def the_least_certain(told, current, request):
    return pick(told, current, request, best=max, worth=np.inf)


@mutant(
    arbitrate,
    hint="Compare the positions' part only: the trace of all of it adds square metres and squares of velocities.",
)
def trace_of_everything(told, current, request):
    return pick(told, current, request, cost=lambda x: sum(np.trace(P) for P in x.P))


@mutant(arbitrate, hint="The request is not obeyed: it comes first, if it is reliable.")
def deaf(told, current, request):
    return pick(told, current, request, obey=False)


@mutant(arbitrate, hint="A request was obeyed that is not reliable.")
def blindly_obeyed(told, current, request):
    return request or pick(told, current, request)


@mutant(arbitrate, hint="It stays on a hypothesis that is not reliable: leave it at once.")
def faithful_to_the_sick(told, current, request):
    if request and told[request].reliable:
        return request
    return current if not told[current].reliable else pick(told, current, request)


@mutant(arbitrate, hint="It chooses one that is not reliable, because its covariance is the least.")
def believes_the_sick(told, current, request):
    if request and told[request].reliable:
        return request
    first = min(told, key=lambda name: spread(told[name]))
    return first if spread(told[first]) < 0.5 * spread(told[current]) else current


@mutant(
    arbitrate,
    hint="Two of about the same size will take turns: leave a reliable one only for less than half of its covariance.",
)
def restless(told, current, request):
    return pick(told, current, request, worth=1.0)


@mutant(
    arbitrate, hint="It never leaves a reliable one for a better one: the third rule is missing."
)
def content(told, current, request):
    return pick(told, current, request, worth=-1.0)


@mutant(
    arbitrate, hint="If nobody is reliable the current one stays: there is nothing better to go to."
)
def panic(told, current, request):
    if any(x.reliable for x in told.values()):
        return pick(told, current, request)
    return min(told, key=lambda name: spread(told[name]))


# shift_between ----------------------------------------------------------------------------------------


@sample(shift_between)
def pairs(rng: np.random.Generator) -> list[Arguments]:
    made = []
    for one, other in ((3.0, -2.5), (0.3, 1.5), (-2.8, 2.0), (1.0, -1.0), (-2.0, 0.4)):
        a, b = draw.hypothesis(rng), draw.hypothesis(rng)
        made.append((a._replace(h=np.array((one, 0.1))), b._replace(h=np.array((other, 0.2)))))
    return made


def between(a, b, back=1.0):
    turn = frames.wrap(b.h[0] - a.h[0])
    return Shift(b.x[:, 0] - about_z(back * turn) @ a.x[:, 0], turn)


@mutant(shift_between, hint="This is the way back: the shift must take a's world to b's.")
def way_back(a, b):
    return between(b, a)


@mutant(
    shift_between,
    hint="The turn is about the origin of a's world, not about the aircraft: turn r_a before you take it off r_b.",
)
def about_the_aircraft(a, b):
    return between(a, b, back=0.0)


@mutant(shift_between, hint="The turn is not wrapped: bring it into [−π, π).")
def turn_not_wrapped(a, b):
    return between(a, b)._replace(heading=b.h[0] - a.h[0])


@mutant(
    shift_between, hint="The headings are not used: the worlds may be turned against each other."
)
def not_turned(a, b):
    return Shift(b.x[:, 0] - a.x[:, 0], 0.0)


@mutant(shift_between, hint="r_a is turned the wrong way round.")
def turned_backwards(a, b):
    return between(a, b, back=-1.0)


@mutant(shift_between, hint="The turn has the wrong sign: η_b − η_a.")
def turn_of_the_other(a, b):
    turn = frames.wrap(a.h[0] - b.h[0])
    return Shift(b.x[:, 0] - about_z(turn) @ a.x[:, 0], turn)


@mutant(
    shift_between,
    hint="A row of x is one axis with its derivatives: the position is the first column.",
)
def row_for_column(a, b):
    turn = frames.wrap(b.h[0] - a.h[0])
    return Shift(b.x[0] - about_z(turn) @ a.x[0], turn)


@mutant(shift_between, hint="The heights are not used: the worlds may have different zeros.")
def flat_worlds(a, b):
    shift = between(a, b)
    return shift._replace(r=shift.r * (1.0, 1.0, 0.0))


# moved_reference --------------------------------------------------------------------------------------


@sample(moved_reference)
def references(rng: np.random.Generator) -> list[Arguments]:
    return [
        (draw.reference(rng)._replace(heading=2.5), Shift(draw.vector(rng, 3.0), s))
        for s in (1.5, -0.7, 2.0, 3.0, 0.9)
    ]


def carried(x, shift, turn=None):
    Rz = about_z(shift.heading if turn is None else turn)
    return Reference(
        Rz @ x.r + shift.r, Rz @ x.v, Rz @ x.a, Rz @ x.j, x.heading + shift.heading, x.heading_rate
    )


@mutant(
    moved_reference,
    hint="The velocity is not turned: a vector keeps its length, but not its direction.",
)
def velocity_as_it_was(x, shift):
    return carried(x, shift)._replace(v=x.v)


@mutant(
    moved_reference,
    hint="Vectors are not turned: velocity, acceleration and jerk are told in the new world, too.",
)
def vectors_as_they_were(x, shift):
    return carried(x, shift)._replace(v=x.v, a=x.a, j=x.j)


@mutant(moved_reference, hint="The position is shifted but not turned.")
def position_not_turned(x, shift):
    return carried(x, shift)._replace(r=x.r + shift.r)


@mutant(moved_reference, hint="First the turn, then the shift: r is told in the new world.")
def shifted_then_turned(x, shift):
    return carried(x, shift)._replace(r=about_z(shift.heading) @ (x.r + shift.r))


@mutant(moved_reference, hint="A vector is turned, never shifted: only points are.")
def vectors_shifted(x, shift):
    new = carried(x, shift)
    return new._replace(v=new.v + shift.r, a=new.a + shift.r, j=new.j + shift.r)


@mutant(moved_reference, hint="The heading is not turned along.")
def heading_as_it_was(x, shift):
    return carried(x, shift)._replace(heading=x.heading)


@mutant(
    moved_reference,
    hint="The heading was wrapped: one that has wound up some turns must go on from there.",
)
def heading_wrapped(x, shift):
    return frames.moved(x, shift)


@mutant(
    moved_reference, hint="This is the way back: the shift leads from the old world to the new one."
)
def moved_back(x, shift):
    return carried(x, frames.inverse(shift))


@mutant(moved_reference, hint="Points and vectors are turned the wrong way round.")
def turned_the_other_way(x, shift):
    return carried(x, shift, turn=-shift.heading)


@mutant(moved_reference, hint="A rate does not change with the world: the heading rate stays.")
def rate_turned_too(x, shift):
    return carried(x, shift)._replace(heading_rate=x.heading_rate + shift.heading)
