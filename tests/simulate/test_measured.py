"""Measured files: round trips, unit conversion, and a refusal that names file, column and row for every defect."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from pipeline.errors import ConfigError, DataError
from pipeline.simulate.measured import ColumnSettings, read_measured, with_force

COLUMNS = {
    "time": ColumnSettings("t", "s", "s"),
    "q_1": ColumnSettings("position", "rad", "rad"),
    "u_1": ColumnSettings("torque", "N.m", "N.m"),
}
finite = st.floats(allow_nan=False, allow_infinity=False, width=64)
on_one_file = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def lines(N=20, rate=100.0):
    """A good file's lines, header first."""
    return ["t,position,torque", *(f"{k / rate},{0.1 * k},{np.sin(k)}" for k in range(N))]


def write(path, text):
    path.write_text(text if isinstance(text, str) else "\n".join(text) + "\n", encoding="utf-8")
    return path


def refusal(path, columns=COLUMNS, rate=100.0, **options):
    """The one line with which the file is refused."""
    with pytest.raises(DataError) as caught:
        read_measured(path, columns, rate, **options)
    message = str(caught.value)
    assert len(message.splitlines()) == 1 and path.name in message
    return message


@on_one_file
@given(st.lists(st.tuples(finite, finite), min_size=2, max_size=30), st.sampled_from([",", ";", "\t"]))
def test_frames_survive_a_round_trip_through_csv(tmp_path, values, delimiter):
    q, u = np.array(values).T
    time = np.arange(len(q)) / 100.0
    frame = pd.DataFrame({"t": time, "position": q, "torque": u})
    frame.to_csv(tmp_path / "a.csv", index=False, sep=delimiter)
    back = read_measured(tmp_path / "a.csv", COLUMNS, 100.0)
    np.testing.assert_array_equal(back["q_1"], q)
    np.testing.assert_array_equal(back["u_1"], u)
    np.testing.assert_array_equal(back.index, time)
    assert back.index.name == "time"


@on_one_file
@given(st.lists(st.tuples(finite, finite), min_size=2, max_size=30), st.sampled_from(["row", "column"]))
def test_frames_survive_a_round_trip_through_mat(tmp_path, values, oned_as):
    q, u = np.array(values).T
    time = np.arange(len(q)) / 100.0
    savemat(tmp_path / "a.mat", {"t": time, "position": q, "torque": u}, oned_as=oned_as)
    back = read_measured(tmp_path / "a.mat", COLUMNS, 100.0)
    np.testing.assert_array_equal(back[["q_1", "u_1"]].to_numpy(), np.column_stack([q, u]))


@on_one_file
@given(
    row=st.integers(1, 20),
    column=st.integers(0, 2),
    junk=st.sampled_from(
        ["", " ", "nan", "NaN", "inf", "-Infinity", "1e999", "abc", "1_000", "0x10", "1.2.3", "#N/A", "--"]
    ),
)
def test_any_single_corrupted_cell_is_refused_with_column_and_row(tmp_path, row, column, junk):
    text = lines()
    cells = text[row].split(",")
    cells[column] = junk
    text[row] = ",".join(cells)
    message = refusal(write(tmp_path / "a.csv", text))
    assert f"column `{('t', 'position', 'torque')[column]}`, row {row + 1}:" in message


@on_one_file
@given(row=st.integers(1, 20), change=st.sampled_from([",1", ",", None]))
def test_any_ragged_row_is_refused_with_its_number(tmp_path, row, change):
    text = lines()
    text[row] = text[row] + change if change else text[row].rpartition(",")[0]
    assert f"row {row + 1} has {4 if change else 2} cells, the header 3" in refusal(write(tmp_path / "a.csv", text))


@on_one_file
@given(row=st.integers(1, 18), shift=st.sampled_from([-2.0, -1.0, -0.6, 0.6, 1.0, 7.0]))
def test_any_displaced_time_stamp_is_refused_near_its_row(tmp_path, row, shift):
    time = np.arange(20) / 100.0
    time[row] += shift / 100.0
    text = [lines()[0], *(f"{t},0,0" for t in time)]
    message = refusal(write(tmp_path / "a.csv", text))
    assert f"column `t`, row {row + 2}:" in message or f"column `t`, row {row + 3}:" in message


