"""What an experiment needs is built before it starts, once, and what another hand put there is left alone."""

import os
import subprocess
import sys
from zipfile import ZipFile

import pytest

from pipeline.export.archive import read_note, write_archive

SIMULATE = [sys.executable, "-m", "pipeline.cli", "simulate", "emps", "--simulated", "--output"]


def start(cache, output, *more, **variables):
    environment = {**os.environ, "FMUID_CACHE": str(cache), **variables}
    command = [*SIMULATE, str(output), *more]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def told(process):
    """Exit code and narration."""
    said = process.communicate(timeout=300)[1]
    return process.returncode, said


def test_two_runs_at_once_build_once_and_a_third_not_at_all(tmp_path):
    running = [start(tmp_path, tmp_path / f"{i}.csv") for i in (1, 2)]
    ends = [told(process) for process in running]
    assert [code for code, _ in ends] == [0, 0]
    assert sum(said.count("built emps.fmu") for _, said in ends) == 1
    (folder,) = (p for p in tmp_path.iterdir() if p.is_dir())
    assert sorted(p.name for p in folder.iterdir()) == ["emps.fmu", "emps_controller.fmu", "kernels"]
    assert told(start(tmp_path, tmp_path / "3.csv")) == (0, "")
    assert (tmp_path / "1.csv").read_bytes() == (tmp_path / "3.csv").read_bytes()


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cache")
    assert told(start(folder, folder / "first.csv"))[0] == 0
    (built,) = (p for p in folder.iterdir() if p.is_dir())
    return built


def test_what_is_stale_is_built_again(cache):
    with ZipFile(cache / "emps.fmu") as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    write_archive(cache / "emps.fmu", files, {**read_note(cache / "emps.fmu"), "inputs": "another exporter"})
    code, said = told(start(cache.parent, cache.parent / "a.csv"))
    assert code == 0 and "building emps, stale" in said and "building emps_controller" not in said


def test_without_a_compiler_what_is_there_serves_and_what_is_missing_is_one_line(cache, tmp_path):
    nothing = {"PATH": str(tmp_path), "CC": ""}
    assert told(start(cache.parent, cache.parent / "a.csv", **nothing)) == (0, "")
    code, said = told(start(tmp_path, tmp_path / "a.csv", **nothing))
    assert code == 3 and said.splitlines()[-1].startswith("fmuid: no C compiler")
    assert not (tmp_path / "a.csv").exists()


def test_missing_data_are_told_before_anything_is_built(tmp_path):
    code, said = told(start(tmp_path, tmp_path / "a.csv", "--set", "simulation.identification='none.csv'"))
    assert code == 2 and said.count("\n") == 1 and "none.csv: no such file" in said


def test_what_another_hand_put_there_is_left_alone_and_told(cache):
    """The last of this module: it changes the FMU."""
    theirs = (cache / "emps.fmu").read_bytes() + b"theirs"  # a zip may end in anything up to 64 KiB
    (cache / "emps.fmu").write_bytes(theirs)
    code, said = told(start(cache.parent, cache.parent / "a.csv"))
    assert code == 0 and "emps.fmu is not as it was built, and used as it is; `fmuid build`" in said
    assert (cache / "emps.fmu").read_bytes() == theirs
