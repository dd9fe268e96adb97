"""What the front end loses in silence, found in the text of the classes that a model may use (rumoca 0.10.2)."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping

from pipeline.export.classes import CLASS, ClassText, find_classes, hide

WORD = re.compile(r"\w+")
ANNOTATION = re.compile(r"\bannotation\s*(?=\()")
REDECLARE = re.compile(r"\bredeclare\b")
REDECLARED_CLASS = re.compile(rf"(?:(?:each|final|replaceable|partial)\s+)*{CLASS}\b")
CONSTRAINT = re.compile(r"\bconstrainedby\s+[\w.]+\s*\(")
DOTTED = re.compile(r"[(,]\s*(?:(?:each|final)\s+)*\w+(?:\s*\.\s*\w+)+\s*(?=[=(])(?!==)")
NAMED = re.compile(r"\s*(?:(?:each|final)\s+)*\w+\s*(?:=(?!=)|\()")
ITERATORS = re.compile(r"\bfor\s+\w+\s+in\b[^;]*?(?:;|\bloop\b|$)")
SECOND = re.compile(r",\s*\w+\s+in\b")
ARRAY_CLASS = re.compile(r"\b(?:model|block|class|record|connector)\s+\w+\s*=\s*[\w.]+\s*\[")


def find_losses(model: str, files: Mapping[int, tuple[str, str]]) -> Iterator[tuple[str, str, int]]:
    """What is lost, and where (file, line), in the classes that `model` may use.

    files: name and text by number. A class is used if a used class names it: an overestimate, which refuses too much
    rather than too little.
    """
    codes = {key: without_annotations(hide(text)) for key, (_, text) in files.items()}
    classes = [found for key, code in codes.items() for found in find_classes(key, code)]
    used = used_classes(model.rsplit(".", 1)[-1], classes, codes)
    for key, code in codes.items():
        for what, find in LOSSES.items():
            for position in find(code, [c for c in classes if c.file == key]):
                inner = innermost(classes, key, position)
                if inner is not None and inner.name in used:
                    yield what, files[key][0], code.count("\n", 0, position) + 1


def innermost(classes: list[ClassText], file: int, position: int) -> ClassText | None:
    """The class whose own text a position is in."""
    around = [c for c in classes if c.file == file and c.start < position < c.end]
    return max(around, key=lambda c: c.start, default=None)


def without_annotations(code: str) -> str:
    """A text of the same length and lines with blanks for the annotations."""
    for match in ANNOTATION.finditer(code):
        end = closing(code, match.end())
        code = code[: match.start()] + re.sub(r"[^\n]", " ", code[match.start() : end]) + code[end:]
    return code


def closing(code: str, opening: int) -> int:
    """The position behind the parenthesis that closes the one at `opening`."""
    depth = 0
    for match in re.compile(r"[()]").finditer(code, opening):
        depth += 1 if match.group() == "(" else -1
        if depth == 0:
            return match.end()
    return len(code)


def argument(code: str, position: int) -> str:
    """The rest of the modification argument that stands at a position."""
    depth = 0
    for match in re.compile(r"[()\[\]{},;]").finditer(code, position):
        if depth == 0 and match.group() in "),;":
            return code[position : match.start()]
        depth += {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}.get(match.group(), 0)
    return code[position:]


def redeclarations(wanted: Callable[[int, str], bool]) -> Callable[[str, list[ClassText]], Iterator[int]]:
    """Positions of redeclarations, chosen by the depth of parentheses they are in and by their text."""

    def find(code: str, classes: list[ClassText]) -> Iterator[int]:
        for match in REDECLARE.finditer(code):
            inner = max((c.start for c in classes if c.start < match.start() < c.end), default=0)
            before = code[inner : match.start()]
            if wanted(before.count("(") - before.count(")"), argument(code, match.end()).strip()):
                yield match.start()

    return find


def is_class(text: str) -> bool:
    """True for the redeclaration of a class, not of a component."""
    return REDECLARED_CLASS.match(text) is not None


def binds(text: str) -> bool:
    """True where a component's redeclaration has a binding: `redeclare Real y(unit="m") = 2`."""
    while (bare := re.sub(r"\([^()]*\)|\[[^\[\]]*\]|\{[^{}]*\}", "", text)) != text:
        text = bare
    return re.search(r"(?<![<>=])=(?!=)", text) is not None


def dotted(code: str, classes: list[ClassText]) -> Iterator[int]:
    """Modifications `a.b = …` and `a.b(c = …)`, which are no function calls: their arguments are named."""
    for match in DOTTED.finditer(code):
        if code[match.end()] == "=" or NAMED.match(code, match.end() + 1):
            yield match.end()


def iterators(code: str, classes: list[ClassText]) -> Iterator[int]:
    """Comprehensions with several iterators; for-equations may have them."""
    for match in ITERATORS.finditer(code):
        if not match.group().endswith("loop") and SECOND.search(match.group()):
            yield match.start()


def every(pattern: re.Pattern[str]) -> Callable[[str, list[ClassText]], Iterator[int]]:
    """All places of a pattern."""
    return lambda code, classes: (match.start() for match in pattern.finditer(code))


OWN_CLASS = "give it to a class of its own"
LOSSES: dict[str, Callable[[str, list[ClassText]], Iterator[int]]] = {
    f"a redeclare with a modifier is lost by the front end: {OWN_CLASS}": redeclarations(
        lambda depth, text: depth == 1 and is_class(text) and "(" in text
    ),
    "a redeclare with a binding is lost by the front end: redeclare it in the body of a class": redeclarations(
        lambda depth, text: depth == 1 and not is_class(text) and binds(text)
    ),
    f"a redeclare in a nested modification is lost by the front end: {OWN_CLASS}": redeclarations(
        lambda depth, text: depth > 1
    ),
    f"a modification in constrainedby is lost by the front end: {OWN_CLASS}": every(CONSTRAINT),
    "a modification a.b=c is lost by the front end: write a(b=c)": dotted,
    "a comprehension with several iterators loses its shape in the front end: nest them": iterators,
    "a class that is an array is lost by the front end: give the sizes to the components": every(ARRAY_CLASS),
}


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
