"""The run record on disk: round trip, atomicity, and the one line for each way in which a folder can be broken."""

import errno
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import slug
from pipeline.errors import DataError
from pipeline.report.record import plain, read_run, write_run, write_text
from tests.report import synthetic

RECORD = {"run_id": "r", "experiment": {"name": "x"}, "verdict": {"status": "pass"}, "estimates": {}}
TABLE = pd.DataFrame({"q_1": [1.0, 2.0]}, index=pd.Index([0.0, 0.01], name="time"))


@pytest.fixture
def run(tmp_path):
    return write_run(tmp_path / "run", RECORD, {"identification": TABLE})


def leftovers(folder: Path) -> list[str]:
    return [p.name for p in folder.iterdir() if p.name.startswith(".")]


def test_a_whole_run_comes_back(tmp_path):
    record, signals = synthetic.scara(samples=200)
    read, tables = read_run(write_run(tmp_path / "scara", record, signals))
    assert read["estimates"] == json.loads(json.dumps(record["estimates"]))
    assert list(read["estimates"]) == list(record["estimates"])
    assert set(tables) == set(signals)
    pd.testing.assert_frame_equal(tables["ekf-3-known"], signals["ekf-3-known"])
    assert leftovers(tmp_path) == []


def test_what_is_not_finite_becomes_null(tmp_path):
    record = RECORD | {"numbers": [math.nan, math.inf, np.float64(-math.inf), np.array([1.0, math.nan]), np.int64(3)]}
    text = (write_run(tmp_path / "run", record, {}) / "result.json").read_text()
    assert json.loads(text)["numbers"] == [None, None, None, [1.0, None], 3]


def test_what_json_does_not_know_is_named():
    with pytest.raises(DataError, match=r"record\.estimates\.a\[1\]: object has no place"):
        plain({"estimates": {"a": [1, object()]}})


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
        lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
        max_leaves=20,
    )
)
def test_plain_values_are_always_valid_json(value):
    once = plain(value)
    assert json.loads(json.dumps(once, allow_nan=False)) == once


def test_slugs_are_those_of_the_contract():
    assert slug("EKF(3) known") == "ekf-3-known"
    assert slug("WLS(house)") == "wls-house"


def test_a_new_run_replaces_the_old_one(run):
    write_run(run, RECORD | {"title": "second"}, {})
    record, signals = read_run(run)
    assert (record["title"], signals) == ("second", {})
    assert not (run / "identification.parquet").exists()
    assert leftovers(run.parent) == []


@pytest.mark.parametrize("failing", ["to_parquet", "rename"])
def test_a_full_disk_loses_nothing(run, monkeypatch, failing):
    full = OSError(errno.ENOSPC, "No space left on device")

    def fail(self, *_, **__):
        raise full

    def fail_for_new(self, target):
        if self.name.endswith(".new"):
            raise full
        return rename(self, target)

    rename = Path.rename
    if failing == "rename":
        monkeypatch.setattr(Path, "rename", fail_for_new)
    else:
        monkeypatch.setattr(pd.DataFrame, "to_parquet", fail)
    with pytest.raises(DataError, match="No space left on device; nothing was changed") as caught:
        write_run(run, RECORD | {"title": "second"}, {"identification": TABLE})
    assert "\n" not in str(caught.value)
    assert "title" not in read_run(run)[0]
    assert leftovers(run.parent) == []


def test_a_page_that_cannot_be_written_leaves_the_old_one(tmp_path, monkeypatch):
    page = tmp_path / "index.html"
    page.write_text("old")

    def fail(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(DataError, match="index.html: No space left"):
        write_text(page, "new")
    assert page.read_text() == "old"
    assert leftovers(tmp_path) == []


@pytest.mark.parametrize("stem", ["../escape", "a/b", "", "Upper", "x.parquet"])
def test_signal_names_stay_inside_the_folder(tmp_path, stem):
    with pytest.raises(DataError, match="not a file name"):
        write_run(tmp_path / "run", RECORD, {stem: TABLE})


def corrupt(run: Path, name: str, text: str) -> None:
    (run / name).write_text(text)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("result.json", "{", r"result\.json: cannot be read \(Expecting property name"),
        ("result.json", "[]", r"result\.json: schema None, this version reads 1"),
        ("result.json", '{"schema": 99}', r"result\.json: schema 99, this version reads 1; run the experiment again"),
        ("result.json", '{"schema": 1, "run_id": "r"}', r"result\.json: `experiment` is missing"),
        ("identification.parquet", "not parquet", r"identification\.parquet: not what the run wrote"),
    ],
)
def test_a_broken_file_is_named_in_one_line(run, name, text, message):
    corrupt(run, name, text)
    with pytest.raises(DataError, match=message) as caught:
        read_run(run)
    assert "\n" not in str(caught.value)


def test_a_missing_folder_record_or_table_is_named(run):
    with pytest.raises(DataError, match="nowhere: not found; give the folder that holds result.json"):
        read_run(run.parent / "nowhere")
    (run / "identification.parquet").unlink()
    with pytest.raises(DataError, match=r"identification\.parquet: not found; the run folder is incomplete"):
        read_run(run)
    (run / "result.json").unlink()
    with pytest.raises(DataError, match=r"result\.json: not found"):
        read_run(run)


def test_a_record_cannot_point_outside_its_folder(run):
    record = json.loads((run / "result.json").read_text())
    record["signals"] = ["../secret"]
    corrupt(run, "result.json", json.dumps(record))
    with pytest.raises(DataError, match="not a file name"):
        read_run(run)


def test_a_signal_table_that_was_changed_is_refused_though_it_can_be_read(run):
    pd.read_parquet(run / "identification.parquet").mul(2.0).to_parquet(run / "identification.parquet")
    with pytest.raises(DataError, match=r"identification\.parquet: not what the run wrote \(another SHA-256\)"):
        read_run(run)


def test_a_record_from_before_hashes_is_read(run):
    record = json.loads((run / "result.json").read_text())
    assert record.pop("signals_sha256").keys() == set(record["signals"])
    (run / "result.json").write_text(json.dumps(record))
    pd.read_parquet(run / "identification.parquet").mul(2.0).to_parquet(run / "identification.parquet")
    assert "identification" in read_run(run)[1]


FULL = """
import resource, signal, sys
from pipeline.errors import DataError
from pipeline.report.page import write_page
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (10000, 10000))
try:
    write_page(sys.argv[1])
except DataError as error:
    print(error)
"""


def test_a_disk_that_fills_at_the_page_leaves_the_run_whole(run):
    """A limit on the size of files stands in for a full disk."""
    before = sorted(p.name for p in run.iterdir())
    result = subprocess.run([sys.executable, "-c", FULL, str(run)], capture_output=True, text=True)
    assert f"nothing was changed, make room, then `fmuid report {run}` remakes it" in result.stdout, result.stderr
    assert sorted(p.name for p in run.iterdir()) == before
    read_run(run)
