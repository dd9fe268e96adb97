"""A small reader of the Modelica sources: comments and annotations apart from declarations, nothing of semantics."""

import re
from dataclasses import dataclass
from pathlib import Path

from pipeline.paths import MODELICA as PACKAGE

FILES = sorted(PACKAGE.rglob("*.mo"))
CLASS = re.compile(r"^(?:partial )?(package|model|block|connector) (\w+) (?:= .*)?\"", re.MULTILINE)
DECLARATION = re.compile(
    r"^  (?:final |discrete |parameter |constant )*"
    r"(?P<type>(?:\w+\.)*[A-Z]\w*) (?P<name>\w+)(?P<rest>[^;]*?)(?P<description> *\"[^\"]+\")?;$",
    re.MULTILINE,
)


@dataclass(frozen=True)
class Declaration:
    """One component: its type as written, its name, its modifiers and binding, its description ("" for none)."""

    type: str
    name: str
    rest: str
    description: str


def code(path: Path) -> str:
    """The source without its annotation, statements that span lines joined into one."""
    text = path.read_text(encoding="utf-8").split("  annotation (", 1)[0]
    return re.sub(r"\n {3,}", " ", text)


def declarations(path: Path) -> list[Declaration]:
    """Everything declared before the equations."""
    head = re.split(r"^equation$", code(path), maxsplit=1, flags=re.MULTILINE)[0]
    found = DECLARATION.finditer(head)
    return [Declaration(m["type"], m["name"], m["rest"], (m["description"] or "").strip(' "')) for m in found]


def statements(path: Path) -> list[str]:
    """Every line of the declaration part that ends a statement, `extends` included."""
    head = re.split(r"^equation$", code(path), maxsplit=1, flags=re.MULTILINE)[0]
    return [line.strip() for line in head.splitlines() if line.endswith(";") and not line.startswith(("within", "end"))]


def unit_types() -> dict[str, str]:
    """Names of `Units` and the unit of each."""
    text = re.sub(r"\n {3,}", " ", (PACKAGE / "Units.mo").read_text(encoding="utf-8"))
    found = re.findall(
        r'^  type (\w+) = Real\(final quantity="\w+", final unit="([^"]+)".*?\) "[^"]+";$', text, re.MULTILINE
    )
    return dict(found)


def snake_case(name: str) -> str:
    """The file name of the FMU of a class: `ScaraClosedLoop` -> `scara_closed_loop`."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()
