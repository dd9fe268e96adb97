"""The run record on disk: `result.json` and one Parquet file per signal table, written atomically.

The record is the product and the page a view of it: everything that the page shows can be read back from here.
Schema: reports/README.md.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import shutil
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from pipeline.errors import DataError
from pipeline.files import replacing, sync

SCHEMA = 1
RESULT = "result.json"
REQUIRED = ("run_id", "experiment", "verdict", "estimates")
_STEM = re.compile(r"[a-z0-9][a-z0-9_-]*")


def write_run(folder: Path | str, record: Mapping, signals: Mapping[str, pd.DataFrame]) -> Path:
    """Write a run folder: all of it or nothing.

    `signals` maps a file's stem ("identification", "ekf-3-known") to its table (index `time` in s). The files are
    written into a hidden folder beside and renamed when complete; a run of the same name is replaced only then.
    NaN and infinities become null in the JSON. Raises DataError, and leaves what was there untouched, when the disk
    is full, the place cannot be written, or something stands there that is no run.
    """
    folder = Path(folder)
    check_target(folder)
    for stem in signals:
        if not _STEM.fullmatch(stem):
            raise DataError(f"signal table {stem!r}: not a file name; use lower case letters, digits, - and _")
    stored = plain({"schema": SCHEMA, **record, "signals": sorted(signals)})
    fresh = folder.parent / f".{folder.name}.{os.getpid()}.new"
    try:
        _fill(fresh, stored, signals)
        _swap(fresh, folder)
    except OSError as error:
        raise DataError(
            f"run folder {folder}: {error.strerror or error}; nothing was changed, make room or choose another folder"
        ) from error
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
    return folder


def check_target(folder: Path) -> None:
    """Refuse to put a run where something else stands: only an empty folder or an older run may be replaced."""
    if folder.exists() and not (folder.is_dir() and ((folder / RESULT).is_file() or not any(folder.iterdir()))):
        raise DataError(f"run folder {folder}: something that is no run stands there; choose another --output")


def read_run(folder: Path | str) -> tuple[dict, dict[str, pd.DataFrame]]:
    """The record and its signal tables by stem. Raises DataError naming the file and the remedy."""
    folder = Path(folder)
    if not folder.is_dir():
        raise DataError(f"run folder {folder}: not found; give the folder that holds {RESULT}")
    record = _read_record(folder / RESULT)
    stems = dict.fromkeys(record.get("signals", ()))
    stems |= dict.fromkeys(
        Path(e["signals"]).stem for e in record["estimates"].values() if isinstance(e, dict) and e.get("signals")
    )
    hashes = record.get("signals_sha256") or {}
    return record, {stem: _read_table(folder, stem, hashes.get(stem)) for stem in stems}


def plain(value: object, place: str = "record") -> object:
    """`value` as JSON knows it: NumPy types unpacked, NaN and infinities None. Raises DataError for anything else."""
    if isinstance(value, Mapping):
        return {str(key): plain(item, f"{place}.{key}") for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item, f"{place}[{i}]") for i, item in enumerate(value)]
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), place)
    if isinstance(value, np.generic):
        return plain(value.item(), place)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | int):
        return value
    if isinstance(value, Path) or hasattr(value, "isoformat"):
        return str(value)
    raise DataError(f"{place}: {type(value).__name__} has no place in a run record; give a number, text or list")


def write_text(path: Path, text: str, remedy: str = "make room first") -> None:
    """Replace a text file in one step. Raises DataError when that fails; the old file then still stands."""
    try:
        with replacing(path) as fresh:
            fresh.write_bytes(text.encode())
    except OSError as error:
        raise DataError(f"file {path}: {error.strerror or error}; nothing was changed, {remedy}") from error


def _fill(fresh: Path, record: dict, signals: Mapping[str, pd.DataFrame]) -> None:
    """Write the tables, then the record with their SHA-256."""
    shutil.rmtree(fresh, ignore_errors=True)
    fresh.mkdir(parents=True)
    hashes = {}
    for stem, table in signals.items():
        path = fresh / f"{stem}.parquet"
        table.to_parquet(path, use_dictionary=False)  # signals hardly repeat: larger and slower with one
        sync(path)
        hashes[stem] = _digest(path)
    text = json.dumps({**record, "signals_sha256": hashes}, indent=1, allow_nan=False)
    _write_bytes(fresh / RESULT, text.encode())
    sync(fresh)


def _swap(fresh: Path, folder: Path) -> None:
    """Put the complete folder in its place; the one that was there goes last, and comes back if the swap fails."""
    old = folder.parent / f".{folder.name}.{os.getpid()}.old"
    if not folder.exists():
        fresh.rename(folder)
    else:
        folder.rename(old)
        try:
            fresh.rename(folder)
        except OSError:
            old.rename(folder)
            raise
        shutil.rmtree(old, ignore_errors=True)
    sync(folder.parent)


def _write_bytes(path: Path, data: bytes) -> None:
    with path.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _read_record(path: Path) -> dict:
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise DataError(f"run record {path}: not found; give a folder that `fmuid run` wrote") from None
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise DataError(f"run record {path}: cannot be read ({_one_line(error)}); run the experiment again") from error
    schema = record.get("schema") if isinstance(record, dict) else None
    if schema != SCHEMA:
        raise DataError(f"run record {path}: schema {schema!r}, this version reads {SCHEMA}; run the experiment again")
    for key in REQUIRED:
        kind = str if key == "run_id" else dict
        if not isinstance(record.get(key), kind):
            raise DataError(f"run record {path}: `{key}` is missing or of the wrong kind; run the experiment again")
    return record


def _read_table(folder: Path, stem: str, sha256: str | None) -> pd.DataFrame:
    """A signal table; DataError where it is missing, or is not the one that was written with the record."""
    path = folder / f"{stem}.parquet"
    if not _STEM.fullmatch(stem):
        raise DataError(f"run record {folder / RESULT}: signal table {stem!r} is not a file name; run it again")
    if not path.is_file():
        raise DataError(f"signal table {path}: not found; the run folder is incomplete, run the experiment again")
    try:
        if sha256 is not None and _digest(path) != sha256:
            raise DataError(f"signal table {path}: not what the run wrote (another SHA-256); run it again")
        return pd.read_parquet(path)
    except DataError:
        raise
    except (OSError, ValueError) as error:  # pyarrow's ArrowInvalid is a ValueError
        raise DataError(f"signal table {path}: cannot be read ({_one_line(error)}); run it again") from error


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:160]
