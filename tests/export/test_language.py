"""The language, row by row of the table in modelica/README.md: values through Co-Simulation, and the table itself."""

import re

import pytest

from pipeline.paths import ROOT
from tests.export.held import CONTINUOUS
from tests.export.held_events import EVENTS
from tests.export.held_functions import FUNCTIONS
from tests.export.language import archive_of
from tests.export.refused import REFUSED

HELD = CONTINUOUS | FUNCTIONS | EVENTS
CASES = [(row, k) for row, cases in HELD.items() for k in range(len(cases))]
ROW = re.compile(r"^\| (?P<construct>.+?) \| (?P<what>held|refused) \|.*\|$", re.MULTILINE)


def read(instance, name):
    """The value of a variable of any type."""
    variable = next(v for v in instance.archive.description.modelVariables if v.name == name)
    getter = {"Real": "getReal", "Integer": "getInteger", "Boolean": "getBoolean"}[variable.type]
    return getattr(instance.fmu, getter)([variable.valueReference])[0]


@pytest.mark.parametrize(("row", "k"), CASES)
def test_values_after_one_second(tmp_path, row, k):
    body, expected, *rest = HELD[row][k]
    archive = archive_of(tmp_path, f"model M {body} end M;")
    with archive.co_simulation(**(rest[0] if rest else {})) as instance:
        instance.step(0.0, 1.0)
        values = {name: read(instance, name) for name in expected}
    assert values == pytest.approx(expected, abs=1e-9)


def test_every_row_of_the_table_has_its_cases_and_every_case_its_row():
    text = (ROOT / "modelica" / "README.md").read_text()
    rows = [(match["construct"].replace("`", ""), match["what"]) for match in ROW.finditer(text)]
    assert len(rows) == len(set(rows))
    assert set(rows) == {(name, "held") for name in HELD} | {(name, "refused") for name in REFUSED}
