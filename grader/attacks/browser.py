"""HTML and scripts that would run in the browser of the person who grades."""

import json

from grader.attacks import Target, attack, filled, own

SCRIPT = "<script>document.title='canary_script'</script>"
PROSE = f"""# An answer
{SCRIPT}
<img src=x onerror="fetch('/formgrader/api/grade/1',{{method:'PUT'}})">
<IMG SRC="http://canary.invalid/pixel.png"> ![pixel](http://canary.invalid/pixel.png) ![pixel][ref]
[click](javascript:alert('canary_link')) [click][ref] <javascript:alert('canary_link')>
<iframe srcdoc="{SCRIPT}"></iframe> <svg/onload=alert(1)> <style>*{{display:none}}</style>
<a href="data:text/html,{SCRIPT}">x</a> <!-- --!><base href=//canary.invalid>
`<script>` ```<script>``` $<script>$ $$\\href{{javascript:alert(1)}}{{x}}<img src=x>$$
\\begin{{a}}<script>canary_script</script>\\end{{a}}

[ref]: javascript:alert('canary_link')

<details open ontoggle=alert(1)><table background=javascript:alert(1)>
&lt;script&gt; &#60;script&#62; <\u200bscript>
"""


@attack("browser")
def prose(target: Target) -> bytes:
    """Every question is answered by markup that runs, loads or follows."""
    notebook = filled(target, {})
    for cell in notebook["cells"]:
        if cell["id"].startswith("question-"):
            cell["source"] = PROSE
    notebook["cells"].append(own(PROSE, "markdown"))
    notebook["cells"].append({
        **own(PROSE, "raw"),
        "metadata": {"raw_mimetype": "text/html", "format": "text/html"},
    })
    return json.dumps(notebook).encode()


@attack("browser")
def outputs(target: Target) -> bytes:
    """Outputs and attachments that hold pages, scripts and pictures."""
    notebook = filled(target, {})
    data = {
        "text/html": SCRIPT,
        "application/javascript": "alert('canary_link')",
        "image/svg+xml": f"<svg>{SCRIPT}</svg>",
    }
    shown = {"output_type": "display_data", "metadata": {}, "data": data}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            cell["outputs"] = [shown]
        else:
            cell["attachments"] = {"a.svg": {"image/svg+xml": SCRIPT}}
    return json.dumps(notebook).encode()


@attack("browser")
def names_and_code(target: Target) -> bytes:
    """Markup in code, in ids, in metadata and in the notebook's title."""
    notebook = filled(target, {n: f"# {SCRIPT}\n'''</pre></div>{SCRIPT}'''" for n in target.right})
    notebook["metadata"] = {
        "title": SCRIPT,
        "widgets": {"x": SCRIPT},
        "language_info": {"name": SCRIPT, "pygments_lexer": SCRIPT},
    }
    notebook["cells"].append({
        **own(f"print('''{SCRIPT}''')"),
        "id": SCRIPT,
        "metadata": {"tags": [SCRIPT], "name": SCRIPT},
    })
    return json.dumps(notebook).encode()
