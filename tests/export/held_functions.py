"""What the exporter holds of functions and records, by the rows of the table in modelica/README.md (see held.py)."""

import numpy as np

from tests.export.held import ivp

R = "record R Real a; Real b; end R;"

FUNCTIONS: dict[str, list[tuple]] = {
    "functions": [
        (
            f"{R} function f input Real x; input Real y=3; output Real z; protected Real t=x + y; algorithm z := t^2;"
            "end f; function g input Real x; output R r; algorithm r.a := x; r.b := f(x, y=1); end g; R r=g(time);"
            "function two input Real x; output Real a; output Real b[2]; algorithm a := x; b[1] := 2*x; b[2] := a;"
            "end two; Real z=f(time); Real p; Real q[2]; equation (p, q) = two(time + 1);",
            {"r.a": 1, "r.b": 4, "z": 16, "p": 2, "q[1]": 4, "q[2]": 2},
        ),
        (
            "function sort input Real u[:]; output Real a[size(u, 1)]; protected Real t; algorithm a := u;"
            "for i in 1:size(u, 1) - 1 loop for j in 1:size(u, 1) - 1 loop if a[j] > a[j + 1] then t := a[j];"
            " a[j] := a[j + 1]; a[j + 1] := t; end if; end for; end for; end sort; Real a[4]=sort({3, 2, time, -5});",
            dict(zip([f"a[{k}]" for k in (1, 2, 3, 4)], sorted([3, 2, 1, -5]), strict=True)),
        ),
        (
            "function mul input Real A[:, :]; input Real b[:]; output Real y[size(A, 1)]; protected Real t; algorithm"
            " for i in 1:size(A, 1) loop t := 0; for j in 1:size(A, 2) loop t := t + A[i, j]*b[j]; end for; y[i] := t;"
            "end for; end mul; function horner input Real c[:]; input Real x; output Real y; algorithm y := 0;"
            "for i in size(c, 1):-1:1 loop y := y*x + c[i]; end for; y := 2*y; end horner;"
            "function sat input Real u; output Real y; algorithm if u > 1 then y := 1; elseif u < -1 then y := -1;"
            "else y := u; end if; end sat; Real y[2]=mul([1, 2; 3, 4], {1, time}); Real h=horner({1, 2, 3}, 2*time);"
            "Real s=sat(3*time) + 10*sat(-time/2);",
            {"y[1]": 3, "y[2]": 7, "h": 2 * np.polyval([3, 2, 1], 2), "s": 1 - 5},
        ),
        (
            "function mass input Real q; output Real M[2, 2]; algorithm M[1, 1] := 3 + cos(q); M[1, 2] := q;"
            "M[2, 1] := M[1, 2]; M[2, 2] := 3; end mass; function part input Real u[:]; output Real T[2, 3]; algorithm"
            " for i in 1:2 loop for j in 1:3 loop T[i, j] := if i == j then u[i] else 10*i + j; end for; end for;"
            "T[2, :] := {T[1, 3], 2*T[2, 1], T[2, 3]}; end part; Real M[2, 2]=mass(time); Real T[2, 3]=part({5, time});"
            "Real a[2](each start=0, each fixed=true); equation M*der(a) = {1, time};",
            {
                **{"M[1,1]": 3 + np.cos(1), "M[1,2]": 1, "M[2,1]": 1, "M[2,2]": 3},
                "a[2]": ivp(lambda t, a: np.linalg.solve([[3 + np.cos(t), t], [t, 3]], [1, t]), 0, 0)[1],
                **{"T[1,1]": 5, "T[1,2]": 12, "T[2,1]": 13, "T[2,2]": 42, "T[2,3]": 23},
            },
        ),
    ],
    "records": [
        (
            "record P parameter Real a=1; parameter Real b=2*a; end P; model Q parameter P p; Real y=p.b*time; end Q;"
            "parameter P p0(a=5); Q q1; Q q2(p(a=4)); Q q3(p=p0); Q q4(p=P(a=6, b=7)); Q q5[2](p(a={1, 8}));"
            f"{R} R r[3]; Real s=sum(r.a); R c=r[2]; equation for i in 1:3 loop"
            " r[i].a = i*time; r[i].b = 2*i; end for;",
            {"q1.y": 2, "q2.y": 8, "q3.y": 10, "q4.y": 7, "q5[2].y": 16, "s": 6, "c.b": 4},
        )
    ],
}
