"""Building: names, skipping, determinism, the compiler's absence and failure, the archive."""

import os
import re
import shutil
from pathlib import Path
from subprocess import run
from types import SimpleNamespace
from zipfile import ZipFile

import fmpy
import pytest

from pipeline.errors import ExportError
from pipeline.export import compiler
from pipeline.export.archive import read_note, write_archive
from pipeline.export.build import Built, build
from pipeline.export.catalogue import exported, identifier
from pipeline.export.freshness import EXPORTER
from pipeline.paths import PACKAGE

PLANT = """within Small.FMUs;
model Plant
  parameter Real m=2;
  input Real u;
  output Real y;
  Real v(start=0, fixed=true);
equation
  m*der(v) = u;
  y = v;
end Plant;
"""
LOOP = """within Small.FMUs;
model PlantLoop
  parameter Real m=3;
  Plant plant(m=m);
equation
  plant.u = -plant.y;
end PlantLoop;
"""


@pytest.fixture
def package(tmp_path):
    folder = tmp_path / "Small"
    (folder / "FMUs").mkdir(parents=True)
    (folder / "package.mo").write_text("package Small\nend Small;\n")
    (folder / "package.order").write_text("FMUs\n")
    (folder / "FMUs/package.mo").write_text("within Small;\npackage FMUs\nend FMUs;\n")
    (folder / "FMUs/package.order").write_text("Plant\nPlantLoop\n")
    (folder / "FMUs/Plant.mo").write_text(PLANT)
    (folder / "FMUs/PlantLoop.mo").write_text(LOOP)
    return folder


def start_of(path, name):
    return next(v.start for v in fmpy.read_model_description(str(path)).modelVariables if v.name == name)


def test_the_name_of_an_fmu_is_its_class_in_snake_case():
    assert identifier("A.B.ScaraControllerContinuous") == "scara_controller_continuous"


def test_all_classes_of_the_order_are_exported_and_reported(package, tmp_path):
    lines = []
    built = build(None, tmp_path / "out", modelica=package, report=lines.append)
    assert [(b.name, b.path.name, b.skipped) for b in built] == [
        ("plant", "plant.fmu", False),
        ("plant", "plant_fmi3.fmu", False),
        ("plant_loop", "plant_loop.fmu", False),
        ("plant_loop", "plant_loop_fmi3.fmu", False),
    ]
    assert len(lines) == 2 and all(isinstance(b, Built) and b.path.is_file() for b in built)


def test_what_is_up_to_date_is_skipped_and_what_changed_is_not(package, tmp_path):
    def skipped(names=("plant",), **options):
        return [b.skipped for b in build(names, tmp_path / "out", fmi="2", modelica=package, **options)]

    assert skipped() == [False]
    assert skipped() == [True]
    assert skipped(force=True) == [False]
    assert skipped(start_values={"plant": {"m": 5.0}}) == [False]
    assert skipped(start_values={"plant": {"m": 5.0}}) == [True]
    (package / "FMUs/Plant.mo").write_text(PLANT.replace("m=2", "m=7"))
    assert skipped() == [False]
    (tmp_path / "out/plant.fmu").write_bytes(b"damaged")
    assert skipped() == [False]


def test_what_was_made_before_another_failed_is_up_to_date(package, tmp_path):
    (package / "FMUs/PlantLoop.mo").write_text(LOOP.replace("-plant.y", "-missing"))
    with pytest.raises(ExportError, match="PlantLoop"):
        build(None, tmp_path / "out", fmi="2", modelica=package)
    assert not (tmp_path / "out/plant_loop.fmu").exists()
    assert build(["plant"], tmp_path / "out", fmi="2", modelica=package)[0].skipped


def test_a_build_that_dies_leaves_what_it_made_up_to_date(package, tmp_path, monkeypatch):
    def write_and_die(path, *rest):
        write_archive(path, *rest)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("pipeline.export.build.write_archive", write_and_die)
        with pytest.raises(KeyboardInterrupt):
            build(["plant"], tmp_path / "out", fmi="2", modelica=package)
    assert build(["plant"], tmp_path / "out", fmi="2", modelica=package)[0].skipped


def test_each_version_is_up_to_date_by_itself(package, tmp_path):
    def made(fmi, **options):
        built = build(["plant"], tmp_path, fmi=fmi, modelica=package, **options)
        return [b.path.name for b in built if not b.skipped]

    assert made("3") == ["plant_fmi3.fmu"]
    assert made("3") == []
    assert made("both") == ["plant.fmu"]
    assert made("both") == made("2") == []
    assert made("2", force=True) == ["plant.fmu"]
    (tmp_path / "plant_fmi3.fmu").unlink()
    assert made("2") == []
    assert made("both") == ["plant_fmi3.fmu"]
    (package / "FMUs/Plant.mo").write_text(PLANT.replace("m=2", "m=7"))
    assert made("2") == ["plant.fmu"]
    assert made("both") == ["plant_fmi3.fmu"]