@pytest.mark.parametrize(
    ("step", "words"),
    [(0.0, "repeats"), (-0.02, "goes back behind"), (0.03, "the time jumps"), (0.004, "the time jumps")],
)
def test_time_stamps_that_repeat_go_back_or_jump(tmp_path, step, words):
    time = np.concatenate([np.arange(10) / 100.0, 0.09 + step + np.arange(10) / 100.0])
    message = refusal(write(tmp_path / "a.csv", ["t,position,torque", *(f"{t:.6f},0,0" for t in time)]))
    assert words in message and "row 12" in message


@pytest.mark.parametrize("rate", [10.0, 50.0, 99.0, 101.0, 125.0, 1000.0])
def test_another_sample_rate_is_refused(tmp_path, rate):
    message = refusal(write(tmp_path / "a.csv", lines(40, rate)))
    assert f"sampled at {rate:g} Hz, the experiment says 100 Hz" in message


def test_a_little_jitter_of_the_time_stamps_is_accepted(tmp_path):
    time = np.arange(50) / 100.0 + 1e-3 * np.random.default_rng(0).uniform(-1, 1, 50)
    time[[0, -1]] = 0.0, 0.49
    path = write(tmp_path / "a.csv", ["t,position,torque", *(f"{t},0,0" for t in time)])
    np.testing.assert_array_equal(read_measured(path, COLUMNS, 100.0).index, time)


def test_units_scale_and_offset(tmp_path):
    columns = {
        "time": ColumnSettings("t", "ms", "s"),
        "q_1": ColumnSettings("position", "deg", "rad", scale=-2.0, offset=0.5),
        "u_1": ColumnSettings("torque", "N.cm", "N.m"),
    }
    path = write(tmp_path / "a.csv", ["t,position,torque,remark", "0,0,100,good", "10,90,250,so-so"])
    frame = read_measured(path, columns, 100.0)
    np.testing.assert_allclose(frame.index, [0.0, 0.01])
    np.testing.assert_allclose(frame["q_1"], [0.5, 0.5 - np.pi])
    np.testing.assert_allclose(frame["u_1"], [1.0, 2.5])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the file is empty"),
        ("\n\n", "holds no header"),
        ("t,position,torque\n", "0 samples"),
        ("t,position,torque\n0,0,0\n", "1 samples, the experiment needs 2"),
        ("t,Position,torque\n0,0,0\n0.01,0,0\n", "no column `position`; nearest: `Position`"),
        ("t,x,y\n0,0,0\n0.01,0,0\n", "no column `position`; it has `t`, `x`, `y`"),
        ("t,position,torque,t\n0,0,0,0\n", "column `t` stands twice in row 1"),
        ("t,position,,torque\n0,0,0,0\n", "column 3 has no name in row 1"),
        ("0,0,0\n0.01,0,0\n", "row 1 holds numbers"),
        (
            "t;position;torque\n0;0;0\n0.01;1,5;0\n",
            "`1,5` in row 3 has a decimal comma, `0.01` in row 3 a decimal point",
        ),
        ('t,position,torque\n0,0,"0\n', "not a CSV file (unexpected end of data)"),
        ("t,position,torque\n0,0,0\n\n0.01,0,0\n", "row 3 has 0 cells"),
    ],
)
def test_wrong_csv_files_are_refused(tmp_path, text, words):
    assert words in refusal(write(tmp_path / "a.csv", text))


def test_a_byte_order_mark_and_trailing_empty_lines_are_no_defect(tmp_path):
    path = write(tmp_path / "a.csv", "\ufeff" + "\r\n".join([*lines(), "", " ", ""]))
    assert len(read_measured(path, COLUMNS, 100.0)) == 20


def test_a_missing_file_a_folder_and_an_unknown_format_are_refused(tmp_path):
    assert "no such file" in refusal(tmp_path / "none.csv")
    (tmp_path / "folder.csv").mkdir()
    assert "no such file" in refusal(tmp_path / "folder.csv")
    assert "format `xlsx` is not read" in refusal(tmp_path / "a.xlsx")


def test_the_format_can_be_given_apart_from_the_suffix(tmp_path):
    assert len(read_measured(write(tmp_path / "a.dat", lines()), COLUMNS, 100.0, format="csv")) == 20


def test_too_few_samples_for_the_experiment(tmp_path):
    assert "20 samples, the experiment needs 100" in refusal(write(tmp_path / "a.csv", lines()), min_samples=100)


