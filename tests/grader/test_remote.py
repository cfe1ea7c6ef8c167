"""Student code in the box: it answers, it fails, it hangs; and it cannot see or touch what is outside."""

from __future__ import annotations

import time

import numpy as np
import pytest

from grader import sandbox
from grader.remote import ProcessEnded, Raised, Remote, Step
from grader.sandbox import Limits
from uavlab.errors import BadInput
from uavlab.types import State, StateRate

pytestmark = pytest.mark.usefixtures("isolation")
QUICK = Limits(call=0.5, cell=1.5, submission=6.0)


def _remote(source: str, *names: str, limits: Limits = QUICK) -> Remote:
    steps = [Step(0, source=source), *(Step(i, keep=n) for i, n in enumerate(names, 1))]
    return Remote(steps, limits)


def test_an_answer_gets_records_and_gives_records():
    source = """
from uavlab.types import StateRate
def f(state, force, *, m):
    return StateRate(state.v, force / m, state.R, state.omega)
"""
    state = State(np.zeros(3), np.arange(3.0), np.eye(3), np.ones(3))
    with _remote(source, "f") as remote:
        got = remote.answer("f")(state, np.ones(3), m=2.0)
    assert type(got) is StateRate
    assert np.array_equal(got.r_dot, state.v)
    assert np.array_equal(got.v_dot, np.full(3, 0.5))


def test_a_change_that_a_call_makes_to_its_arguments_is_seen_outside():
    given = np.zeros(3)
    with _remote("def f(x):\n    x[1] = 5\n    return 0", "f") as remote:
        remote.answer("f")(given)
    assert np.array_equal(given, [0, 5, 0])


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        ("ValueError('secret')", ValueError),
        ("NotImplementedError('secret')", NotImplementedError),
        ("uavlab.errors.BadInput('secret')", BadInput),
        ("uavlab.errors.CheckFailed('secret')", Raised),
        ("uavlab.errors.UnknownName('secret', 'secret', [])", LookupError),
        ("type('secret', (Exception,), {})()", Raised),
        ("type('secret', (KeyError,), {})('secret')", KeyError),
        ("SystemExit('secret')", Raised),
        ("KeyboardInterrupt('secret')", Raised),
    ],
)
def test_an_error_crosses_by_class_and_without_its_text(error, kind):
    source = f"import uavlab.errors\ndef f():\n    raise {error}"
    with _remote(source, "f") as remote, pytest.raises(kind) as caught:
        remote.answer("f")()
    assert type(caught.value) is kind
    assert "secret" not in str(caught.value) + repr(caught.value)


def test_a_hang_costs_its_call_and_the_next_call_works():
    source = "def f(x):\n    while x: pass\n    return 1"
    with _remote(source, "f") as remote:
        answer = remote.answer("f")
        began = time.monotonic()
        with pytest.raises(TimeoutError, match=r"0\.5 s"):
            answer(1)
        assert time.monotonic() - began < 3
        assert answer(0) == 1


def test_an_exit_costs_its_call_and_the_next_call_works():
    source = "import os\ndef f(x):\n    if x: os._exit(0)\n    return 1"
    with _remote(source, "f") as remote:
        answer = remote.answer("f")
        with pytest.raises(ProcessEnded):
            answer(1)
        assert answer(0) == 1


def test_an_answer_that_hangs_twice_is_not_called_again():
    with _remote("def f():\n    while True: pass", "f") as remote:
        answer = remote.answer("f")
        for _ in range(2):
            with pytest.raises(TimeoutError):
                answer()
        began = time.monotonic()
        with pytest.raises(TimeoutError, match="not called again"):
            answer()
        assert time.monotonic() - began < 0.1


def test_a_cell_that_ends_the_process_is_left_out_and_the_others_count():
    steps = [Step(0, source="x = 2"), Step(1, source="import os; os._exit(0)")]
    steps += [Step(2, source="def f(): return x"), Step(3, keep="f"), Step(4, source="1 / 0")]
    with Remote(steps, QUICK) as remote:
        assert remote.answer("f")() == 2
        assert "ended the process" in remote.faults[1]
        assert remote.faults[4] == "stopped with ZeroDivisionError in line 1"


def test_a_busy_machine_that_imports_slowly_costs_no_student_anything():
    slow = Step(0, source="import time; time.sleep(0.6); x = 2", ours=True)
    steps = [slow, Step(1, source="def f(): return x"), Step(2, keep="f")]
    with Remote(steps, Limits(cell=0.3, submission=5.0)) as remote:
        assert remote.answer("f")() == 2
        assert remote.faults == {}
        assert remote.left > 4.5


def test_the_whole_submission_has_a_budget():
    steps = [Step(i, source="while True: pass") for i in range(20)]
    began = time.monotonic()
    with Remote(steps, Limits(call=0.3, cell=0.5, submission=2.0)) as remote:
        assert remote.left == 0.0
        with pytest.raises(TimeoutError, match="used up"):
            remote.answer("f")()
    assert time.monotonic() - began < 8  # the cells alone ask for ten seconds


def test_what_an_answer_prints_goes_nowhere_and_warnings_do_not_matter(capfd):
    source = """
import os, sys, warnings
def f():
    print("out"); os.write(1, b"out"); os.write(2, b"err"); warnings.warn("careful")
    return 1
"""
    with _remote(source, "f") as remote:
        assert remote.answer("f")() == 1
    assert capfd.readouterr() == ("", "")


