"""House rules of the Modelica sources, read as text: one class per file, order, units, descriptions, documentation."""

import re

import pytest

from tests.modelica.sources import CLASS, FILES, PACKAGE, code, declarations, statements, unit_types

FOLDERS = [PACKAGE, *sorted(p for p in PACKAGE.iterdir() if p.is_dir())]
CLASSES = [p for p in FILES if p.name not in ("package.mo", "Units.mo")]
EXAMPLES = [p for p in CLASSES if p.parent.name in ("Examples", "FMUs", "Benchmarks")]
ESTIMATED = {"ZZR1", "Fv1", "Fs1", "ZZ2", "LMX2", "LMY2", "Fv2", "Fs2", "M", "Fv", "Fc", "Fs", "offset", "ZZ", "MX"}


def name_of(path):
    return path.relative_to(PACKAGE).as_posix()


def test_the_package_is_there():
    assert len(CLASSES) > 20


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda p: p.name)
def test_package_order_lists_exactly_the_members(folder):
    members = {p.stem for p in folder.glob("*.mo")} - {"package"}
    members |= {p.name for p in folder.iterdir() if p.is_dir()}
    order = (folder / "package.order").read_text().split("\n")
    assert order[-1] == "" and sorted(order[:-1]) == sorted(members)


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_one_class_per_file_under_its_own_name_and_within(path):
    package = [*path.relative_to(PACKAGE.parent).parts[:-1]]
    name = path.stem if path.name != "package.mo" else package.pop()
    text = path.read_text(encoding="utf-8")
    assert [m[2] for m in CLASS.finditer(text)] == [name]
    assert text.startswith(f"within {'.'.join(package)};\n" if package else f"package {name} ")
    assert text.rstrip().endswith(f"end {name};") or path.parent.name == "Interfaces" and " = " in text


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_documentation_stands_in_every_class(path):
    text = path.read_text(encoding="utf-8")
    info = re.search(r'Documentation\(info="<html>\n(.+?)\n</html>"\)\);', text, re.DOTALL)
    assert info is not None and len(info[1]) > 40
    for tag in ("p", "ul", "li", "pre", "i", "b", "code", "sup", "a"):
        assert len(re.findall(rf"<{tag}[ >]", info[1])) == info[1].count(f"</{tag}>"), tag


SOURCED = [p for p in CLASSES if p in EXAMPLES or p.parent.name == "Plants" or "Body" in p.name or "Friction" in p.name]


@pytest.mark.parametrize("path", SOURCED, ids=name_of)
def test_the_source_of_the_equations_is_named(path):
    text = path.read_text(encoding="utf-8")
    assert "Gautier" in text or "modelica://" in text


@pytest.mark.parametrize("path", CLASSES, ids=name_of)
def test_every_declaration_has_a_unit_and_a_description(path):
    units = unit_types()
    for d in declarations(path):
        assert d.description, f"{d.name}: no description"
        known = d.type.startswith("Units.") and d.type.removeprefix("Units.") in units
        component = d.type.split(".")[0] in ("Components", "Plants", "FMUs") or (path.parent / f"{d.type}.mo").exists()
        component = component and not d.type.startswith(("Real", "Interfaces.Real"))
        counted = d.type == "Integer"  # has no unit in Modelica
        assert known or component or counted or re.search(r'\bunit="[^"]+"', d.rest), f"{d.name}: no unit"


@pytest.mark.parametrize("path", CLASSES, ids=name_of)
def test_the_reader_sees_every_declaration(path):
    inherited = [s for s in statements(path) if s.startswith("extends ")]
    assert len(declarations(path)) + len(inherited) == len(statements(path))


def test_units_are_typed_once_and_used():
    units = unit_types()
    text = (PACKAGE / "Units.mo").read_text(encoding="utf-8")
    assert len(units) == text.count("  type ") and len(set(units.values())) == len(units)
    used = {d.type.removeprefix("Units.") for p in CLASSES for d in declarations(p) if d.type.startswith("Units.")}
    assert used == set(units)


@pytest.mark.parametrize("path", CLASSES, ids=name_of)
def test_nothing_an_estimator_may_ask_for_is_rejected(path):
    for d in declarations(path):
        if d.name in ESTIMATED:
            assert "min" not in d.rest and "max" not in d.rest, d.name


@pytest.mark.parametrize("path", EXAMPLES, ids=name_of)
def test_what_can_run_says_how_long(path):
    found = re.search(r"experiment\(StopTime=([\d.]+), Interval=([\d.]+)\)", path.read_text(encoding="utf-8"))
    assert found and float(found[1]) / float(found[2]) >= 100


def test_the_drive_gain_of_a_recording_is_not_in_the_library():
    for path in sorted(PACKAGE.parent.rglob("*")):
        if path.is_file():
            assert not re.search(r"35\.15|35,15", path.read_text(encoding="utf-8")), path


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_the_language_stays_plain(path):
    spoken = re.sub(r'"[^"]*"', "", code(path))
    assert not re.search(r"\b(redeclare|replaceable|algorithm|function|inner|outer|Modelica)\b", spoken)
    assert "__" not in path.read_text(encoding="utf-8")
    assert max(map(len, path.read_text(encoding="utf-8").splitlines())) <= 120


def test_the_readme_names_every_package_and_every_export():
    readme = (PACKAGE.parent / "README.md").read_text(encoding="utf-8")
    names = (PACKAGE / "package.order").read_text().split() + (PACKAGE / "FMUs/package.order").read_text().split()
    assert [n for n in names if f"`{n}`" not in readme] == []
