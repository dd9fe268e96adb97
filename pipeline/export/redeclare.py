"""What the front end is known to lose: `redeclare model F = F2(c=5)` in a modification loses c (rumoca 0.10.2)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from pipeline.export.classes import CLASS, ClassText, find_classes, hide

REDECLARE = re.compile(rf"\bredeclare\s+(?:(?:final|replaceable|partial)\s+)*{CLASS}\s+\w+\s*=\s*[\w.]+\s*\(")
WORD = re.compile(r"\w+")


def lost_modifiers(model: str, files: Mapping[int, tuple[str, str]]) -> Iterator[tuple[str, int]]:
    """Places (file, line) of redeclarations in a modification that lose a modifier, in classes the model may use.

    files: name and text by number. A class is used if a used class names it: an overestimate, which refuses too much
    rather than too little.
    """
    codes = {key: hide(text) for key, (_, text) in files.items()}
    classes = [found for key, code in codes.items() for found in find_classes(key, code)]
    used = used_classes(model.rsplit(".", 1)[-1], classes, codes)
    for key, code in codes.items():
        for match in REDECLARE.finditer(code):
            around = [c for c in classes if c.file == key and c.start < match.start() < c.end]
            inner = max(around, key=lambda c: c.start, default=None)
            if inner is None or inner.name not in used:
                continue
            before = code[inner.start : match.start()]
            if before.count("(") > before.count(")"):
                yield files[key][0], code.count("\n", 0, match.start()) + 1


def used_classes(first: str, classes: list[ClassText], codes: Mapping[int, str]) -> set[str]:
    """Names of the classes that can be reached from `first` by the words of their texts."""
    words = {c: set(WORD.findall(own_text(c, classes, codes[c.file]))) for c in classes}
    names, used, fresh = {c.name for c in classes}, {first}, {first}
    while fresh:
        named = {word for c in classes if c.name in fresh for word in words[c] & names}
        fresh = named - used
        used |= fresh
    return used


def own_text(outer: ClassText, classes: list[ClassText], code: str) -> str:
    """The text of a class without the classes it contains."""
    inside = [c for c in classes if c.file == outer.file and outer.start < c.start and c.end <= outer.end]
    pieces, position = [], outer.start
    for c in sorted(inside, key=lambda c: c.start):
        pieces.append(code[position : c.start])
        position = max(c.end, position)
    return " ".join([*pieces, code[position : outer.end]])
