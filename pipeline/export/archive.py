"""The FMU archive: a zip whose bytes depend on its contents alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from pipeline.files import replacing

EPOCH = (1980, 1, 1, 0, 0, 0)  # the first time a zip can hold


def write_archive(path: Path, files: Mapping[str, bytes]) -> None:
    """Write the files (name in the archive → bytes) as `path`, which appears only when it is whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as fresh, ZipFile(fresh, "w", ZIP_DEFLATED) as archive:
        for name in sorted(files):
            info = ZipInfo(name, EPOCH)
            info.external_attr = 0o644 << 16
            info.compress_type = ZIP_DEFLATED
            archive.writestr(info, files[name])
