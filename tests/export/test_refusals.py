"""What cannot be exported is refused in one line that names it and, where the front end gives one, its place."""

import pytest

from pipeline.errors import ExportError
from tests.export.language import model_of
from tests.export.refused import REFUSED

CASES = [(row, k) for row, cases in REFUSED.items() for k in range(len(cases))]


@pytest.mark.parametrize(("row", "k"), CASES)
def test_what_cannot_be_exported_is_refused_by_name(tmp_path, row, k):
    body, message = REFUSED[row][k]
    with pytest.raises(ExportError, match=message) as refusal:
        model_of(tmp_path, f"model M {body} end M;")
    assert "\n" not in str(refusal.value)
