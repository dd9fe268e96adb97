"""What cannot be exported is refused in one line that names it and, where the front end gives one, its place."""

import pytest

from pipeline.errors import ExportError
from tests.export.language import model_of

REFUSED = {
    "singular": ("Real x; Real y; equation x + y = time; 2*x + 2*y = 2;", "singular system of equations: [xy], [xy]"),
    "pre outside": (
        "discrete Real d(start=1, fixed=true); Real y=pre(d) + time;"
        "equation when sample(0, 1) then d = pre(d) + 1; end when;",
        r"y depends on pre\(d\) outside a when-clause",
    ),
    "too much fixed": (
        "Real x(start=1, fixed=true); Real y(start=1, fixed=true); equation der(x) = y; y = 2*x;",
        "init",
    ),
    "enumeration": ("type E = enumeration(a, b); parameter E e=E.b; Real x=time;", "e: its type enumeration"),
    "slice": ("Real a[3]={1, 2, time}; Real b[2]=a[2:3];", "array slice"),
    "warning": ('Real x=time; equation assert(x < 5, "high", AssertionLevel.warning);', "warning cannot be exported"),
    "assigned twice": ("Real x; equation x = 1; x = 2;", "refuses it"),
    "higher index": (
        "Real x; Real y; Real f; equation der(x) = y; der(y) = f;\n x = sin(time);",
        r"structurally singular \(rank 2 of 3\).*higher index.*M\.mo:2",
    ),
    "non-linear loop": ("Real x; Real y; equation x = cos(y);\n y = sin(x);", r"non-linear system.*: [xy], [xy]"),
    "no binding": ("parameter Real k; Real x(start=0, fixed=true); equation der(x) = k;", "parameter k has no value"),
    "fixed=false": (
        "parameter Real k(fixed=false); Real x(start=0); initial equation k = 2; equation der(x) = k;",
        r"parameter k: fixed=false",
    ),
    "too many initial equations": (
        "Real x(start=0, fixed=true); initial equation x = 1; equation der(x) = 1;",
        "initial equation|refuses it",
    ),
    "time event": ("Real x(start=0, fixed=true); equation der(x) = if time > 0.5 then 1 else 0;", "time event"),
    "floor": ("Real x=floor(time);", "floor cannot be exported"),
    "terminate": ('Real x=time; equation when x > 1 then terminate("end"); end when;', "terminate"),
    "string": ('parameter String s="a"; Real x=time;', r"variable s: its type string"),
    "delay": ("Real x=delay(time, 0.1);", "delay|refuses it"),
    "loop in a function": (
        "function f input Real x; output Real y; algorithm y := 0; for i in 1:3 loop y := y + x; end for; end f;"
        "Real x=f(time);",
        "only assignments",
    ),
    "external function": (
        'function f input Real x; output Real y; external "C" y = sin(x); end f; Real x=f(time);',
        "external function",
    ),
    "start from an input": (
        "input Real u; Real x(start=u, fixed=true); equation der(x) = 1;",
        "depends on u|refuses it",
    ),
    "sample of an expression": (
        "parameter Real T=1; discrete Real x; equation when sample(0, 2*T) then x = time; end when;",
        r"sample\(\) takes a number or a parameter",
    ),
    "two parameters for one period": (
        "parameter Real S=1; parameter Real T=1; discrete Real x; discrete Real y;"
        "equation when sample(0, S) then x = time; end when; when sample(0, T) then y = time; end when;",
        "two sample periods of 1 s",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_exported_is_refused_by_name(tmp_path, case):
    body, message = REFUSED[case]
    with pytest.raises(ExportError, match=message) as refusal:
        model_of(tmp_path, f"model M {body} end M;")
    assert "\n" not in str(refusal.value)
