"""Hard-code what is visible: the public cases, the seed, the stand-ins."""

from grader.attacks import answer, code

code(
    "copying",
    "remember_the_public_cases",
    "Record what the public checks expect, and play it back.",
    """
import numpy as np, uavlab, uavlab.exercises.spec as spec
memory = {}
def _spy(name):
    exercise = spec.find(name)
    def record(*arguments, **more):
        memory[name, repr(arguments)] = True
        raise ValueError
    for check in exercise.checks:
        try:
            check.run(record, np.random.default_rng(0))
        except Exception:
            pass
    def play(*arguments, **more):
        return float((name, repr(arguments)) in memory)
    return play
heading_rate, with_heading = _spy("heading_rate"), _spy("with_heading")
""",
)

answer(
    "copying",
    "borrow_from_the_library",
    "Look for a shipped function that does the same.",
    """
import inspect, pkgutil, importlib, uavlab
_found = []
for _module in pkgutil.walk_packages(uavlab.__path__, "uavlab."):
    try:
        _found += [f for _, f in inspect.getmembers(importlib.import_module(_module.name), inspect.isfunction)]
    except Exception:
        pass
def {name}(*arguments, **more):
    for function in _found:
        if function.__name__ == "{name}":
            return function(*arguments, **more)
    return 0.0
""",
)

answer(
    "copying",
    "constant_of_the_example",
    "The value of the lab's printed example, whatever the input.",
    """
def {name}(*arguments, **more):
    return 0.3
""",
)
