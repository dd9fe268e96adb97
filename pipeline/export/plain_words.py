"""The front end's refusals in the words of the language, with a remedy, as far as they are known (rumoca 0.10.2)."""

from __future__ import annotations

import re
from collections.abc import Mapping

from pipeline.export.classes import hide

STAGE = r"(?:\w+ failed: \S+ failed in \w+: )?"
OWNER = r"unsupported Flat semantic owner "
RULES = {
    OWNER + r"`function statement`: `(\w+)` contains a statement without a checked DAE owner": (
        r"the function \1 has a statement that cannot be exported, such as while: write it with if and for"
    ),
    OWNER + r"`function loop reduction`: `(\w+)` does not have a proved finite arithmetic-series form": (
        r"a for-loop of the function \1 cannot be written out, as one with break: write it with if, over a fixed range"
    ),
    OWNER + r"`function return`: `(\w+)` must define every output before returning": (
        r"the function \1 has a return: write it with if and else"
    ),
    OWNER + r"`function output definition`: `(\w+)` returns `(\w+)` without defining every declared element": (
        r"the function \1 does not assign every element of its output \2: begin with \2 := zeros(…)"
    ),
    OWNER + r"`when assignment`: `([^`]+)` is not a discrete coordinate": (
        r"\1 is assigned by element in a when-clause: assign the whole array"
    ),
    OWNER + r"`derivative expression`: der\(\.\.\.\) must have exactly one resolved variable-reference operand": (
        r"der() of an expression: give the expression a variable"
    ),
    OWNER + r"`clocked [^`]*`: .*": r"synchronous elements (Clock, previous, hold) cannot be exported: use sample()",
    r"PanicException: .*continuous state\"?": (
        r"der() of an input, or of another variable that is no state: give its derivative as an input too"
    ),
    r"unbalanced model: (\d+) equations, (\d+) unknowns .*\]": (
        r"unbalanced: the number of equations is \1, of unknown variables \2; add or remove equations until they agree"
    ),
    r"unsupported model algorithm in canonical DAE: .*": (
        r"an algorithm section that assigns several variables or one repeatedly: put it into a function"
    ),
    r"unsupported initial algorithm in canonical DAE: initial algorithm target `([^`]+)`.*": (
        r"an initial algorithm (for \1): write an initial equation, or a start value with fixed=true"
    ),
    r"canonical DAE construction rejected .* requires a compact structured event owner": (
        r"an event in a for-equation: use an array of components, or noEvent()"
    ),
    r"unsupported runtime operator `(\w+)`: .*": r"the function \1() cannot be exported: write it out",
    r"expandable connector connection between `([^`]+)` and `([^`]+)` .*": (
        r"an expandable connector (connect(\1, \2)): declare its variables in a plain connector"
    ),
    r"unresolved Flat reference `([^`]+)`": r"\1 is no variable, and no function that can be exported",
}
UNRESOLVED = re.compile(r"unresolved (?P<kind>component reference|type reference|function call): '(?P<name>[^']+)'")
FOLLOWS = re.compile(r"unresolved component reference: '\w+\.[^']+'; (?=.*unresolved type reference)")


def in_plain_words(error: str, files: Mapping[str, str]) -> str:
    """A message of the front end with its jargon replaced; what is not known stays. files: the texts by name."""
    error = re.sub(rf"^{STAGE}", "", FOLLOWS.sub("", error))
    for pattern, words in RULES.items():
        error = re.sub(pattern, words, error)
    return UNRESOLVED.sub(lambda match: _unresolved(match["kind"], match["name"], files), error)


def _unresolved(kind: str, name: str, files: Mapping[str, str]) -> str:
    place = find_name(name, files)
    at = f" ({place})" if place else ""
    if name.split(".")[0] == "Modelica":
        return f"{name} is not found{at}: set MODELICAPATH to the folder that holds the Modelica library"
    if kind == "component reference":
        return f"{name} is not declared{at}: declare it, or correct its name"
    what = "function" if kind == "function call" else "class"
    return f"the {what} {name} is not found{at}: correct its name, or set MODELICAPATH to the folder of its library"


def find_name(name: str, files: Mapping[str, str]) -> str | None:
    """`file:line` where a name first stands in the texts, outside of comments and strings."""
    word = re.compile(rf"(?<![\w.]){re.escape(name)}(?![\w])")
    for file, text in files.items():
        if found := word.search(hide(text)):
            return f"{file}:{text.count(chr(10), 0, found.start()) + 1}"
    return None
