"""What the exporter refuses, by the rows of the table in modelica/README.md: the body of a model M, and the message."""

PIN = "connector P Real v; flow Real i; end P;"
X_AND_Y = "model X parameter Real k=1; Real y=k*time; end X; model Y extends X(k=2); end Y;"
F = "function f input Real x; output Real y; algorithm"

REFUSED: dict[str, list[tuple[str, str]]] = {
    "Integer and Boolean parameters computed from Real ones": [
        (
            "parameter Real k=2; parameter Boolean b=k > 1; Real y=if b then 1 else 2;",
            "parameter b: a Boolean parameter",
        ),
        ("parameter Real k=2.5; parameter Integer n=integer(k); Real y=n*time;", "parameter n: a Integer parameter"),
    ],
    "discrete arrays assigned by element": [
        (
            "discrete Real k[2](each start=0, each fixed=true); equation when sample(0, 1) then k[1] = time; k[2] = 1;"
            "end when;",
            r"k\[1\] is assigned by element in a when-clause: assign the whole array",
        ),
        ("Boolean b[2]; equation b = {time > 0.3, time > 2};", "an array of discrete values"),
        (
            "discrete Real k[2](each start=0, each fixed=true); algorithm when sample(0, 1) then for i in 1:2 loop"
            " k[i] := i; end for; end when;",
            "an algorithm in a when-clause",
        ),
    ],
    "parameters computed at the start": [
        (
            "parameter Real k(fixed=false); Real x(start=0); initial equation k = 2; equation der(x) = k;",
            r"parameter k: fixed=false",
        )
    ],
    "parameters and starts without a value": [
        ("parameter Real k; Real x(start=0, fixed=true); equation der(x) = k;", "parameter k has no value: bind it"),
        ("parameter Real k=-log(0); Real x=k*time;", "parameter k is inf: give a finite value"),
        ("Real x(start=log(0), fixed=true); equation der(x) = 1;", "start value of x is -inf: give a finite one"),
    ],
    "start values from inputs": [
        ("input Real u; Real x(start=u, fixed=true); equation der(x) = 1;", "depends on u|refuses it"),
    ],
    "initial equations, non-linear": [
        ("Real x(start=1); initial equation x^3 + x = 10; equation der(x) = 0;", "initial equations: a non-linear"),
        ("Real x(start=0, fixed=true); initial equation x = 1; equation der(x) = 1;", "initial equation|refuses it"),
        ("Real x(start=1, fixed=true); Real y(start=1, fixed=true); equation der(x) = y; y = 2*x;", "init"),
    ],
    "initial algorithms, asserts in initial equations": [
        (
            "Real x; initial algorithm x := 3; equation der(x) = -x;",
            r"an initial algorithm \(for x\): write",
        ),
        ('parameter Real p=2; Real x=time; initial equation assert(p > 0, "p");', "assert in the initial equations"),
    ],
    "comprehensions with several iterators": [
        ("Real x[2, 3]={i*j for j in 1:3, i in 1:2};", r"comprehension with several iterators.*nest them \(M\.mo:1\)"),
    ],
    "events in for-equations": [
        (
            "Real s(start=0, fixed=true); Real x[2]; equation der(s) = 1; for i in 1:2 loop x[i] = if s > i*0.3 then 1"
            " else 0; end for;",
            "an event in an array equation cannot be exported",
        ),
        (
            "Real x[2]; equation for i in 1:2 loop x[i] = if time > i then 1 else 0; end for;",
            "an event in a for-equation: use",
        ),
    ],
    "floor, ceil, integer of what varies": [
        ("Real x=floor(3*time);", r"floor\(\) of what changes between events .* noEvent"),
    ],
    "div, mod, rem": [("Real x=mod(time, 2);", r"div\(\), mod\(\) and rem\(\) cannot be exported")],
    "pre() outside of when": [
        (
            "discrete Real d(start=1, fixed=true); Real y=pre(d) + time;"
            "equation when sample(0, 1) then d = pre(d) + 1; end when;",
            r"y depends on pre\(d\) outside a when-clause",
        )
    ],
    "initial() in a continuous equation, terminal()": [
        ("Real x(start=0, fixed=true); equation der(x) = if initial() then 5 else 1;", r"depends on initial\(\)"),
        (
            "discrete Real d(start=0, fixed=true); equation when terminal() then d = 1; end when;",
            r"terminal\(\) cannot",
        ),
    ],
    "terminate": [
        ('Real x=time; equation when x > 1 then terminate("end"); end when;', "terminate cannot be exported")
    ],
    "sample periods": [
        (
            "parameter Real T=1; discrete Real x; equation when sample(0, sqrt(T)) then x = time; end when;",
            r"sample\(\) of other than numbers, parameters",
        ),
        (
            "parameter Real S=1; parameter Real T=1; discrete Real x; discrete Real y;"
            "equation when sample(0, S) then x = time; end when; when sample(0, T) then y = time; end when;",
            "two sample periods of 1 s",
        ),
    ],
    "while, break, return": [
        (
            f"{F} y := x; while y < 10 loop y := 2*y; end while; end f; Real y=f(3);",
            "statement .* such as while",
        ),
        (
            f"{F} y := 0; for i in 1:9 loop y := y + 1; if y > x then break; end if; end for; end f; Real y=f(3);",
            "f .* break",
        ),
        (f"{F} y := 1; if x > 0 then return; end if; y := 2; end f; Real y=f(3);", "the function f has a return"),
    ],
    "recursive functions": [(f"{F} y := if x > 1 then x*f(x - 1) else 1; end f; Real y=f(time);", "f calls itself")],
    "external and impure functions": [
        (
            'function f input Real x; output Real y; external "C" y = sin(x); end f; Real x=f(time);',
            "external function f cannot be exported",
        ),
        (f"impure {F} y := x; end f; Real x=f(time);", "impure function 'f'"),
    ],
    "assert in a function": [(f'{F} assert(x < 1, "x"); y := x; end f; Real y=f(time);', "function f: an assertion")],
    "algorithms that sum up or assign several": [
        (
            "Real y; algorithm y := 0; for i in 1:3 loop y := y + i*time; end for;",
            "algorithm section .*: put it into a function",
        ),
        ("Real y; Real z; algorithm z := time; y := 2*z;", "algorithm section .*: put it into a function"),
        (
            "Real x=time; discrete Real d(start=0, fixed=true); algorithm when x > 0.5 then d := 1; end when;"
            "when x > 0.5 then d := 2; end when;",
            "d is assigned in two when-statements of an algorithm: use elsewhen",
        ),
    ],
    "modifications of the form a.b=c": [
        ("model B Real x(start=1); equation der(x) = 1; end B; B b(x.start=3);", r"a\.b=c is lost .* write a\(b=c\)"),
    ],
    "classes that are arrays": [(f"{X_AND_Y} model V = X[2]; V v;", "a class that is an array is lost")],
    "redeclare: what is lost": [
        (
            f"{X_AND_Y} model H replaceable model F = X; F f; end H; H h(redeclare model F = Y(k=5));",
            "redeclare with a modifier is lost",
        ),
        (
            "model H replaceable Real y=time; end H; H h(redeclare Real y=2*time);",
            "redeclare with a binding is lost by the front end",
        ),
        (
            f"{X_AND_Y} model H replaceable X x; end H; model B H h; end B; B b(h(redeclare Y x));",
            "redeclare in a nested modification is lost",
        ),
        (
            f"{X_AND_Y} model H replaceable X x constrainedby X(k=3); end H; H h;",
            "modification in constrainedby is lost",
        ),
    ],
    "inner and outer of a predefined type": [
        (
            "model W outer Real g; Real y=g; end W; inner Real g=3*time; W w;",
            "is 2, of unknown variables 3",
        ),
        ("model W outer parameter Real g; Real y=g; end W; inner parameter Real g=3; W w;", "w.g has no value"),
    ],
    "expandable connectors": [
        (
            "expandable connector Bus end Bus; connector O = output Real; block S O y; equation y = time; end S; Bus b;"
            "S s; equation connect(s.y, b.signal);",
            r"an expandable connector \(connect\(s.y, b.signal\)\)",
        )
    ],
    "operator records": [
        (
            "operator record C Real re; encapsulated operator '+' function add input C a; input C b; output C c;"
            "algorithm c := C(a.re + b.re); end add; end '+'; end C; C a=C(1); C b=C(2); C c=a + b;",
            "refuses it",
        )
    ],
    "String": [('parameter String s="a"; Real x=time;', r"variable s: its type string")],
    "der of an expression or of an input": [
        ("Real x(start=0, fixed=true); Real y; equation der(x) = 1; y = der(x^2);", r"der\(\) of an expression: give"),
        ("input Real u; Real y=der(u);", r"der\(\) of an input"),
    ],
    "non-linear algebraic loops": [
        ("Real x; Real y; equation x = cos(y);\n y = sin(x);", r"non-linear system.*: [xy], [xy]"),
        ("Real x(start=1); equation x^3 + x = time;", r"non-linear system.*: x"),
    ],
    "higher index": [
        (
            "Real x; Real y; Real f; equation der(x) = y; der(y) = f;\n x = sin(time);",
            r"structurally singular \(rank 2 of 3\).*higher index.*M\.mo:2",
        )
    ],
    "singular or unbalanced systems": [
        ("Real x; Real y; equation x + y = time; 2*x + 2*y = 2;", "singular system of equations: [xy], [xy]"),
        ("Real x; equation x = 1; x = 2;", "refuses it"),
        (
            "Real x; Real y; equation x + y = 1;",
            "equations is 1, of unknown variables 2; add",
        ),
    ],
    "delay, spatialDistribution": [
        ("Real x=delay(time, 0.1);", r"delay\(\)"),
        (
            "Real a; Real b; equation (a, b) = spatialDistribution(time, 0, time, true);",
            "spatialDistribution is no",
        ),
    ],
    "synchronous elements": [
        ("Real x; Clock c=Clock(0.1); equation x = previous(x) + 1;", r"synchronous .* sample\(\)")
    ],
    "scalar, matrix, symmetric, ndims": [
        ("Real y=scalar([time]);", r"scalar\(\) cannot be exported: write"),
        ("Real y[1, 1]=matrix(time);", r"matrix\(\) cannot be exported: write"),
        ("Real y[2, 2]=symmetric([1.0, 2; 3, 4]);", r"symmetric\(\) cannot be exported: write"),
        ("Real A[2]={1, 2}; Integer n=ndims(A);", r"ndims\(\) cannot be exported: write"),
    ],
}
