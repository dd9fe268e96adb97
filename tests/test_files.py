"""Files that appear whole or not at all."""

import os
from pathlib import Path

import pytest

from pipeline.files import check_writable, replacing


def test_a_file_is_replaced_when_the_block_ends_well(tmp_path):
    path = tmp_path / "a.txt"
    for text in ("one", "two"):
        with replacing(path) as fresh:
            fresh.write_text(text)
            assert fresh.parent == tmp_path and fresh != path
        assert path.read_text() == text and os.listdir(tmp_path) == ["a.txt"]


def test_a_block_that_fails_changes_nothing_and_leaves_nothing(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(OSError, match="full"), replacing(path) as fresh:
        fresh.write_text("half")
        raise OSError("full")
    assert path.read_text() == "old" and os.listdir(tmp_path) == ["a.txt"]


def test_a_block_that_writes_nothing_is_an_error(tmp_path):
    with pytest.raises(OSError, match="No such file"), replacing(tmp_path / "a.txt"):
        pass


def test_a_link_stays_a_link_and_a_device_a_device(tmp_path):
    (tmp_path / "target").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "target")
    with replacing(tmp_path / "link") as fresh:
        fresh.write_text("new")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "target").read_text() == "new"
    with replacing(Path("/dev/null")) as fresh:
        fresh.write_text("anything")
    assert not os.path.isfile("/dev/null")


def test_what_cannot_be_written_is_known_before(tmp_path):
    (tmp_path / "old").write_text("old")
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "new", tmp_path / "old", tmp_path / "pipe", Path("/dev/null")):
        check_writable(path)
    for path in (tmp_path, tmp_path / "none" / "new", Path("/proc/new")):
        with pytest.raises(OSError):
            check_writable(path)
    assert sorted(os.listdir(tmp_path)) == ["old", "pipe"] and (tmp_path / "old").read_text() == "old"
