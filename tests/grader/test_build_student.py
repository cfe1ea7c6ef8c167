"""What a student's JupyterLab is told before it starts."""

import json
from pathlib import Path

import pytest

from grader.build_student import fresh_copy, jupyterlab


@pytest.fixture
def notebook(tmp_path):
    released = tmp_path / "release" / "02_heading"
    released.mkdir(parents=True)
    (released / "heading.ipynb").write_text("released")
    return fresh_copy(released, tmp_path / "student")


def test_a_students_work_is_not_overwritten(notebook, tmp_path):
    notebook.write_text("my answer")
    again = fresh_copy(tmp_path / "release" / "02_heading", tmp_path / "student")
    assert again.read_text() == "my answer"


def test_the_server_listens_on_this_computer_and_keeps_its_token(notebook, tmp_path):
    command, environment = jupyterlab(tmp_path / "student", notebook)
    folder = environment["JUPYTER_CONFIG_DIR"]
    settings = json.loads(Path(folder, "jupyter_server_config.json").read_text())
    assert settings["ServerApp"]["ip"] == "127.0.0.1"
    assert settings["LabApp"]["default_url"] == "/lab/tree/02_heading/heading.ipynb"
    assert not {"token", "password"} & (
        settings["ServerApp"].keys() | set(" ".join(command).split())
    )


def test_only_the_validate_panel_stays(notebook, tmp_path):
    _, environment = jupyterlab(tmp_path / "student", notebook)
    folder = environment["JUPYTER_CONFIG_DIR"]
    page = json.loads(Path(folder, "labconfig", "page_config.json").read_text())
    off = {name for name, is_off in page["disabledExtensions"].items() if is_off}
    assert {"@jupyter/nbgrader:create-assignment", "@jupyter/nbgrader:formgrader"} <= off
    assert "@jupyter/nbgrader:validate-assignment" not in off
    assert "@jupyterlab/apputils-extension:announcements" in off


def test_without_a_screen_no_browser_is_opened(notebook, tmp_path, monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert "--no-browser" in jupyterlab(tmp_path / "student", notebook)[0]
    monkeypatch.setenv("DISPLAY", ":0")
    assert "--no-browser" not in jupyterlab(tmp_path / "student", notebook)[0]
