"""Shared fixtures: the built FMUs, opened archives, the measured data."""

import os
import tempfile
from pathlib import Path

import pytest

from pipeline.paths import FMUS, ROOT


@pytest.fixture(scope="session")
def fmus():
    """Folder of the FMUs, built where they are not up to date."""
    from pipeline.export.build import build
    from pipeline.plant.binding import gains_of_bindings, variants_of_bindings

    build(None, FMUS, gains_of_bindings(), variants=variants_of_bindings())
    return FMUS


@pytest.fixture(scope="session")
def archives(fmus):
    """`archives(name)`: the FMU of that name, unpacked once per session (tests.export.driver.Archive)."""
    from tests.export.driver import Archive

    opened = {}

    def archive(name):
        if name not in opened:
            opened[name] = Archive(fmus / f"{name}.fmu")
        return opened[name]

    yield archive
    for one in opened.values():
        one.close()


@pytest.fixture(scope="session")
def emps_data():
    """Folder of the EMPS benchmark's data: FMUID_EMPS_DATA, or shared/data/emps beside the checkout; else skipped."""
    folder = Path(os.environ.get("FMUID_EMPS_DATA", ROOT.parent / "shared" / "data" / "emps"))
    if not (folder / "DATA_EMPS.mat").is_file():
        pytest.skip(
            f"no EMPS data in {folder}: get it from the benchmark's site, or name its folder in FMUID_EMPS_DATA"
        )
    return folder


@pytest.fixture
def temporary_folders(tmp_path, monkeypatch):
    """The test ends without a folder left in the temporary directory."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield folder
    assert not list(folder.iterdir())
