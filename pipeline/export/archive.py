"""The FMU archive: a zip whose bytes depend on its contents alone, and the note on how it was made."""

from __future__ import annotations

import json
from collections.abc import Mapping
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile, ZipInfo

from pipeline.files import replacing

EPOCH = (1980, 1, 1, 0, 0, 0)  # the first time a zip can hold
NO_COMMENT = b"\0\0"  # a zip ends in the length of its comment and the comment


def write_archive(path: Path, files: Mapping[str, bytes], note: Mapping[str, str] | None = None) -> None:
    """Write the files (name in the archive → bytes) as `path`, which appears only when it is whole.

    note: kept as the comment of the zip, with a digest of all before it.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    data = pack(files)
    with replacing(path) as fresh:
        fresh.write_bytes(data if note is None else seal(data, note))


def pack(files: Mapping[str, bytes]) -> bytes:
    """The files (name → bytes) as a zip without a comment."""
    memory = BytesIO()
    with ZipFile(memory, "w", ZIP_DEFLATED) as archive:
        for name in sorted(files):
            info = ZipInfo(name, EPOCH)
            info.external_attr = 0o644 << 16
            info.compress_type = ZIP_DEFLATED
            archive.writestr(info, files[name])
    return memory.getvalue()


def seal(data: bytes, note: Mapping[str, str]) -> bytes:
    """The zip with the note and its own digest as its comment."""
    comment = json.dumps({**note, "sha256": sha256(data).hexdigest()}, sort_keys=True).encode()
    return data.removesuffix(NO_COMMENT) + len(comment).to_bytes(2, "little") + comment


def read_note(path: Path) -> dict[str, str]:
    """The note of an archive that is as it was written; empty for any other file."""
    data = path.read_bytes()
    try:
        with ZipFile(BytesIO(data)) as archive:
            comment = archive.comment
        note = json.loads(comment)
    except (BadZipFile, ValueError):
        return {}
    bare = data[: len(data) - len(comment) - len(NO_COMMENT)] + NO_COMMENT
    return note if isinstance(note, dict) and seal(bare, note) == data else {}