@pytest.mark.parametrize(
    ("unit", "words"), [("furlong", "unit `furlong` is unknown"), ("m", "unit `m` does not convert to `rad`")]
)
def test_wrong_units_are_refused_with_the_column(tmp_path, unit, words):
    columns = COLUMNS | {"q_1": ColumnSettings("position", unit, "rad")}
    message = refusal(write(tmp_path / "a.csv", lines()), columns)
    assert words in message and "column `position`" in message


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"time": COLUMNS["time"]}, "`q_1` is not mapped"),
        ({"q_1": COLUMNS["q_1"]}, "`time` is not mapped"),
        (COLUMNS | {"q1": COLUMNS["q_1"]}, "`q1` is read by nothing; use time, q_1"),
        (COLUMNS | {"qd_1": COLUMNS["q_1"]}, "`qd_1` is read by nothing"),
    ],
)
def test_wrong_mappings_are_refused(tmp_path, columns, words):
    with pytest.raises(ConfigError, match=words):
        read_measured(write(tmp_path / "a.csv", lines()), columns, 100.0)


GOOD = {"t": np.arange(20) / 100.0, "position": np.zeros(20), "torque": np.zeros(20)}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"position": np.zeros((20, 2))}, "column `position` is a 20×2 array"),
        ({"position": np.zeros((20, 1, 1))}, "column `position` is a"),
        ({"position": "text"}, "column `position` holds text"),
        ({"position": np.zeros(20) + 1j}, "column `position` holds complex numbers"),
        ({"position": {"a": 1.0}}, "column `position` holds a structure"),
        ({"position": np.array([[1, "a"]], dtype=object)}, "column `position` holds cells"),
        ({"position": np.zeros(19)}, "column `position` has 19 samples, `t` 20"),
        ({"position": np.where(np.arange(20) == 7, np.nan, 0.0)}, "column `position`, row 8: nan is not a finite"),
        ({"torque": np.where(np.arange(20) == 0, -np.inf, 0.0)}, "column `torque`, row 1: -inf is not a finite"),
        ({"t": np.arange(20) / 100.0 + 0.05 * (np.arange(20) > 11)}, "column `t`, row 13: the time jumps"),
    ],
)
def test_wrong_mat_files_are_refused(tmp_path, change, words):
    savemat(tmp_path / "a.mat", GOOD | change)
    assert words in refusal(tmp_path / "a.mat")


def test_mat_integers_and_compressed_files_are_read(tmp_path):
    savemat(tmp_path / "a.mat", GOOD | {"torque": np.arange(20, dtype=np.uint8)}, do_compression=True)
    np.testing.assert_array_equal(read_measured(tmp_path / "a.mat", COLUMNS, 100.0)["u_1"], np.arange(20.0))


def test_mat_files_of_other_versions_are_refused_by_name(tmp_path):
    path = tmp_path / "a.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM" + b"\x89HDF\r\n\x1a\n")
    assert "MAT v7.3 (HDF5)" in refusal(path)
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(600))
    assert "MAT v7.3 (HDF5)" in refusal(path)
    savemat(path, GOOD, format="4")
    assert "not a MAT v5 file" in refusal(path)
    path.write_bytes(b"")
    assert "the file is empty" in refusal(path)


@on_one_file
@given(st.binary(min_size=1, max_size=300))
def test_any_bytes_that_are_no_mat_file_are_refused(tmp_path, content):
    (tmp_path / "a.mat").write_bytes(content)
    assert "a MAT v" in refusal(tmp_path / "a.mat")


@on_one_file
@given(st.data())
def test_a_truncated_mat_file_is_refused(tmp_path, data):
    savemat(tmp_path / "whole.mat", GOOD)
    whole = (tmp_path / "whole.mat").read_bytes()
    (tmp_path / "a.mat").write_bytes(whole[: data.draw(st.integers(1, len(whole) - 9))])
    refusal(tmp_path / "a.mat")


def test_with_force_refuses_two_measurements_of_one_force():
    frame = pd.DataFrame({"q_1": [0.0], "u_1": [2.0], "tau_1": [6.0]})
    with pytest.raises(DataError, match="joint 1: both `u_1` and `tau_1` are mapped.*; map one"):
        with_force(frame, [35.0])


def test_with_force_applies_the_gain_either_way():
    frame = pd.DataFrame({"q_1": [0.0], "u_1": [2.0], "q_2": [0.0], "tau_2": [6.0]})
    full = with_force(frame, [35.0, 3.0])
    assert full["tau_1"].item() == 70.0 and full["u_2"].item() == 2.0
    assert "tau_1" not in frame
    with pytest.raises(DataError, match="joint 3: neither `u_3` nor `tau_3`"):
        with_force(frame, [1.0, 1.0, 1.0])


UNITS = {"time": "s", "q_1": "rad", "qr_1": "rad", "u_1": "N.m", "tau_1": "N.m"}


