"""Forged, stale, oversized, deeply nested, NaN, wrong-dtype and wrong-shape replies."""

from grader.attacks import answer, code

FD = """
import json, os, struct
def _send(message):
    body = message if isinstance(message, bytes) else json.dumps(message).encode()
    for fd in range(3, 64):
        try:
            os.write(fd, struct.pack(">I", len(body)) + body)
        except OSError:
            pass
"""

answer(
    "forging",
    "forged_reply",
    "Write a verdict and a reply to the judge's channel, with a guessed nonce.",
    FD
    + """
def {name}(*arguments, **more):
    for nonce in ("", "0", "0" * 16):
        _send({"nonce": nonce, "value": 0.0, "passed": True, "score": 100, "points": 100})
    return 0.0
""",
)

answer(
    "forging",
    "stale_reply",
    "Answer twice, so that the second reply meets the next request.",
    FD
    + """
import sys
def {name}(*arguments, **more):
    frame = sys._getframe()
    while frame and "message" not in frame.f_locals:
        frame = frame.f_back
    _send({"nonce": frame.f_locals["message"]["nonce"], "value": 0.0})
    return 0.0
""",
)

answer(
    "forging",
    "half_a_frame",
    "Announce a frame of 4 GiB and send a little of it for ever.",
    """
import os, struct, time
def {name}(*arguments, **more):
    for fd in range(3, 64):
        try:
            os.write(fd, struct.pack(">I", 2**32 - 1) + b"[" * 1000)
        except OSError:
            pass
    time.sleep(60)
""",
)

answer(
    "forging",
    "deeply_nested",
    "A reply nested so deep that reading it crashes.",
    FD
    + """
import sys
def {name}(*arguments, **more):
    frame = sys._getframe()
    while frame and "message" not in frame.f_locals:
        frame = frame.f_back
    nonce = frame.f_locals["message"]["nonce"]
    _send(b'{"nonce": "' + nonce.encode() + b'", "value": ' + b"[" * 500_000 + b"]" * 500_000 + b"}")
    os._exit(0)
""",
)

answer(
    "forging",
    "hostile_array",
    "Arrays whose dtype, shape and data lie.",
    FD
    + """
import sys, itertools
_turn = itertools.count()
_bad = [["O", [1], "AAAAAAAAAAA="], ["<f8", [2**40], ""], ["<f8", [-1], ""], ["<f8", [1] * 64, "AAAAAAAAAAA="],
        ["V8", [1], "AAAAAAAAAAA="], ["<f8", "x", 3], ["<f8,<O", [1], ""], None]
def {name}(*arguments, **more):
    frame = sys._getframe()
    while frame and "message" not in frame.f_locals:
        frame = frame.f_back
    nonce = frame.f_locals["message"]["nonce"]
    _send({"nonce": nonce, "value": {"a": _bad[next(_turn) % len(_bad)]}})
    os._exit(0)
""",
)

answer(
    "forging",
    "not_a_number",
    "NaN and infinity, which no tolerance can tell from anything.",
    """
import itertools
_turn = itertools.cycle([float("nan"), float("inf"), -float("inf"), complex("nan"), None, "0", True, [], {}])
def {name}(*arguments, **more):
    return next(_turn)
""",
)

answer(
    "forging",
    "wrong_shapes",
    "Shapes that broadcast against the expected one.",
    """
import numpy as np, itertools
_turn = itertools.cycle([np.zeros((0,)), np.zeros((0, 3, 3)), np.zeros((1, 1, 1)), np.ma.masked_all(3), np.empty(3, object)])
def {name}(*arguments, **more):
    return next(_turn)
""",
)

answer(
    "forging",
    "huge_answer",
    "An answer of a hundred megabytes, and one that never ends.",
    """
import numpy as np
class Endless(list):
    def __iter__(self):
        while True:
            yield 0.0
_turn = [0]
def {name}(*arguments, **more):
    _turn[0] += 1
    return np.zeros(12_000_000) if _turn[0] % 2 else Endless([1])
""",
)

answer(
    "forging",
    "pickled",
    "Objects that execute code where they are unpacked.",
    """
import pickle
class Bomb:
    def __reduce__(self): return (exec, ("open('/tmp/pwned', 'w').write('x')",))
class StateRate(tuple):
    _fields = ("__class__", "__init__")
def {name}(*arguments, **more):
    return StateRate((Bomb(), pickle.dumps(Bomb())))
""",
)

code(
    "forging",
    "rewrite_the_worker",
    "Replace the worker's own functions: say that everything was kept and is zero.",
    """
import grader.worker, grader.protocol
grader.worker.Namespace.keep = lambda self, name: True
grader.worker.Namespace.call = lambda self, name, arguments: {"value": 0.0, "score": 1, "passed": True}
grader.protocol.encode = lambda value, arrays: {"a": ["<f8", [], "AAAAAAAAAAA="]}
""",
)

code(
    "forging",
    "argue_by_name",
    "Answers that are classes, generators and coroutines instead of functions.",
    """
class heading_rate:
    def __new__(cls, *a, **k): return object.__new__(cls)
    def __eq__(self, other): return True
async def with_heading(*a, **k): return 0
def attitude_by_projection(*a, **k): yield 0
""",
)