def test_both_versions_carry_the_same_library(package, tmp_path):
    two, three = (built.path for built in build(["plant"], tmp_path, modelica=package))
    libraries = [
        [ZipFile(path).read(name) for name in ZipFile(path).namelist() if name.startswith("binaries/")]
        for path in (two, three)
    ]
    assert len(libraries[0]) == 1 and libraries[0] == libraries[1]


def test_another_compiler_builds_again_and_without_one_what_is_there_serves(package, tmp_path, monkeypatch):
    def skipped():
        return build(["plant"], tmp_path / "out", modelica=package)[0].skipped

    compilers = tmp_path / "bin"
    compilers.mkdir()
    monkeypatch.setenv("CC", shutil.which("cc"))
    assert [skipped(), skipped()] == [False, True]
    monkeypatch.setenv("CC", f"{shutil.which('cc')} -O0")
    assert [skipped(), skipped()] == [False, True]
    for version in ("1", "2"):
        text = f'#!/bin/sh\n[ "$1" = --version ] && echo mine {version} || exec {shutil.which("cc")} "$@"\n'
        (compilers / "mine").write_text(text)
        (compilers / "mine").chmod(0o755)
        monkeypatch.setenv("CC", str(compilers / "mine"))
        assert [skipped(), skipped()] == [False, True]
    monkeypatch.delenv("CC")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert skipped()


def test_the_fingerprint_covers_every_module_the_exporter_imports():
    traceless = {PACKAGE / name for name in ("errors.py", "files.py", "paths.py")}  # nothing of them is in an FMU
    covered = {*EXPORTER, *traceless}
    for module in EXPORTER:
        if module.suffix == ".py":
            imports = re.findall(r"^ *from pipeline(?:\.(\S+))? import (\w+)", module.read_text(), re.MULTILINE)
            names = {room or name for room, name in imports} - {"__version__"}
            assert {PACKAGE.joinpath(*name.split(".")).with_suffix(".py") for name in names} <= covered, module.name


def test_the_same_sources_give_the_same_bytes(package, tmp_path):
    first, second = (build(["plant"], tmp_path / name, modelica=package)[0].path for name in ("a", "b"))
    assert first.read_bytes() == second.read_bytes()


def test_other_sources_give_another_guid(package, tmp_path):
    first = build(["plant"], tmp_path / "a", modelica=package)[0].path
    second = build(["plant"], tmp_path / "b", {"plant": {"m": 5.0}}, modelica=package)[0].path
    guids = [fmpy.read_model_description(str(path)).guid for path in (first, second)]
    assert guids[0] != guids[1]


def test_start_values_reach_the_fmu_they_are_given_for_and_no_other(package, tmp_path):
    build(None, tmp_path, {"plant": {"m": 5.0}}, modelica=package)
    assert start_of(tmp_path / "plant.fmu", "m") == "5.0"
    assert float(start_of(tmp_path / "plant_loop.fmu", "m")) == 3.0


def test_a_start_value_of_nothing_is_refused(package, tmp_path):
    with pytest.raises(ExportError, match="no parameter to set: mass; settable: m"):
        build(["plant"], tmp_path, {"plant": {"mass": 5.0}}, modelica=package)


def test_an_unknown_name_or_version_is_refused(package, tmp_path):
    with pytest.raises(ExportError, match="no FMU robot: there are plant, plant_loop"):
        build(["robot"], tmp_path, modelica=package)
    with pytest.raises(ExportError, match="no FMU plant_fmi3: there are plant, plant_loop; --fmi chooses the version"):
        build(["plant_fmi3"], tmp_path, modelica=package)
    with pytest.raises(ExportError, match="FMI version 1: there are 2, 3 and both"):
        build(None, tmp_path, fmi="1", modelica=package)
    with pytest.raises(ExportError, match="no FMUs/package.order"):
        exported(tmp_path)


def test_benchmarks_are_built_by_name_only(package, tmp_path):
    (package / "Benchmarks").mkdir()
    (package / "Benchmarks/package.order").write_text("Plant64\n")
    assert {one.name for one in build(None, tmp_path, fmi="2", modelica=package)} == {"plant", "plant_loop"}
    with pytest.raises(ExportError, match=r"Small\.Benchmarks\.Plant64: there is no such model"):
        build(["plant64"], tmp_path, fmi="2", modelica=package)


