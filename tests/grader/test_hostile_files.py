"""Files that were made to stop the grader, or to make it read what is not the student's."""

import contextlib
import errno
import json
import threading

import pytest

from grader import sandbox
from grader.coursework import _is_time
from grader.graft import MAX_CELLS, NotANotebook, graft_file, parse, read_bytes
from grader.mark import Options, mark
from grader.remote import MAX_FAULTS, Remote, Step, TookTooLong
from grader.sandbox import Limits
from uavlab.exercises import exercises


def test_a_notebook_of_nothing_but_cells_is_refused_before_it_is_unpacked():
    bomb = b'{"nbformat":4,"cells":[' + b"{}," * 400_000 + b"{}]}"
    with pytest.raises(NotANotebook, match="more than 300000 parts"):
        parse(bomb)


def test_an_empty_file_is_called_empty():
    with pytest.raises(NotANotebook, match="empty"):
        parse(b" \n")


def test_a_folder_that_becomes_a_link_while_it_is_read_never_shows_what_is_behind(tmp_path):
    submitted, secret = tmp_path / "submitted", tmp_path / "source"
    mine, other = submitted / "me" / "lab", submitted / "me" / "other"
    for folder, text in ((mine, "mine"), (secret, "secret")):
        folder.mkdir(parents=True)
        (folder / "lab.ipynb").write_text(json.dumps(text))
    other.symlink_to(secret)
    stop = threading.Event()

    def swap():
        spare = submitted / "me" / "spare"
        while not stop.is_set():
            mine.rename(spare)
            other.rename(mine)
            mine.rename(other)
            spare.rename(mine)

    swapper = threading.Thread(target=swap)
    swapper.start()
    try:
        for _ in range(300):
            with contextlib.suppress(NotANotebook):
                assert read_bytes(mine / "lab.ipynb", submitted) == b'"mine"'
    finally:
        stop.set()
        swapper.join()


@pytest.mark.parametrize(
    ("said", "good"),
    [
        (b"2027-02-28 20:15:00 UTC", True),
        (b"2015-02-02 15:58:23.948203 UTC\n", True),
        (b"::::::::::", False),
        (b"--------", False),
        (b"tomorrow", False),
    ],
)
def test_only_a_time_that_nbgrader_can_read_is_passed_on(said, good):
    assert _is_time(said) is good


def test_a_notebook_of_too_many_cells_is_refused_and_does_not_stop_the_grader(tmp_path):
    submitted = tmp_path / "submitted"
    path = submitted / "me" / "lab" / "lab.ipynb"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps({"nbformat": 4, "cells": [{}] * (MAX_CELLS + 1)}))
    made = graft_file({"metadata": {}, "cells": []}, path, submitted)
    assert not made.readable
    assert "2001 cells" in made.notes[0]


def test_a_file_that_takes_all_memory_costs_its_own_student_only(tmp_path, monkeypatch):
    path = tmp_path / "me" / "lab.ipynb"
    path.parent.mkdir()
    path.write_text('{"nbformat": 4, "cells": [{}]}')

    def full(_):
        raise MemoryError

    monkeypatch.setattr("grader.graft._plain", full)
    made = graft_file({"metadata": {}, "cells": []}, path, tmp_path)
    assert not made.readable
    assert "too much memory" in made.notes[0]


def test_a_student_is_told_the_reason_of_their_own_file_and_not_that_of_an_earlier_one(tmp_path):
    exercise = exercises("heading")[0]
    mark_of = {"grade_id": f"check-{exercise.name}", "grade": True, "points": exercise.points}
    check = {"cell_type": "code", "id": "c", "source": "", "metadata": {"nbgrader": mark_of}}
    release = {"metadata": {}, "cells": [check]}
    for student, file in (("one", b"\n"), ("two", b"{")):
        path = tmp_path / "submitted" / student / "lab.ipynb"
        path.parent.mkdir(parents=True)
        path.write_bytes(file)
        made = graft_file(release, path, tmp_path / "submitted")
        marks = mark(made.notebook, Options(cache=tmp_path / "marks"))
        said = " ".join(marks.checks[f"check-{exercise.name}"]["text"].split())
        assert ("the file is empty" in said) is (student == "one")
        assert ("cut short" in said) is (student == "two")
    assert mark(made.notebook, Options(cache=tmp_path / "marks")).kept


@pytest.mark.usefixtures("isolation")
def test_an_answer_that_raises_timeout_error_is_not_taken_for_a_late_one():
    source = "def f(x):\n    while x: pass\n    raise TimeoutError('mine')"
    with Remote([Step(0, source), Step(1, keep="f")], Limits(call=0.3)) as remote:
        answer = remote.answer("f")
        for _ in range(MAX_FAULTS + 1):
            with pytest.raises(TimeoutError) as raised:
                answer(0)
            assert type(raised.value) is TimeoutError
        assert answer.faults == []
        with pytest.raises(TookTooLong, match=r"0\.3 s"):
            answer(1)
        assert len(answer.faults) == 1
    assert not issubclass(TookTooLong, ValueError)


@pytest.mark.usefixtures("isolation")
@pytest.mark.parametrize(
    "call",
    [
        "os.mkdir('/tmp/d')",
        "os.symlink('/x', '/tmp/l')",
        "os.link('/dev/null', '/tmp/h')",
        "__import__('fcntl').flock(os.open('/tmp', 0), 2)",
    ],
)
def test_the_box_refuses_calls_that_fill_the_kernel_or_wait_in_it(call):
    source = f"import os\ndef f():\n    try:\n        {call}\n    except OSError as e:\n        return e.errno"
    with Remote([Step(0, source), Step(1, keep="f")], Limits()) as remote:
        assert remote.answer("f")() == errno.EPERM


@pytest.mark.usefixtures("isolation")
@pytest.mark.parametrize("below", ["lib/python3.11/site-packages", "python3/dist-packages", ""])
def test_solutions_that_are_installed_a_second_time_cannot_be_read_either(
    tmp_path, monkeypatch, below
):
    shown = tmp_path / "shown"
    for secret in ("uavlab/solutions/heading.py", "grader/hidden/heading.py"):
        path = shown / below / secret
        path.parent.mkdir(parents=True)
        path.write_text("answer = 42")
    (shown / below / "open.py").write_text("x = 'shown'")
    usual = sandbox._interpreter()
    monkeypatch.setattr(sandbox, "_interpreter", lambda: [*usual, shown])
    source = "def f(path):\n    return len(open(path).read())"
    with Remote([Step(0, source), Step(1, keep="f")], Limits()) as remote:
        answer = remote.answer("f")
        assert answer(str(shown / below / "open.py")) > 0  # the folder itself is there
        for secret in ("uavlab/solutions/heading.py", "grader/hidden/heading.py"):
            with pytest.raises(OSError):  # noqa: PT011  (without the text of the student's process)
                answer(str(shown / below / secret))
