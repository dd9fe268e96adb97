"""The house's own rules: which way imports run, who may import fmpy, what every public thing says of itself."""

import ast
import subprocess

import pytest

from pipeline.paths import PACKAGE, ROOT

# From the bottom up: a room imports from its own level or from below.
LEVELS = (
    {"arguments", "errors", "files", "in_order", "interrupts", "paths", "records"},
    {"settings", "units"},
    {"config"},
    {"plant", "export"},
    {"signals", "simulate"},
    {"identify"},
    {"assess"},
    {"report"},
    {"workflow"},
    {"cli"},
)
LEVEL = {room: i for i, rooms in enumerate(LEVELS) for room in rooms}
MODULES = sorted(PACKAGE.rglob("*.py"))
IDS = [str(m.relative_to(PACKAGE)) for m in MODULES]


def room_of(module):
    return module.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(module):
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module


@pytest.mark.parametrize("module", MODULES, ids=IDS)
def test_imports_run_one_way(module):
    here = room_of(module)
    for name in imports(module):
        parts = name.split(".")
        if parts[0] == "pipeline" and len(parts) > 1:
            there = parts[1]
            assert there == here or LEVEL[there] < LEVEL[here], f"{here} imports {name}"


@pytest.mark.parametrize("module", MODULES, ids=IDS)
def test_only_the_plant_imports_fmpy(module):
    if room_of(module) != "plant":
        assert not any(name.split(".")[0] == "fmpy" for name in imports(module))


@pytest.mark.parametrize("module", MODULES, ids=IDS)
def test_public_things_have_docstrings(module):
    tree = ast.parse(module.read_text())
    assert ast.get_docstring(tree), "the module says nothing of itself"
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            assert ast.get_docstring(node), f"{node.name} has no docstring"


def test_the_map_in_the_readme_names_every_room():
    text = (ROOT / "README.md").read_text()
    rooms = {p.name for p in PACKAGE.iterdir() if p.is_dir() and any(p.glob("*"))} - {"__pycache__"}
    for room in rooms:
        assert f"`pipeline/{room}/`" in text, f"README's map lacks {room}"


def test_no_large_file_is_kept():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("not a git checkout: nothing to list")
    for name in listed.stdout.split("\0"):
        assert not name or (ROOT / name).stat().st_size < 1_000_000, name
