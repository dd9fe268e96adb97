"""Elementary functions are computed anew only where their argument has changed: no bit depends on what came before."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.export.language import archive_of

FUNCTIONS = ("sin", "cos", "tan", "atan", "asin", "acos", "sinh", "cosh", "tanh", "exp")
IN_NUMPY = (np.sin, np.cos, np.tan, np.arctan, np.arcsin, np.arccos, np.sinh, np.cosh, np.tanh, np.exp)
RATES = [*(f"{function}(x)" for function in FUNCTIONS), "log(2 + x)", "log10(p + x)"]
MODEL = f"""
model M
  parameter Real p=3;
  Real x(start=0, fixed=true);
  Real y[{len(RATES)}](each start=0, each fixed=true);
equation
  der(x) = cos(y[1]);
  der(y) = {{{", ".join(RATES)}}};
end M;
"""
ORDER = (0.0, -0.0, 0.0, 0.3, 0.3, -0.7, 0.3, 0.0)


@pytest.fixture(scope="module", params=["2", "3"])
def archive(request, tmp_path_factory):
    archive = archive_of(tmp_path_factory.mktemp("functions"), MODEL, fmi=request.param)
    yield archive
    archive.close()


def rates(instance, x):
    """The derivatives as bytes where the first state is x and the others are 0."""
    return instance.rhs(0.0, np.append(x, np.zeros(len(RATES)))).tobytes()


def test_the_bits_are_the_same_whatever_was_asked_before(archive):
    with archive.model_exchange() as used:
        for x in ORDER:
            with archive.model_exchange() as fresh:
                assert rates(used, x) == rates(fresh, x), x
        assert rates(used, 0.0) != rates(used, -0.0)


def test_what_is_not_a_number_is_refused_each_time_and_forgotten(archive):
    with archive.model_exchange() as instance:
        for x in (np.nan, np.nan, 0.3, np.nan):
            if np.isnan(x):
                with pytest.raises(FMICallException):
                    rates(instance, x)
            else:
                found = np.frombuffer(rates(instance, x))
    assert found == pytest.approx([1.0, *(f(0.3) for f in IN_NUMPY), np.log(2.3), np.log10(3.3)], rel=1e-14)


def test_a_restored_state_gives_the_same_bits(archive):
    with archive.model_exchange() as instance:
        first, frozen = rates(instance, 0.3), instance.save()
        rates(instance, -0.7)
        instance.load(frozen)
        assert rates(instance, 0.3) == first
