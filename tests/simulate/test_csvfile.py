"""CSV files as the world writes them: the same numbers come back, or one line says what decides."""

import csv
import io

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from pipeline.errors import DataError
from pipeline.simulate.csvfile import GROUP, find_decimal
from pipeline.simulate.tables import read_table

finite = st.floats(allow_nan=False, allow_infinity=False, width=64)
numbers = st.one_of(finite, st.integers(-10_000, 10_000).map(float), finite.map(lambda x: round(x, 3) + 0.0))
on_one_file = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
NAMES = st.sampled_from(["t", "q_1 [rad]", "Winkel, gemessen", "Weg; mm", "Kraft [N]", "a b", "Prüfung", 'in "quotes"'])


def written(names, values, delimiter, decimal, end, quoting, text=repr):
    """The file's text as a program with these habits writes it."""
    out = io.StringIO(newline="")
    writer = csv.writer(out, delimiter=delimiter, lineterminator=end, quoting=quoting)
    writer.writerow(names)
    writer.writerows([text(x).replace(".", decimal) for x in row] for row in values)
    return out.getvalue()


def refusal(path, **options):
    with pytest.raises(DataError) as caught:
        read_table(path, **options)
    message = str(caught.value)
    assert len(message.splitlines()) == 1 and path.name in message
    return message


@on_one_file
@given(
    names=st.lists(NAMES, min_size=2, max_size=4, unique=True),
    data=st.data(),
    delimiter=st.sampled_from([",", ";", "\t"]),
    decimal=st.sampled_from([".", ","]),
    end=st.sampled_from(["\n", "\r\n", "\r"]),
    quoting=st.sampled_from([csv.QUOTE_MINIMAL, csv.QUOTE_ALL, csv.QUOTE_NONNUMERIC]),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]),
)
def test_any_table_comes_back_or_is_refused_as_open(tmp_path, names, data, delimiter, decimal, end, quoting, encoding):
    row = st.lists(numbers, min_size=len(names), max_size=len(names))
    values = data.draw(st.lists(row, min_size=1, max_size=12))
    path = tmp_path / "a.csv"
    path.write_bytes(written(names, values, delimiter, decimal, end, quoting).encode(encoding))
    forced = {"delimiter": delimiter, "decimal": decimal}
    given_keys = read_table(path, **forced)
    for j, name in enumerate(names):
        np.testing.assert_array_equal(given_keys.column(name), [row[j] for row in values])
    try:
        found = read_table(path)
    except DataError as error:
        assert "data.delimiter" in str(error) or "data.decimal" in str(error)
        return
    for j, name in enumerate(names):
        np.testing.assert_array_equal(found.column(name), [row[j] for row in values])


@on_one_file
@given(
    values=st.lists(st.tuples(finite, finite, finite), min_size=1, max_size=8),
    decimal=st.sampled_from([".", ","]),
    gap=st.sampled_from([" ", "   ", "  "]),
    lead=st.sampled_from(["", "  "]),
)
def test_columns_set_apart_by_white_space_come_back(tmp_path, values, decimal, gap, lead):
    lines = [gap.join("tqu"), *(gap.join(repr(x).replace(".", decimal) for x in row) for row in values)]
    (tmp_path / "a.csv").write_text("\n".join(lead + line for line in lines) + "\n")
    table = read_table(tmp_path / "a.csv", decimal=decimal)
    np.testing.assert_array_equal(np.column_stack([table.column(c) for c in "tqu"]), values)


@on_one_file
@given(
    names=st.lists(NAMES, min_size=2, max_size=4, unique=True),
    data=st.data(),
    decimal=st.sampled_from([".", ","]),
    end=st.sampled_from(["\n", "\r\n"]),
)
def test_pandas_own_blanks_with_quoted_headings_come_back(tmp_path, names, data, decimal, end):
    row = st.lists(numbers, min_size=len(names), max_size=len(names))
    frame = pd.DataFrame(data.draw(st.lists(row, min_size=1, max_size=8)), columns=names, dtype=float)
    frame.to_csv(tmp_path / "a.csv", sep=" ", index=False, decimal=decimal, lineterminator=end)
    table = read_table(tmp_path / "a.csv", delimiter=" ", decimal=decimal)
    assert list(table.columns) == names
    for name in names:
        np.testing.assert_array_equal(table.column(name), frame[name])


def test_blanks_with_quoted_headings_are_found(tmp_path):
    (tmp_path / "a.csv").write_text('"time [s]" "q_1 [rad]" note\n0.0 1.5 x\n0.1 "2.5" y\n')
    table = read_table(tmp_path / "a.csv")
    assert list(table.columns) == ["time [s]", "q_1 [rad]", "note"] and list(table.column("q_1 [rad]")) == [1.5, 2.5]


