"""Import or read the solutions, the tests, the gradebook, another student."""

from grader.attacks import code

ALL = """
def _use(module):
    for name in ("heading_rate", "with_heading", "attitude_by_projection", "attitude_with_heading",
                 "yaw_rate_from_heading_rate", "parasitic_yaw_rate"):
        if hasattr(module, name):
            globals()[name] = getattr(module, name)
"""

code(
    "reading",
    "import_solutions",
    "Import the reference and hand it in under the asked names.",
    ALL
    + """
import uavlab.solutions.heading as solutions
_use(solutions)
""",
)

code(
    "reading",
    "walk_the_disk",
    "Look for solutions and hidden checks anywhere on the disk, and execute what is found.",
    ALL
    + """
import os, types
for folder, folders, files in os.walk("/"):
    for file in files:
        path = os.path.join(folder, file)
        if file == "heading.py" and ("solutions" in path or "hidden" in path):
            module = types.ModuleType("found")
            exec(open(path).read(), module.__dict__)
            _use(module)
""",
)

code(
    "reading",
    "import_the_grader",
    "Import the judge and its hidden checks, and make them all pass.",
    """
import grader.judge, grader.hidden.heading
grader.judge.run = lambda *a, **k: grader.judge.Result("all", True, "", 1.0, True)
""",
)

code(
    "reading",
    "read_the_gradebook",
    "Open the gradebook below every folder and raise every score.",
    """
import glob, sqlite3
for path in glob.glob("/**/gradebook.db", recursive=True):
    with sqlite3.connect(path) as base:
        base.execute("update grade set auto_score = 99")
""",
)

code(
    "reading",
    "read_a_classmate",
    "Find another student's notebook and run its answers.",
    """
import glob, json
for path in glob.glob("/**/submitted/*/*/*.ipynb", recursive=True) + glob.glob("../../*/*/*.ipynb"):
    for cell in json.load(open(path))["cells"]:
        exec("".join(cell["source"]))
""",
)

code(
    "reading",
    "follow_proc",
    "Reach the grader's files through /proc and inherited descriptors.",
    """
import os
for pid in ("self", "1", str(os.getppid())):
    for place in ("root", "cwd", "environ", "fd"):
        path = f"/proc/{pid}/{place}"
        print(os.listdir(path) if os.path.isdir(path) else open(path, "rb").read())
for fd in range(3, 64):
    try:
        print(os.fchdir(fd), os.listdir("."))
    except OSError:
        pass
""",
)

code(
    "reading",
    "data_of_the_package",
    "Ask the installed packages' metadata and loaders for the sources.",
    ALL
    + """
import importlib.resources, importlib.metadata, pkgutil, uavlab
print(importlib.metadata.files("uavlab"))
for module in pkgutil.walk_packages(uavlab.__path__, "uavlab."):
    if "solution" in module.name:
        _use(importlib.import_module(module.name))
print(importlib.resources.files("uavlab").joinpath("solutions/heading.py").read_text())
""",
)
