"""A small exercise that asks for a class: a first-order lag that counts its steps; and answers to it, good and bad."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from uavlab.exercises.spec import Function, exercise, expect_close
from uavlab.interfaces import Memory
from uavlab.types import Estimate, Hypothesis


@exercise(points=4, reads="MRS eq. (8)")
@dataclass(frozen=True)
class Lag:
    """A first-order lag.

    Parameters
    ----------
    tau : float
        Time constant [s].
    """

    tau: float  # [s]

    def init(self, x: np.ndarray) -> Memory:
        """Memory that starts at `x`, shape (3,)."""
        ...

    def step(self, memory: Memory, u: np.ndarray, dt: float) -> tuple[Memory, Estimate]:
        """One tick of `dt` [s] towards `u`, shape (3,)."""
        ...

    def reframe(self, memory: Memory, shift: np.ndarray) -> Memory:
        """The same memory, moved by `shift`, shape (3,)."""
        ...

    def hypotheses(self, memory: Memory) -> Mapping[str, Hypothesis]:
        """What is believed, by name."""
        ...


@Lag.check
def exact_decay(f: Function, rng: np.random.Generator) -> None:
    """After one time constant 1/e of the gap is left."""
    start = rng.normal(size=3)
    lag = f(tau=2.0)
    memory = lag.init(start)
    for _ in range(4):
        memory, said = lag.step(memory, np.zeros(3), 0.5)
    expect_close(said.r, start / np.e)


@Lag.check
def moved_along(f: Function, rng: np.random.Generator) -> None:
    """A memory that is moved is a memory of the moved lag, and the old one stays as it was."""
    start, shift, u = rng.normal(size=(3, 3))
    lag = f(0.7)
    memory = lag.init(start)
    moved = lag.reframe(memory=memory, shift=shift)
    here, there = lag.step(memory, u, 0.1)[1], lag.step(moved, u + shift, 0.1)[1]
    expect_close(there.r - here.r, shift)
    first = start + (u - start) * -np.expm1(-0.1 / 0.7)
    expect_close(here.r, first)


@Lag.check
def said_by_name(f: Function, rng: np.random.Generator) -> None:
    """What is believed is what was begun with."""
    start = rng.normal(size=3)
    lag = f(0.7)
    believed = lag.hypotheses(lag.init(start))["lag"]
    expect_close(believed.x[:, 0], start)
    expect_close(float(believed.reliable), 1.0)


RIGHT = '''
from __future__ import annotations
from collections.abc import Mapping
from dataclasses import dataclass
import numpy as np
from uavlab.interfaces import Memory
from uavlab.types import NO_SHIFT, Estimate, Hypothesis

ZERO = np.zeros(3)


@dataclass(frozen=True)
class Lag:
    """A lag."""

    tau: float  # [s]

    def init(self, x: np.ndarray) -> Memory:
        """Begin."""
        return x.copy()

    def step(self, memory: Memory, u: np.ndarray, dt: float) -> tuple[Memory, Estimate]:
        """One tick."""
        # the exact step
        x = memory + (u - memory) * self._share(dt)
        return x, Estimate(x, ZERO, ZERO, np.eye(3), ZERO, "lag", NO_SHIFT)

    def reframe(self, memory: Memory, shift: np.ndarray) -> Memory:
        """Move."""
        return memory + shift

    def hypotheses(self, memory: Memory) -> Mapping[str, Hypothesis]:
        """By name."""
        x = np.column_stack((memory, ZERO, ZERO))
        return {"lag": Hypothesis(x, np.zeros((3, 3, 3)), np.zeros(2), np.eye(2), 1.0, True)}

    def _share(self, dt: float) -> float:
        return -np.expm1(-dt / self.tau)
'''
EXACT = "memory + (u - memory) * self._share(dt)"


def changed(old: str, new: str) -> str:
    """The right answer with something else in it."""
    assert old in RIGHT
    return RIGHT.replace(old, new)


def made(source: str) -> type:
    """The class of an answer."""
    room: dict = {"__name__": "__main__"}
    exec(compile(source, "<answer>", "exec", dont_inherit=True), room)
    return room["Lag"]


IN_PLACE = changed(EXACT, "memory; x += (u - x) * self._share(dt)")
GLOBAL = changed(
    "x = " + EXACT, "global LAST; LAST = x = LAST + (u - LAST) * self._share(dt)"
).replace("return x.copy()", "global LAST; LAST = x.copy()")
NO_TUPLE = changed("return x, Estimate", "return Estimate")
HANGS = changed("        # the exact step", "        while True: pass")
DIES = changed("        # the exact step", "        import os; os._exit(0)")
DIES_ONCE = changed(
    "return memory + shift",
    "import os\n        if shift[0] > 0: os._exit(0)\n        return memory + shift",
)
HOARDS = changed("return x.copy()", "return x.copy(), bytearray(3 * 2**30)")
BIG_OUTPUT = changed("return x, Estimate", "return x, np.zeros(10**7), Estimate")
ODD = changed("return x, Estimate", "return x, lambda: Estimate")
LIES = """
class Meta(type):
    def __eq__(self, other): return True
    __hash__ = None
    def __instancecheck__(self, other): return True
class Lag(metaclass=Meta):
    passed, score, points = True, 100, 100
    def __init__(self, *a, **k): pass
    def __getattr__(self, name): return lambda *a, **k: (self, self)
    def __eq__(self, other): return True
    def __float__(self): return 0.0
    def __array__(self, *a, **k): return __import__("numpy").zeros(3)
    def __iter__(self): return iter((self, self))
"""
FORGES = '''
import gc, sys, grader.worker
class Lag:
    """Swaps what the worker keeps, and gives numbers for memories."""
    def __init__(self, *a, **k): pass
    def init(self, x): return 1
    def step(self, memory, u, dt):
        frame = sys._getframe()
        while frame and "message" not in frame.f_locals: frame = frame.f_back
        frame.f_locals["message"]["store"] = None
        for thing in gc.get_objects():
            if isinstance(thing, grader.worker.Namespace):
                for number in range(1000): thing.held[number] = self
        return {"h": 3}, {"h": 1}
    def reframe(self, memory, shift): return {"h": 2}
    def hypotheses(self, memory): return {"lag": {"h": 1}}
'''
WORTHLESS = {"lies": LIES, "forges": FORGES}
