"""Files that were made to stop the grader, or to make it read what is not the student's."""

import contextlib
import json
import threading

import pytest

from grader.coursework import _is_time
from grader.graft import NotANotebook, parse, read_bytes


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