def headed(tmp_path, *names, N=20):
    """A file with a good time and one column more for each heading."""
    rows = [",".join([f"{k / 100}", *(f"{0.1 * k * (j + 1):.6g}" for j in range(len(names) - 1))]) for k in range(N)]
    return write(tmp_path / "a.csv", [",".join(names), *rows])


def test_the_unit_of_a_heading_serves_where_the_mapping_names_none(tmp_path):
    path = headed(tmp_path, "t (s)", "angle [deg]", "torque [N.cm]")
    columns = {
        "time": ColumnSettings("t", "", "s"),
        "q_1": ColumnSettings("angle", "", "rad", scale=-1.0),
        "u_1": ColumnSettings("torque [N.cm]", "N.cm", "N.m"),
    }
    frame = read_measured(path, columns, 100.0)
    np.testing.assert_allclose(frame["q_1"], -np.deg2rad(0.1 * np.arange(20)))
    np.testing.assert_allclose(frame["u_1"], 0.002 * np.arange(20))


@pytest.mark.parametrize(
    ("heading", "unit", "words"),
    [
        ("position [deg]", "rad", "column `position [deg]` is in `deg`, `data.columns.q_1` says `rad`; make them one"),
        ("position [m]", "rad", "column `position [m]` is in `m`, `data.columns.q_1` says `rad`; make them one"),
        ("position (deg)", "rad", "is in `deg`, `data.columns.q_1` says `rad`"),
        ("position", "", "has no unit; write `position [unit]` in the file, or a unit in `data.columns.q_1`"),
        ("position [counts]", "", "unit `counts` is unknown"),
        ("position [m]", "", "unit `m` does not convert to `rad`"),
    ],
)
def test_units_that_differ_or_lack_are_refused(tmp_path, heading, unit, words):
    path = headed(tmp_path, "t", heading, "torque")
    assert words in refusal(path, COLUMNS | {"q_1": ColumnSettings("position", unit, "rad")})


def test_two_spellings_of_one_unit_are_one_and_what_is_no_unit_gives_way(tmp_path):
    path = headed(tmp_path, "t [s]", "position [counts]", "torque [Nm]")
    np.testing.assert_allclose(read_measured(path, COLUMNS, 100.0)["u_1"], 0.2 * np.arange(20))


def test_a_name_that_two_columns_share_is_refused(tmp_path):
    path = headed(tmp_path, "t", "position [rad]", "position [deg]", "torque")
    assert "`position [rad]`, `position [deg]` are all called `position`; name one in full" in refusal(path)


def test_columns_that_the_file_names_need_no_mapping(tmp_path):
    path = headed(tmp_path, "time [ms]", "q_1 [deg]", "u_1 [N.m]", "tau_1 [N.m]", "qr_1", "q_2 [rad]", "note [m]")
    text = path.read_text().splitlines()
    path.write_text("\n".join([text[0], *(f"{10 * k},{line.split(',', 1)[1]}" for k, line in enumerate(text[1:]))]))
    frame = read_measured(path, {}, 100.0, units=UNITS)
    assert list(frame) == ["q_1", "u_1"], "one of u and tau; nothing without a unit, nothing the plant has not"
    np.testing.assert_allclose(frame["q_1"], np.deg2rad(0.1 * np.arange(20)))
    mapped = {"tau_1": ColumnSettings("note", "N.m", "N.m")}
    with pytest.raises(DataError, match=r"column `note \[m\]` is in `m`, `data.columns.tau_1` says `N.m`"):
        read_measured(path, mapped, 100.0, units=UNITS)
    mapped = {"tau_1": ColumnSettings("tau_1", "", "N.m", scale=-1.0)}
    assert list(read_measured(path, mapped, 100.0, units=UNITS)) == ["tau_1", "q_1"]


def test_a_position_that_is_neither_mapped_nor_named_is_refused(tmp_path):
    path = headed(tmp_path, "time [s]", "q_1", "u_1 [N.m]")
    with pytest.raises(ConfigError, match=r"`q_1` is not mapped, and a.csv has no column `q_1 \[unit\]`"):
        read_measured(path, {}, 100.0, units=UNITS)


def test_a_name_that_needs_no_mapping_stands_once(tmp_path):
    path = headed(tmp_path, "time [s]", "q_1 [rad]", "q_1 [deg]", "u_1 [N.m]")
    with pytest.raises(DataError, match=r"`q_1 \[rad\]`, `q_1 \[deg\]` are all called `q_1`; name one in full"):
        read_measured(path, {}, 100.0, units=UNITS)
