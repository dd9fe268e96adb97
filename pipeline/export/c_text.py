"""CasADi's C code as the wrapper wants it: without what it has no use for, remembering, in parts that compile fast."""

from __future__ import annotations

import re
from itertools import count

LONG, PART = 1500, 120  # lines of a function that is cut, and of its parts: compilers take longer than in proportion
# functions of one argument, as C calls them
ELEMENTARY = "sin|cos|tan|asin|acos|atan|sinh|cosh|tanh|exp|log|log10"
# what CasADi tells its own importer of each function
INFORMATION = re.compile(
    r"^static const casadi_int casadi_s\d+\[\d+\] = \{[^}]*\};\n|"
    r"^(CASADI_SYMBOL_EXPORT )?[\w* ]+ model_\w+_(checkout|release|incref|decref|n_in|n_out|default_in|name_in|"
    r"name_out|sparsity_in|sparsity_out|work|work_bytes)\(.*?\}\n\n",
    re.MULTILINE | re.DOTALL,
)
FUNCTION = re.compile(
    r"^static int (?P<name>casadi_f\d+)\((?P<parameters>.*)\) \{\n(?P<variables>(  casadi_real a.*\n)+)"
    r"(?P<body>(.*\n)*?)  return 0;\n\}\n",
    re.MULTILINE,
)
PARAMETERS = "const casadi_real** arg, casadi_real** res, casadi_real* w, casadi_real* restrict a"


def lean(code: str) -> tuple[str, int]:
    """The functions without what the wrapper has no use for, and how many results they recall (see wrapper/model.h).

    The wrapper hands over every argument and takes every result: no test whether they are there.
    """
    code = INFORMATION.sub("", code)
    code = re.sub(r"arg\[(\d+)\]\? (arg\[\1\]\[\d+\]) : 0", r"\2", code)
    code = re.sub(r"if \(res\[\d+\]!=0\) ", "", code)
    code = re.sub(r"^casadi_real casadi_", "static inline casadi_real casadi_", code, flags=re.MULTILINE)
    places = count()
    code = re.sub(rf"\b({ELEMENTARY})\((a\d+)\)", lambda m: f"recall({m[1]}, {m[2]}, w+{2 * next(places)})", code)
    return FUNCTION.sub(cut, code), next(places)


def cut(function: re.Match) -> str:
    """A function's text; a long one calls its parts in turn, which keep its variables a0, a1, … in an array a."""
    name, lines = function["name"], function["body"].splitlines(keepends=True)
    if len(lines) <= LONG:
        return function[0]
    size = len(re.findall(r"\ba\d+", function["variables"]))
    lines = [re.sub(r"\ba(\d+)\b", lambda number: f"a[{int(number[1])}]", line) for line in lines]
    parts = ["".join(lines[i : i + PART]) for i in range(0, len(lines), PART)]
    texts = [f"static void {name}_{k}({PARAMETERS}) {{\n{part}}}\n\n" for k, part in enumerate(parts)]
    table = ", ".join(f"{name}_{k}" for k in range(len(parts)))
    return (
        f"{''.join(texts)}static int {name}({function['parameters']}) {{\n"
        f"  static void (*const parts[])({PARAMETERS}) = {{{table}}};\n"
        f"  casadi_real a[{size}];\n"
        f"  for (int k = 0; k < {len(parts)}; k++) parts[k](arg, res, w, a);\n"
        f"  return 0;\n}}\n"
    )
