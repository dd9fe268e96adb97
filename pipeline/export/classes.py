"""The classes in Modelica texts, as far as they can be seen without a parser: names, places, words."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

CLASS = r"(?:model|block|package|record|type|connector|function|class)"
HEAD = re.compile(
    rf"(?P<partial>\bpartial\s+)?\b(?P<kind>(?:operator\s+)?{CLASS})\s+(?:extends\s+)?(?P<name>\w+)\b(?!\s*[=(])"
)
HIDDEN = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\])*\"", re.DOTALL)
WITHIN = re.compile(r"^\s*within\s+([\w.]+)\s*;")


@dataclass(frozen=True)
class ClassText:
    """A class in a file: its name and where its text begins and ends."""

    name: str
    file: int
    start: int
    end: int
    kind: str = "class"
    partial: bool = False


def hide(text: str) -> str:
    """A text of the same length and lines with blanks for comments and strings."""
    return HIDDEN.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def find_classes(file: int, code: str) -> Iterator[ClassText]:
    """Every class with an `end` of its own in a text without comments and strings."""
    for match in HEAD.finditer(code):
        end = re.compile(rf"\bend\s+{match['name']}\s*;").search(code, match.end())
        if end:
            yield ClassText(match["name"], file, match.start(), end.end(), match["kind"], bool(match["partial"]))


def find_models(files: Mapping[str, str]) -> list[str]:
    """Full names of the models and blocks that are not partial, in texts by file name."""
    models = []
    for text in files.values():
        code = hide(text)
        classes = list(find_classes(0, code))
        within = WITHIN.match(code)
        for found in classes:
            around = [c for c in classes if c.start < found.start and found.end < c.end]
            inside = all(c.kind == "package" for c in around)  # what stands in a model is its own affair
            if found.kind in ("model", "block", "class") and not found.partial and inside:
                models.append(".".join([*(within.groups() if within else ()), *(c.name for c in around), found.name]))
    return models
