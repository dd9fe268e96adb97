"""The generated C: what is cut into parts computes the same bits, what is left out is missed by nobody."""

import re

import numpy as np
import pytest

from pipeline.export import c_text
from pipeline.export.codegen import generate
from tests.export.language import archive_of, model_of

COUPLED = """
model M
  parameter Real m=2;
  input Real u;
  Real x(start=0.3, fixed=true);
  Real v(start=-0.1, fixed=true);
  Real a[3];
equation
  der(x) = v*cos(x);
  der(v) = a[1] + a[2]*tanh(v);
  {{m, sin(x), 0.1}, {sin(x), 3, v}, {0.1, v, 2 + x^2}}*a = {u, x, exp(v)};
end M;
"""
POINTS = np.random.default_rng(0).uniform(-1, 1, (10, 2))


def answers(folder):
    """Bytes of derivatives, algebraic variables and directional derivatives at some points."""
    archive, found = archive_of(folder, COUPLED), []
    with archive.model_exchange(u=0.7) as instance:
        for x in POINTS:
            found += [instance.rhs(0.0, x), instance.get("a[1]", "a[2]", "a[3]")]
            found.append(instance.directional(["der(v)", "a[3]"], ["x", "v", "u"], [0.2, -0.5, 1.0]))
    archive.close()
    return np.concatenate(found).tobytes()


@pytest.mark.parametrize("part", [1, 7, 1000])
def test_a_function_in_parts_computes_the_same_bits(tmp_path, monkeypatch, part):
    whole = answers(tmp_path)
    monkeypatch.setattr(c_text, "LONG", 0)
    monkeypatch.setattr(c_text, "PART", part)
    assert "parts[]" in generate(model_of(tmp_path, COUPLED), "")["model.c"]
    assert answers(tmp_path) == whole


def test_the_code_holds_the_functions_of_the_model_and_nothing_of_casadi_s_own_importer(tmp_path):
    code = generate(model_of(tmp_path, COUPLED), "")["model.c"]
    defined = re.findall(r"^\w[\w* ]*?(\w+)\(.*\{", code, re.MULTILINE)
    assert {"model_derivatives", "model_start_adjoint"} <= set(defined)
    assert not [name for name in defined if re.search(r"_(n_in|n_out|work|checkout|incref|sparsity_out)$", name)]
    assert "? arg" not in code and "if (res" not in code


def test_every_elementary_function_has_a_place_of_its_own(tmp_path):
    files = generate(model_of(tmp_path, COUPLED), "")
    places = re.findall(r"recall\((?:sin|cos|tanh|exp), a\w+, w\+(\d+)\)", files["model.c"])
    assert list(map(int, places)) == [2 * k for k in range(len(places))]
    assert f"#define N_RECALLED {len(places)}\n" in files["model_counts.h"]
    assert not re.search(r"[^, ](?:sin|cos|tanh|exp)\(", files["model.c"])