@pytest.mark.parametrize("header", ['"time [s]" "q_1', '"time [s]"q_1', 'a"b c'])
def test_stray_quotes_are_refused_with_the_key_that_may_help(tmp_path, header):
    (tmp_path / "a.csv").write_text(f"{header}\n0 1\n")
    for delimiter in (None, " ") if header[0] == '"' else (" ",):
        assert '`data.delimiter` (" " for white space)' in refusal(tmp_path / "a.csv", delimiter=delimiter)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("t;q;u\n0,001;1,5;-2,25e-3\n", [0.001, 1.5, -0.00225]),
        ('t,q,u\n"0,001","1,5","-2,25"\n', [0.001, 1.5, -2.25]),
        ("t\tq\tu\n0,5\t1\t2\n", [0.5, 1.0, 2.0]),
        ("t;q;u\n0.001;1.500;2.000\n", [0.001, 1.5, 2.0]),
        ("t;q;u\n1;2;3\n", [1.0, 2.0, 3.0]),
        ("  t   q u\n  0.001 1.5  2\n", [0.001, 1.5, 2.0]),
        ("t,q,u\n1.500,2.500,3.500\n", [1.5, 2.5, 3.5]),
        ("Zeit, s\tWeg, mm\tKraft, N\n0,1\t2,5\t3,5\n", [0.1, 2.5, 3.5]),
        ("t;q;u;note\n0,1;2,5;3,5;good, so far\n", [0.1, 2.5, 3.5]),
    ],
)
def test_delimiter_and_decimal_sign_are_found_from_the_rows(tmp_path, text, expected):
    (tmp_path / "a.csv").write_text(text)
    table = read_table(tmp_path / "a.csv")
    assert [table.column(name)[0] for name in list(table.columns)[:3]] == expected


@pytest.mark.parametrize(
    ("text", "forced", "words"),
    [
        ("t;q\n1,500;2,500\n", {}, "`1,500` in row 2 may have a decimal sign or a thousands separator"),
        ("t;q\n1.500;2.500\n", {}, "`1.500` in row 2 may have a decimal sign or a thousands separator"),
        ('t,q\n"1,500",2\n', {}, "say which by `data.decimal`"),
        ("t;q\n0,5;2.25\n", {}, "`0,5` in row 2 has a decimal comma, `2.25` in row 2 a decimal point"),
        ("a,b;c\n1,2;3\n", {}, None),
        ("a;b,c\nx,y;z\n", {}, "can be divided at `,` or `;`; say which by `data.delimiter`"),
        ("t;q\n0,5;1.234,5\n", {}, "'1.234,5' is not a number; the decimal sign here is `,`, and thousands are not"),
        ("t;q\n0.5;1,234.5\n", {}, "'1,234.5' is not a number; the decimal sign here is `.`"),
        ("t;q\n0.5;1,234\n", {}, "'1,234' is not a number; the decimal sign here is `.`, and thousands are not"),
        ("t;q\n0,5;1 234,5\n", {}, "'1 234,5' is not a number; the decimal sign"),
        ("t;q\n0,5;1'234,5\n", {}, "is not a number; the decimal sign"),
        ("t;q\n0.5;1.5\n", {"decimal": ","}, "'0.5' is not a number; the decimal sign here is `,`"),
        ("t;q\n0.5;1.5\n", {"delimiter": ","}, "no column `t`"),
        ("t,q\n0,5,1,5\n", {}, "row 2 has 4 cells, the header 2"),
        ("1,5;2,5\n0,5;1,5\n", {}, "row 1 holds numbers"),
    ],
)
def test_what_can_be_read_two_ways_is_refused_with_the_key_that_decides(tmp_path, text, forced, words):
    path = tmp_path / "a.csv"
    path.write_text(text)
    if words is None:
        assert read_table(path).column("a,b")[0] == 1.2
        return
    with pytest.raises(DataError) as caught:
        table = read_table(path, **forced)
        for name in ("t", "q"):
            table.column(name)
    assert words in str(caught.value) and "\n" not in str(caught.value)


@given(st.floats(1.0, 999.999).map(lambda x: f"{x:.3f}"), st.sampled_from([".", ","]))
@example("1.234", ",")
def test_three_digits_behind_the_only_sign_are_never_guessed(text, sign):
    cell = text.replace(".", sign)
    assert GROUP.fullmatch(cell)
    with pytest.raises(DataError, match="may have a decimal sign or a thousands separator"):
        find_decimal("a.csv", [["1", cell]], ";")
    assert find_decimal("a.csv", [["1", cell], ["2", f"0{sign}5"]], ";") == sign


@pytest.mark.parametrize(
    ("encoding", "text"),
    [
        ("cp1252", "Zeit;Drehwinkel [°];Kräfte [µN]\n0;1;2\n"),
        ("utf-16", "Zeit;Ω [°/s]\n0;1\n"),
        ("utf-8", "t;Ω\n0;1\n"),
    ],
)
def test_encodings_that_are_certain_are_read(tmp_path, encoding, text):
    (tmp_path / "a.csv").write_bytes(text.encode(encoding))
    assert list(read_table(tmp_path / "a.csv").columns) == text.split("\n")[0].split(";")


@pytest.mark.parametrize(
    "data",
    [
        "t,Угол\n0,1\n".encode("cp1251"),
        "t,µ\n0,1\n".encode("cp437"),
        "t,q\n0,1\n".encode("utf-16-le"),
        "t,q\n0,1\n".encode("utf-32"),
        b"\xff\xfet\x00,\x00q",
        b"t,q\n0,\x9d\n",
        "t,é\n0,1\n".encode("latin-1"),
    ],
)
def test_encodings_that_are_not_certain_are_refused(tmp_path, data):
    (tmp_path / "a.csv").write_bytes(data)
    assert "not text in UTF-8" in refusal(tmp_path / "a.csv")


@on_one_file
@given(st.binary(max_size=200))
def test_any_bytes_are_read_or_refused_in_one_line(tmp_path, content):
    (tmp_path / "a.csv").write_bytes(content)
    try:
        table = read_table(tmp_path / "a.csv")
        table.column(next(iter(table.columns)))
    except DataError as error:
        assert len(str(error).splitlines()) == 1