def test_an_answer_kept_at_its_check_survives_a_later_cell_of_the_same_name():
    steps = [Step(0, source="def f(): return 1"), Step(1, keep="f"), Step(2, source="f = None")]
    with Remote(steps, QUICK) as remote:
        assert remote.answer("f")() == 1


def test_plots_and_magics_cost_nothing_and_answers_below_them_count():
    from grader.magics import Translator

    source = """%matplotlib inline
import matplotlib.pyplot as plt, meshcat
from IPython.display import HTML, display
import matplotlib.animation
fig, (a, b, c) = plt.subplots(3, 1)
a.plot([1], label="x").set(xlim=(0, 1)); display(HTML("x")); plt.show()
def f(): return 1
"""
    with _remote(Translator().python(source), "f") as remote:
        assert remote.faults == {}
        assert remote.answer("f")() == 1
    timed = Translator().python("%%time\ndef f(): return 2")
    with _remote(timed, "f") as remote:
        assert remote.answer("f")() == 2


VIEW = """
import os, uavlab
def seen(place):
    try:
        return len(os.listdir(place))
    except OSError:
        return -1
def solutions():
    import uavlab.solutions.heading
def write(place):
    with open(place, "w") as file:
        file.write("x")
    return 1
def fork(): os.fork()
def thread():
    import threading
    threading.Thread(target=print).start()
def run(): os.execv("/usr/bin/env", ["env"])
def connect():
    import socket
    socket.create_connection(("127.0.0.1", 22), 0.2)
def user(): return [os.getuid(), os.geteuid(), len(os.environ), "PATH" in os.environ]
"""
NAMES = ("seen", "solutions", "write", "fork", "thread", "run", "connect", "user")


@pytest.fixture(scope="module")
def view(isolation):
    """A look around from inside."""
    with _remote(VIEW, *NAMES, limits=Limits()) as remote:
        yield remote


def test_the_box_has_no_solutions_no_course_no_home_and_no_proc(view):
    library = sandbox._library()
    for place in (
        library.parent / "course",
        library.parent / "tests",
        library / "solutions",
        "/proc",
        "/home",
        "/sys",
    ):
        assert view.answer("seen")(str(place)) <= 0, place
    assert view.answer("seen")("/box/uavlab/solutions") <= 0
    assert sorted(p.name for p in [library / "types.py"] if p.exists()) == ["types.py"]
    with pytest.raises(ModuleNotFoundError):
        view.answer("solutions")()


def test_only_tmp_can_be_written_and_it_forgets(view):
    for place in ("/x", "/usr/lib/x", "/box/uavlab/types.py", "/dev/x"):
        with pytest.raises(OSError):  # noqa: PT011  (which one differs by kernel)
            view.answer("write")(place)
    before = view.answer("seen")("/tmp")  # not empty where the checkout lies below /tmp
    assert view.answer("write")("/tmp/x") == 1
    assert view.answer("seen")("/tmp") == before + 1
    with _remote(VIEW, "seen") as other:
        assert other.answer("seen")("/tmp") == before


@pytest.mark.parametrize("name", ["fork", "thread", "run", "connect"])
def test_no_process_thread_program_or_connection_can_be_started(view, name):
    with pytest.raises((PermissionError, RuntimeError, OSError)):
        view.answer(name)()


def test_the_user_inside_is_nobody_and_the_environment_is_ours(view, monkeypatch):
    uid, effective, count, path = view.answer("user")()
    assert uid == effective
    assert uid >= 61_000
    assert path
    assert count <= len(sandbox._ENVIRONMENT) + 3  # bwrap and the C library add PWD and their own


def test_memory_has_a_limit():
    with (
        _remote("def f(): return len(bytearray(3 * 2**30))", "f") as remote,
        pytest.raises(MemoryError),
    ):
        remote.answer("f")()


def test_a_call_costs_well_below_a_millisecond():
    with _remote("def f(R, w): return R @ w", "f", limits=Limits()) as remote:
        answer, R, w = remote.answer("f"), np.eye(3), np.ones(3)
        times = []
        for _ in range(300):
            began = time.perf_counter()
            answer(R, w)
            times.append(time.perf_counter() - began)
    assert np.median(times) < 1e-3  # about 200 µs; a busy machine is slower


def test_without_bubblewrap_nothing_is_graded_and_the_cure_is_named(monkeypatch):
    monkeypatch.setattr(sandbox.shutil, "which", lambda name: None)
    sandbox.available.cache_clear()
    try:
        with pytest.raises(sandbox.SandboxMissing, match="apt-get install bubblewrap"):
            _remote("", "f").__enter__()
    finally:
        sandbox.available.cache_clear()


def test_a_box_that_cannot_start_is_explained_with_the_ubuntu_cure():
    said = sandbox._cure("bwrap: setting up uid map: Permission denied")
    assert "AppArmor" in said
    assert "apparmor" in said


def test_the_empty_tmp_comes_first_so_that_a_checkout_below_tmp_can_be_graded():
    command = sandbox.command(Limits(), 0)
    empty = [i for i, x in enumerate(command) if x == "--tmpfs" and command[i + 1] == "/tmp"]
    assert len(empty) == 1
    assert empty[0] < command.index("--ro-bind")
