"""Hand-ins as they come: nothing that a student put there disappears without a word."""

from grader.handin import find_notebook, left_out, plain_name


def put(folder, *names):
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / name).write_text("{}")
    return folder


def test_the_notebook_of_the_right_name_is_taken_and_a_copy_beside_it_is_named(tmp_path):
    folder = put(tmp_path, "heading.ipynb", "heading-Copy1.ipynb")
    path, notes = find_notebook(folder, "heading")
    assert path.name == "heading.ipynb"
    assert notes == ["also there, not graded: 'heading-Copy1.ipynb'"]


def test_the_only_notebook_is_taken_whatever_the_browser_called_it(tmp_path):
    for name in ("heading (1).ipynb", "HEADING.IPYNB"):
        path, notes = find_notebook(put(tmp_path / name, name, "timestamp.txt"), "heading")
        assert path.name == name
        assert notes == [f"{name!r} was taken for heading.ipynb"]


def test_what_is_there_instead_of_a_notebook_is_named(tmp_path):
    path, notes = find_notebook(put(tmp_path, "heading.py", "heading.zip"), "heading")
    assert path.name == "heading.ipynb"
    assert notes == ["heading.ipynb is missing; there is 'heading.py', 'heading.zip'"]
    assert find_notebook(tmp_path / "none", "heading")[1] == []


def test_a_hand_in_beside_its_folder_is_left_out_with_the_cure(tmp_path):
    put(tmp_path / "ada" / "02_Heading", "heading.ipynb")
    put(tmp_path / "ben", "heading.ipynb")
    put(tmp_path / "cleo" / "02_heading", "heading.ipynb")
    (tmp_path / "notes.txt").write_text("")
    assert left_out(tmp_path, "02_heading", {"cleo"}) == [
        "submitted/ada/02_Heading should be called 02_heading",
        "submitted/ben holds 'heading.ipynb', which belongs into a folder 02_heading",
        "submitted/'notes.txt' is no folder of a student",
    ]


def test_a_name_that_nbgrader_refuses_gets_a_plain_one():
    assert plain_name("s 13 space") == "s-13-space"
    assert plain_name("muller-ü") == "muller-u"
    assert plain_name("...") == "student"
