"""What the exporter holds of the language without events, by the rows of the table in modelica/README.md.

A case: the body of a model M, values after one second from SciPy or by hand, and parameters set before.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm


def ivp(f, *x0):
    """x(1) of x' = f(t, x), by SciPy's DOP853."""
    return solve_ivp(f, (0, 1), x0, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]


def turned(times):
    """{1, 2, 3} after so many solutions with a matrix that is not symmetric."""
    x = np.array([1.0, 2.0, 3.0])
    for _ in range(times):
        x = np.linalg.solve([[4, 1, 0], [1, 4, 3], [0, 1, 4]], x)
    return x


e, A = np.exp, np.array([[-1.0, 0.5], [2.0, -3.0]])
DECAY = "model D parameter Real k=1; Real x(start=1, fixed=true); equation der(x) = -k*x; end D;"
X_AND_Y = "model X parameter Real k=1; Real y=k*time; end X; model Y extends X(k=2); end Y;"
PIN = "connector P Real v; flow Real i; end P;"
RESISTOR = "model R P p; P n; parameter Real r=1; equation p.i + n.i = 0; p.v - n.v = r*p.i; end R;"
GROUND = "model G P p; equation p.v = 0; end G; model V P p; equation p.v = 6; end V;"

CONTINUOUS: dict[str, list[tuple]] = {
    "parameters and constants": [
        (
            f"{DECAY} parameter Real a=2; parameter Real b=3*a; final parameter Real c=b + 1; constant Real g=5;"
            "D d(k=c); D f(final k=g); Real y=g*time;",
            {"d.x": e(-13), "f.x": e(-5), "b": 12, "y": 5},
            {"a": 4},
        )
    ],
    "start values": [
        (
            "parameter Real a=3; parameter Real s[2]={1, a}; Real x[2](start=s, each fixed=true); Real z(start=2);"
            "equation der(x) = -x; der(z) = -2*z;",
            {"x[1]": e(-1), "x[2]": 5 * e(-1), "z": 2 * e(-2)},
            {"a": 5},
        )
    ],
    "initial equations, linear": [
        (
            "parameter Real a=3; Real x; Real y; discrete Real d; initial equation x = a^2; der(y) = 0; pre(d) = a;"
            "equation der(x) = -x; der(y) = x - 2*y; when sample(0, 0.5) then d = pre(d) + 1; end when;",
            {"x": 16 * e(-1), "y": ivp(lambda t, v: [-v[0], v[0] - 2 * v[1]], 16, 8)[1], "d": 6},
            {"a": 4},
        ),
        (
            "parameter Real a=2; Real x; Real y; initial equation a*x + y = 5; x - y = 1; equation der(x) = -y;"
            "der(y) = x;",
            {"x": ivp(lambda t, v: [-v[1], v[0]], *np.linalg.solve([[3, 1], [1, -1]], [5, 1]))[0]},
            {"a": 3},
        ),
        (
            "parameter Real a=3; Real x; Real v; Real y(start=1, fixed=true); Real z(start=2, fixed=true); initial"
            " equation x = 2*y + a*z; v = x + y; equation der(x) = -x; der(v) = -2*v; der(y) = 0; der(z) = 0;",
            {"x": (2 * 5 + 4 * 7) * e(-1), "v": (38 + 5) * e(-2), "y": 5, "z": 7},
            {"y": 5, "z": 7, "a": 4},
        ),
        (
            "parameter Real a=3; discrete Real d[2]; initial equation pre(d) = {a, 2*a};"
            "equation when sample(0, 0.25) then d = pre(d) + {1, 10}; end when;",
            {"d[1]": 7, "d[2]": 46},
        ),
    ],
    "arrays and matrix equations": [
        (
            "parameter Real A[2, 2]=[-1, 0.5; 2, -3]; Real x[2](start={1, 2}, each fixed=true); Real z[2]; Real w=x*z;"
            "equation der(x) = A*x; [2, 1; 1, 3]*z = {1, time};",
            {
                "x[1]": (expm(A) @ [1, 2])[0],
                "z[2]": np.linalg.solve([[2, 1], [1, 3]], [1, 1])[1],
                "w": expm(A) @ [1, 2] @ np.linalg.solve([[2, 1], [1, 3]], [1, 1]),
            },
        ),
        (
            "Real m[2, 3]=[1, 2, 3; 4, 5, time]; Real a[3]=m[2, {3, 1, 2}]; Real b[2]=a[2:3]; Real c[2]=m[:, end];"
            "Real p[2, 2]=[1, 1; 0, 1]^3; Real q[2]={2, 3}.^{3, 2}; Real v[3]={1, 2}*m;",
            {"a[1]": 1, "b[2]": 5, "c[2]": 1, "p[1,2]": 3, "q[1]": 8, "v[3]": 5},
        ),
        (
            "parameter Integer n=2; parameter Integer k[3]={3, 1, 2}; Real x[3]={1, 2, 3}*time; Real y=x[n];"
            "Integer i=if time > 0.5 then 3 else 1; Real z=x[i]; Real w[3]; equation for j in 1:3 loop"
            " w[k[j]] = j; end for;",
            {"y": 2, "z": 3, "w[3]": 1},
        ),
    ],
    "functions of arrays": [
        (
            "Real a[3]={1, 2, time}; Real c[3]=cross(a, {4.0, 5, 6}); Real s=sum(a) + product(a) + max(a) - min(a);"
            "Real t[2, 1]=transpose([3, 4]); Real o[2, 2]=outerProduct({1.0, 2}, {3.0, 4}); Real d[2, 2]="
            "diagonal({1.0, 2}); Real l[3]=linspace(0.0, time, 3); Real k[3, 3]=skew(a); Real v[2]=vector([1; time]);"
            "Real b[4]=cat(1, a, {7}); Real u[3]=sin(a); Real i[2, 2]=identity(2)*time;",
            {
                **dict(zip([f"c[{k}]" for k in (1, 2, 3)], np.cross([1, 2, 1], [4, 5, 6]), strict=True)),
                **{"s": 7, "t[2,1]": 4, "o[2,1]": 6, "d[2,2]": 2, "l[2]": 0.5, "k[1,2]": -1, "v[2]": 1, "b[4]": 7},
                **{"u[2]": np.sin(2), "i[1,1]": 1},
            },
        )
    ],
    "for-equations and comprehensions": [
        (
            "parameter Integer n=4; Real T[n](each start=0, each fixed=true); equation der(T[1]) = 1 - 2*T[1] + T[2];"
            "for i in 2:n - 1 loop der(T[i]) = T[i - 1] - 2*T[i] + T[i + 1]; end for; der(T[n]) = T[n - 1] - T[n];",
            {
                f"T[{k + 1}]": value
                for k, value in enumerate(
                    ivp(
                        lambda t, T: [1 - 2 * T[0] + T[1], T[0] - 2 * T[1] + T[2], T[1] - 2 * T[2] + T[3], T[2] - T[3]],
                        *np.zeros(4),
                    )
                )
            },
        ),
        (
            "Real x[2, 3]={{10*i + j for j in 1:3} for i in 1:2}; Real s=sum({sum({i*j for j in 1:3}) for i in 1:2});",
            {"x[2,3]": 23, "x[1,2]": 12, "s": 18},
        ),
        (
            "parameter Integer n=3; Real x[n](each start=1, each fixed=true); Real y[n]; equation for i in 1:n loop"
            " der(x[i]) = (if i > 1 then x[i - 1] else 0) - x[i] + (if i == n then 0 elseif i < n then x[i + 1] else"
            " x[i + 2]); if i < n then y[i] = x[i + 1]; else y[i] = 7; end if; end for;",
            {
                "x[3]": (expm(np.eye(3, k=1) + np.eye(3, k=-1) - np.eye(3)) @ np.ones(3))[2],
                "y[2]": (expm(np.eye(3, k=1) + np.eye(3, k=-1) - np.eye(3)) @ np.ones(3))[2],
                "y[3]": 7,
            },
        ),
    ],
    "extends and modifications": [
        (
            f"{DECAY} model E extends D(k=3, x(start=2)); end E; model B D d(k=2); end B; model C extends B(d(k=4));"
            "end C; model S = D(k=5); E one; C two(d(k=6)); S three; D four[3](k={1, 2, 3}, each x(start=4));",
            {"one.x": 2 * e(-3), "two.d.x": e(-6), "three.x": e(-5), "four[3].x": 4 * e(-3)},
        )
    ],
    "replaceable and redeclare": [
        (
            f"{X_AND_Y} model H replaceable X c constrainedby X; replaceable model F = X; F f(k=4); end H; model I"
            " extends H; redeclare Y c(k=7); end I; H h1; H h2(redeclare Y c, redeclare model F = Y);"
            "H h3(redeclare Y c(k=5)); I h4; model J extends H(redeclare Y c(k=9)); end J; J h5;",
            {"h1.c.y": 1, "h1.f.y": 4, "h2.c.y": 2, "h2.f.y": 4, "h3.c.y": 5, "h4.c.y": 7, "h5.c.y": 9},
        )
    ],
    "inner and outer": [
        (
            "model G parameter Real g=1; end G; model W outer G world; Real y=world.g*time; end W;"
            "model V inner G world(g=7); W w; end V; inner G world(g=5); W w; V v;",
            {"w.y": 5, "v.w.y": 7},
        )
    ],
    "conditional components": [
        (
            f"{X_AND_Y} parameter Integer n=2; X a(k=3) if n > 1; X b if n > 5; X c[2](k={{1, 8}}) if n == 2;",
            {"a.y": 3, "c[2].y": 8},
        )
    ],
    "connectors, flow and stream": [
        (
            f"{PIN} {RESISTOR} {GROUND} model RR P p; P n; R a; R b(r=2); equation connect(p, a.p); connect(a.n, b.p);"
            "connect(b.n, n); end RR; V v; G g; RR s; R r[2](r={1, 2}); parameter Boolean on=true; R o if on; R open;"
            "equation connect(v.p, s.p); connect(s.n, g.p); connect(v.p, r[1].p); for k in 1:1 loop"
            " connect(r[k].n, r[k + 1].p); end for; connect(r[2].n, g.p); connect(v.p, o.p); connect(o.n, g.p);"
            "connect(v.p, open.p);",
            {"s.p.i": 2, "r[1].n.v": 4, "v.p.i": -10, "open.n.v": 6, "open.p.i": 0},
        ),
        (
            "connector F Real p; flow Real m; stream Real h; end F; model S F f; equation f.p = 1; f.h = 5; end S;"
            "model T F f; Real h=inStream(f.h); equation f.m = 1; f.h = 3; end T; S s; T t; block B input Real u;"
            "output Real y; equation y = 2*u; end B; B b; B c; equation connect(s.f, t.f); b.u = time;"
            "connect(b.y, c.u);",
            {"t.h": 5, "s.f.m": -1, "c.y": 4},
        ),
    ],
    "protected": [("protected Real z=time; public Real y=2*z;", {"y": 2})],
    "unit, min, max, nominal": [
        (
            'Real x(unit="m", displayUnit="mm", min=0, max=0.5, nominal=2, start=1, fixed=true); equation der(x) = -x;',
            {"x": e(-1)},
        )
    ],
    "derivatives": [
        (
            "Real x(start=1, fixed=true); Real v(start=0, fixed=true); Real a(start=1, fixed=true);"
            "Real b(start=0, fixed=true); equation v = der(x); der(v) = -x; der(a) + der(b) = -a; der(a) - der(b) = b;",
            {"x": np.cos(1), "a": ivp(lambda t, y: [(y[1] - y[0]) / 2, -(y[0] + y[1]) / 2], 1, 0)[0]},
        )
    ],
    "linear algebraic loops": [
        (  # three unknowns, symmetric by default values, or where the relation has not switched
            "parameter Real p=0; Real x[3]; Real y[3]; Real z[3]; equation"
            " [4, 1, 0; 1, 4, 1 + p; 0, 1, 4]*x = {1, 2, 3};"
            "[4, 1, 0; 1, 4, if time > 0.5 then 3 else 1; 0, 1, 4]*y = x;"
            "[4, 1, 0; 1, 4, noEvent(if time > 0.5 then 3 else 1); 0, 1, 4]*z = y;",
            dict(zip(("x[3]", "y[3]", "z[3]"), [turned(k)[2] for k in (1, 2, 3)], strict=True)),
            {"p": 2},
        ),
        (
            "parameter Real k=1; Real s(start=1, fixed=true); Real x; Real y; Real z; equation der(s) = -x;"
            "x + y + z = 6*s; x - y = time; y + k*z = 5;",
            {"s": ivp(lambda t, s: [-np.linalg.solve([[1, 1, 1], [1, -1, 0], [0, 1, 2]], [6 * s[0], t, 5])[0]], 1)[0]},
            {"k": 2},
        ),
    ],
    "elementary functions": [
        (
            "Real t=time/2; Real y=sin(t) + cos(t) + tan(t) + asin(t) + acos(t) + atan(t) + atan2(t, 2) + sinh(t)"
            " + cosh(t) + tanh(t) + exp(t) + log(t) + log10(t) + sqrt(t) + abs(-t) + sign(-t) + t^3 + (-t)^2;",
            {
                "y": sum(f(0.5) for f in (np.sin, np.cos, np.tan, np.arcsin, np.arccos, np.arctan, np.sinh, np.cosh))
                + np.arctan2(0.5, 2)
                + np.tanh(0.5)
                + e(0.5)
                + np.log(0.5)
                + np.log10(0.5)
                + np.sqrt(0.5)
                + 0.5
                - 1
                + 0.5**3
                + 0.5**2
            },
        )
    ],
}
