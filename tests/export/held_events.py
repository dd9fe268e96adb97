"""What the exporter holds of events and of discrete variables, by the rows of the table in modelica/README.md."""

import numpy as np

EVENTS: dict[str, list[tuple]] = {
    "if-expressions and if-equations": [
        (
            "Real x(start=0, fixed=true); Real y; Real z; equation der(x) = if x > 0.25 then 2 else 1;"
            "if x > 0.5 then y = 2; z = x; elseif x > 0.2 then y = 3; z = 1; else y = 1; z = 2; end if;",
            {"x": 0.25 + 2 * 0.75, "y": 2, "z": 1.75},
        ),
        (
            "Real x[2](start={0.3, 0.6}, each fixed=true); Real z(start=0, fixed=true); equation"
            " der(x) = if x[1] > 0.1 then {-1, -1} else {0, 1};"
            "der(z) = if z > 0.3 then (if z > 0.6 then 3 else 2) else 1;",
            {"x[1]": 0.1, "x[2]": 1.2, "z": 0.6 + 3 * (1 - 0.3 - 0.15)},
        ),
    ],
    "noEvent, smooth, homotopy, semiLinear": [
        (
            "Real x(start=4, fixed=true); Real y=smooth(1, if time < 0.5 then 0 else (time - 0.5)^2);"
            "Real s=semiLinear(time - 0.5, 2, 3); Real h=homotopy(time, 0);"
            "equation der(x) = -sqrt(noEvent(if x > 0 then x else 0));",
            {"x": 2.25, "y": 0.25, "s": 1, "h": 1},
        )
    ],
    "time events": [
        (
            "parameter Real t0=0.3; Real x(start=0, fixed=true); discrete Real n(start=0.2, fixed=true);"
            "discrete Integer k(start=0, fixed=true); equation der(x) = if time - t0 > 0.25 then 1 else 0;"
            "when time >= pre(n) then n = pre(n) + 0.3; k = pre(k) + 1; end when;",
            {"x": 0.65, "n": 1.1, "k": 3},
            {"t0": 0.1},
        ),
        (
            "parameter Real a=0.5; parameter Real b=0.5; Real x(start=0, fixed=true); Real y(start=0, fixed=true);"
            "Real z(start=0, fixed=true); equation der(x) = if a <= time then 1 else 0;"
            "der(y) = if 2*time < 2*b then 1 else 0; der(z) = if time > 0.3 and time < 0.300001 then 1e6 else 0;",
            {"x": 0.5, "y": 0.3, "z": 1},
            {"b": 0.3},
        ),
    ],
    "when, elsewhen, pre, edge, change": [
        (
            "discrete Real t0(start=0, fixed=true); Boolean on=sin(20*time) > 0; equation when on then t0 = time;"
            "end when;",
            {"t0": 0.3 * np.pi},
        ),
        (
            "Real x(start=0, fixed=true); Boolean b; discrete Real d(start=0, fixed=true);"
            "discrete Real n(start=0, fixed=true); discrete Real m(start=0, fixed=true);"
            "Boolean on(start=false, fixed=true); Real h(start=0, fixed=true); equation der(x) = 1;"
            "b = sin(10*x) > 0.3; when edge(b) then n = pre(n) + 1; end when; when change(b) then m = pre(m) + 1;"
            "end when; when {x > 0.3, x > 0.5} then d = pre(d) + 1; elsewhen x > 0.8 then d = 10*pre(d); end when;"
            "on = if pre(on) then h > 0.1 else h > 0.3; der(h) = if on then -1 else 1;",
            {"n": 2, "m": 4, "d": 20, "h": 0.2},
        ),
        (
            "Real x(start=0, fixed=true); discrete Real d(start=0, fixed=true); Real y=d + x;"
            "discrete Real e(start=0, fixed=true); equation der(x) = 1; when x > 0.5 then d = 10; end when;"
            "when y > 5 then e = pre(e) + 1; end when;",
            {"d": 10, "e": 1},
        ),
    ],
    "reinit": [
        (
            "Real x[2](each start=0, each fixed=true); Real y(start=0, fixed=true); equation der(x) = {1, 2};"
            "der(y) = 1; when x[1] > 0.5 then reinit(x, {0, 5}); end when; when y > 0.3 then reinit(y, pre(y) - 0.2);"
            "end when;",
            {"x[1]": 0.5, "x[2]": 6, "y": 0.2},
        )
    ],
    "sample": [
        (
            "parameter Real T=0.25; discrete Real d(start=0, fixed=true); discrete Real c(start=0, fixed=true);"
            "discrete Real n(start=0, fixed=true); Boolean b=sample(0, 0.3); equation when sample(T/2, 2*T) then"
            " d = pre(d) + 1; end when; when sample(0, 0.45) and time > 0.4 then c = time; end when;"
            "when b then n = pre(n) + 1; end when;",
            {"d": 5, "c": 0.9, "n": 4},
            {"T": 0.1},
        ),
        (
            "model J parameter Real Ts=0.1; input Real u; discrete output Real y(start=0, fixed=true);"
            "equation when sample(0, Ts) then y = pre(y) + u; end when; end J;"
            "parameter Real T=0.2; J a(Ts=T); J b(Ts=T); equation a.u = 1; b.u = a.y;",
            {"a.y": 5, "b.y": 15},
        ),
    ],
    "initial()": [
        (
            "discrete Real n(start=0, fixed=true); equation when {initial(), time > 0.5} then"
            " n = pre(n) + (if initial() then 10 else 1); end when;",
            {"n": 11},
        )
    ],
    "assert": [
        (
            'Real x(start=0, fixed=true); equation der(x) = 1; assert(x < 5, "high");'
            'assert(x < 0.5, "rather high", AssertionLevel.warning);',
            {"x": 1},
        )
    ],
    "enumerations": [
        (
            "type S = enumeration(idle, run, stop); S s(start=S.idle, fixed=true); parameter S p=S.run;"
            "Real k[S]={1, 2, 3}*time; Real x(start=0, fixed=true); Integer i=Integer(p); Real y; equation"
            " der(x) = if s == S.run then 1 else 0; when time >= 0.25 then s = S.run;"
            " elsewhen x >= 0.5 then s = S.stop;"
            "end when; if p == S.run then y = k[S.stop]; else y = 0; end if;",
            {"x": 0.5, "s": 3, "p": 2, "i": 2, "y": 3},
        )
    ],
    "Boolean and Integer variables": [
        (
            "parameter Integer n=3; parameter Integer m=n + 1; parameter Boolean on=true; Boolean b=time > 0.5;"
            "Integer i=if b and not time > 2 then m else 0; Real y=if on then n/2 else time; Real x[n]=fill(time, n);",
            {"b": 1, "i": 4, "y": 1.5, "x[3]": 1},
        ),
        (
            "discrete Integer k(start=0, fixed=true); Real x(start=0, fixed=true);"
            "equation when sample(0, 0.25) then k = pre(k) + 1; end when; der(x) = if k == 2 then 1 else 0;",
            {"x": 0.25},
        ),
    ],
    "algorithm sections": [
        (
            "Real y[3]; Real z; discrete Real d(start=0, fixed=true); algorithm for i in 1:3 loop y[i] := i*time;"
            "end for; algorithm z := 1; if time > 0.5 then z := 2*z; end if;"
            "algorithm when time > 0.3 then d := d + 1; end when;",
            {"y[3]": 3, "z": 2, "d": 1},
        ),
        (
            "Real x(start=0, fixed=true); discrete Real d(start=0, fixed=true); discrete Real c(start=0, fixed=true);"
            "discrete Integer n(start=0, fixed=true); discrete Real s(start=0, fixed=true); equation der(x) = 1;"
            "algorithm when x > 0.5 then d := d + 1; c := d*2; d := d + c; n := n + 1; n := 2*n; elsewhen x > 0.7 then"
            " d := pre(d) + 10; end when; equation when sample(-0.1, 0.3) then s = pre(s) + 1; end when;",
            {"c": 2, "d": 13, "n": 2, "s": 3},
        ),
    ],
    "floor, ceil, integer": [
        (
            "parameter Real a=7.5; Integer i=integer(-a); Real c=ceil(a) + floor(a); Real f=noEvent(floor(3.5*time));"
            "discrete Real n(start=0, fixed=true); Real m=floor(n/2); equation when sample(0, 0.2) then n = pre(n) + 1;"
            "end when;",
            {"i": -9, "c": 17, "f": 3, "m": 2},
            {"a": 8.75},
        )
    ],
}