def test_without_a_compiler_the_remedy_is_named(package, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    with pytest.raises(ExportError, match="no C compiler.*install one .*or name it in CC"):
        build(["plant"], tmp_path / "out", modelica=package)
    monkeypatch.setenv("CC", "missing-cc -g")
    with pytest.raises(ExportError, match="CC=missing-cc is not there"):
        compiler.find_compiler()


def test_a_compiler_that_fails_leaves_a_log(package, tmp_path, monkeypatch):
    monkeypatch.setenv("CC", f"{shutil.which('cc')} -include missing.h")
    with pytest.raises(ExportError, match=r"plant: the C compiler failed \(exit code 1\), see .*plant\.log") as error:
        build(["plant"], tmp_path / "out", modelica=package)
    assert "\n" not in str(error.value)
    assert "missing.h" in (tmp_path / "out/plant.log").read_text()
    assert not (tmp_path / "out/plant.fmu").exists()


@pytest.mark.parametrize("version", ["2", "3"])
def test_an_fmu_holds_the_sources_of_its_version_without_the_headers_of_fmi(package, tmp_path, version):
    path = build(["plant"], tmp_path, fmi=version, modelica=package)[0].path
    names = ZipFile(path).namelist()
    other = {"2": "fmi3_", "3": "fmi2_"}[version]
    assert {"modelDescription.xml", "sources/model.c", "sources/integrate.c", "sources/model_counts.h"} <= set(names)
    assert not any(Path(name).name in os.listdir(compiler.headers()) for name in names)
    assert not any(other in name for name in names)
    files = fmpy.read_model_description(str(path)).buildConfigurations[0].sourceFileSets[0].sourceFiles
    assert sorted(f"sources/{name}" for name in files) == [name for name in names if name.endswith(".c")]


@pytest.mark.parametrize("version", ["2", "3"])
def test_the_sources_compile_by_themselves_to_the_functions_of_their_version(package, tmp_path, version):
    path = build(["plant"], tmp_path, fmi=version, modelica=package)[0].path
    folder = fmpy.extract(str(path), str(tmp_path / "unpacked"))
    files = [str(file) for file in sorted(Path(folder, "sources").glob("*.c"))]
    command = [*compiler.find_compiler(), *compiler.FLAGS, "-Wall", "-Wextra", "-Werror", "-I", str(compiler.headers())]
    run([*command, "-Wno-unused-parameter", "-Wno-type-limits", "-o", tmp_path / "plant.so", *files, "-lm"], check=True)
    shown = run(["nm", "-D", "--defined-only", tmp_path / "plant.so"], capture_output=True, text=True, check=True)
    names = [line.split()[-1] for line in shown.stdout.splitlines()]
    assert len(names) == {"2": 44, "3": 75}[version] and all(name.startswith(f"fmi{version}") for name in names)


@pytest.mark.parametrize(
    ("system", "machine", "folder"),
    [
        ("linux", "x86_64", "x86_64-linux"),
        ("linux", "aarch64", "aarch64-linux"),
        ("darwin", "arm64", "aarch64-darwin"),
        ("win32", "AMD64", "x86_64-windows"),
    ],
)
def test_the_platforms_of_fmi_3_are_tuples(monkeypatch, system, machine, folder):
    monkeypatch.setattr(compiler.sys, "platform", system)
    monkeypatch.setattr(compiler, "uname", lambda: SimpleNamespace(machine=machine))
    assert compiler.platform("3")[0] == folder


def test_an_archive_does_not_remember_when_it_was_written(tmp_path):
    for name in ("a", "b"):
        write_archive(tmp_path / name, {"x": b"1", "folder/y": b"2" * 1000})
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert ZipFile(tmp_path / "a").read("folder/y") == b"2" * 1000
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "b"]


def test_an_archive_has_a_note_until_a_byte_of_it_changes(tmp_path):
    path, note = tmp_path / "a.fmu", {"inputs": "0f"}
    write_archive(path, {"x": b"1" * 50}, note)
    data = path.read_bytes()
    assert read_note(path).items() >= note.items() and ZipFile(path).testzip() is None
    for k in range(data.index(b"{")):
        path.write_bytes(data[:k] + bytes([data[k] ^ 1]) + data[k + 1 :])
        assert read_note(path) == {}, k
    for other in (b"", b"damaged", data + b"theirs", data[:-1]):
        path.write_bytes(other)
        assert read_note(path) == {}
    write_archive(path, {"x": b"1"})
    assert read_note(path) == {}
