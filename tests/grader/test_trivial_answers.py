"""Trivial answers, and answers learnt from the public checks, earn nothing."""

import numpy as np
import pytest
from answers import reference, through

from grader.judge import judge
from uavlab.exercises import all_exercises

each = pytest.mark.parametrize("x", list(all_exercises()), ids=lambda x: x.name)


class Equal:
    """Equal to everything, and as large, and as small."""

    def __eq__(self, other):
        return True

    __lt__ = __gt__ = __le__ = __ge__ = __eq__
    __hash__ = None

    def __array__(self, dtype=None, copy=None):
        return np.zeros(())


class Liar(np.ndarray):
    """Numbers that say they are right."""

    def __eq__(self, other):
        return True

    def __array_function__(self, *args, **kwargs):
        return True

    def __array_ufunc__(self, *args, **kwargs):
        return np.zeros(())


def like(right, make):
    """The shape of the right answer, filled with something else."""
    if right is None or isinstance(right, str):
        return right and ""
    if isinstance(right, tuple):
        fields = [like(field, make) for field in right]
        return type(right)(*fields) if hasattr(right, "_fields") else tuple(fields)
    if isinstance(right, dict):
        return {name: like(field, make) for name, field in right.items()}
    return make(np.asarray(right))


def changed(hook):
    """An answer of which every result is changed; of a class, the memories stay right."""
    return lambda x: through(x, reference(x), hook)


def same_always(value):
    either = changed(lambda ask, text, args: value)
    return lambda x: either(x) if x.is_class else lambda *args, **kwargs: value


def filled(make):
    return changed(lambda ask, text, args: like(ask(), make))


def an_argument(index):
    return changed(lambda ask, text, args: args[index % len(args)] if args else None)


def raising(kind):
    def refuse(ask, text, args):
        raise kind("no")

    return changed(refuse)


TRIVIAL = {
    "zeros": filled(lambda a: np.zeros(a.shape)),
    "ones": filled(lambda a: np.ones(a.shape)),
    "huge": filled(lambda a: np.full(a.shape, 1e300)),
    "nan": filled(lambda a: np.full(a.shape, np.nan)),
    "infinite": filled(lambda a: np.full(a.shape, np.inf)),
    "liar": filled(lambda a: np.zeros(a.shape).view(Liar)),
    "wrong shape": filled(lambda a: a[None]),
    "as text": filled(lambda a: a.astype(str)),
    "as objects": filled(lambda a: a.astype(object)),
    "complex": filled(lambda a: a + 1j),
    "identity": same_always(np.eye(3)),
    "nothing": same_always(None),
    "text": same_always("0.0"),
    "zero": same_always(0.0),
    "equal to everything": same_always(Equal()),
    "the first argument": an_argument(0),
    "the second argument": an_argument(1),
    "the last argument": an_argument(-1),
    "raises": raising(ValueError),
    "raises what checks raise": raising(AssertionError),
    "cannot be called so": lambda x: lambda: 0.0,
}


QUICK = ("zeros", "nan", "nothing", "raises")  # of a class, which flies in its checks

each_kind = pytest.mark.parametrize(
    ("x", "kind"),
    [
        pytest.param(
            x,
            kind,
            id=f"{kind}-{x.name}",
            marks=[pytest.mark.slow] if x.is_class and kind not in QUICK else [],
        )
        for x in all_exercises()
        for kind in TRIVIAL
    ],
)


@each_kind
def test_a_trivial_answer_earns_nothing(x, kind):
    verdict = judge(x, TRIVIAL[kind](x), 7)
    assert verdict.score == 0.0, [r.name for r in verdict.results if r.passed and r.weight]
    assert verdict.finished
    assert verdict.hint


@each
def test_answers_learnt_from_the_public_checks_earn_nothing(x):
    """What `check` of the student and the paper's examples ever asked, answered by heart."""
    known = {}

    def learn(ask, text, args):
        known[text] = said = ask()
        return said

    for item in x.checks:
        for seed in range(5):
            item.run(through(x, reference(x), learn), np.random.default_rng(seed))
    blank = next(said for said in known.values() if said is not None)
    by_heart = through(x, reference(x), lambda ask, text, args: known.get(text, blank))
    assert judge(x, by_heart, 11).score == 0.0
