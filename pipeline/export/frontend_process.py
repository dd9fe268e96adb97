"""rumoca in a process of its own: whatever a model does to it, a crash, a panic or an endless loop, ends in one line.

Run as a script, `frontend_process.py FILE MODEL`, it prints a JSON object: `dae` and `flat`, or `error`. Libraries are
searched in the folders of MODELICAPATH (Modelica language specification 3.6, section 13.5).
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

PATIENCE = 120.0  # s
SYNTAX = re.compile(r"× (?P<what>[^\n]*)\n\s*╭─\[(?P<file>[^\n]*):(?P<line>\d+):\d+\]")
FAILURE = re.compile(r"^- .*?\[\w+\]: (?P<what>.*)$", re.MULTILINE)
SPAN = re.compile(r", span: Span \{.*\}")


def compile_model(path: Path, model: str) -> dict[str, Any]:
    """`dae` and `flat` of a model in a .mo file, or `error`: one line that says why there are none."""
    command = [sys.executable, "-P", __file__, str(path), model]
    try:
        done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        return {"error": f"no answer within {PATIENCE:g} s: make the model smaller until it answers"}
    if done.returncode == 0:
        return json.loads(done.stdout)
    why = "redeclare model extends is known to do that" if done.returncode < 0 else done.stderr.strip()[-200:]
    return {"error": f"it crashed (exit code {done.returncode}): {' '.join(why.split())}"}


def answer(path: str, model: str) -> dict[str, Any]:
    """What the front end makes of a model, in this process."""
    import rumoca

    roots = [root for root in os.environ.get("MODELICAPATH", "").split(os.pathsep) if root]
    try:
        compiled = rumoca.Session(roots).load(path, model=model)
        return {"dae": compiled.to_dict("dae"), "flat": compiled.to_dict("flat")}
    except rumoca.RumocaError as error:
        return {"error": syntax_error(Path(path)) or shorten(str(error))}
    except BaseException as error:  # a panic of its Rust code is no Exception
        return {"error": f"{type(error).__name__}: {shorten(SPAN.sub('', str(error)))}"}


def shorten(text: str) -> str:
    """The failures that a message lists, else the message, on one line."""
    failures = dict.fromkeys(found["what"] for found in FAILURE.finditer(text))
    return "; ".join(failures) if failures else " ".join(text.split())


def syntax_error(path: Path) -> str | None:
    """The first syntax error in the file, or in the package whose package.mo it is."""
    import rumoca

    files = sorted(path.parent.rglob("*.mo")) if path.name == "package.mo" else [path]
    for file in files:
        for diagnostic in rumoca.validate(str(file)):
            found = SYNTAX.search(diagnostic.message)
            if found:
                return f"syntax error: {found['what']} ({found['file']}:{found['line']})"
    return None


if __name__ == "__main__":
    print(json.dumps(answer(*sys.argv[1:])))
