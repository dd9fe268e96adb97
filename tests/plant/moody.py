"""A drive as an FMI 2.0 FMU, Model Exchange and Co-Simulation, one of whose functions misbehaves from a time on."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import msgspec
import pytest

from pipeline.plant.binding import Binding

VARIABLES = ("u", "q", "qd", "x", "v", "der(x)", "der(v)", "M", "Fv", "x0", "v0", "mood", "outcome", "since", "flood")
MOODS = (
    "SetReal", "SetContinuousStates", "GetDerivatives", "SetTime", "EnterEventMode", "NewDiscreteStates",
    "EnterContinuousTimeMode", "CompletedIntegratorStep", "SetFMUstate", "Reset", "ExitInitializationMode", "DoStep",
)  # fmt: skip
NAN, TERMINATE, CHATTER = 100, 101, 102

_KIND = {
    "u": ("input", "continuous", ""),
    "q": ("output", "continuous", 'initial="calculated"'),
    "qd": ("output", "continuous", 'initial="calculated"'),
    "M": ("parameter", "tunable", ""),
    "Fv": ("parameter", "tunable", ""),
}
_START = {"u": 0.0, "x": 0.0, "v": 0.0, "M": 2.0, "Fv": 3.0, "since": 1e9}


def _variable(i: int, name: str) -> str:
    fixed = ("parameter", "fixed", "")
    local = ("local", "continuous", 'initial="exact"' if name in ("x", "v") else 'initial="calculated"')
    causality, variability, initial = _KIND.get(name, local if name in ("x", "v", "der(x)", "der(v)") else fixed)
    start = "" if "calculated" in initial else f' start="{_START.get(name, 0.0)}"'
    derivative = {"der(x)": ' derivative="4"', "der(v)": ' derivative="5"'}.get(name, "")
    return (
        f'<ScalarVariable name="{name}" valueReference="{i}" causality="{causality}" variability="{variability}" '
        f"{initial}><Real{start}{derivative}/></ScalarVariable>"
    )


DESCRIPTION = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="moody" guid="moody" numberOfEventIndicators="0">
<ModelExchange modelIdentifier="moody"/>
<CoSimulation modelIdentifier="moody" canGetAndSetFMUstate="true" canHandleVariableCommunicationStepSize="true"/>
<ModelVariables>{"".join(_variable(i, name) for i, name in enumerate(VARIABLES))}</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/><Unknown index="3"/></Outputs>
<Derivatives><Unknown index="6" dependencies="5"/><Unknown index="7" dependencies="DEPENDENCIES"/></Derivatives>
</ModelStructure></fmiModelDescription>
"""

SOURCE = r"""
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
typedef void Logger(void *, const char *, int, const char *, const char *, ...);
typedef struct { Logger *log; void *allocate, *free, *finished, *environment; } Callbacks;
typedef struct { int needed, terminate, nominals, states, defined; double next; } EventInfo;
enum { U, Q, QD, X, V, DX, DV, MASS, FV, X0, V0, MOOD, OUTCOME, SINCE, FLOOD, N };
typedef struct { double v[N]; double t; int running; } State;
typedef struct { State s; const Callbacks *callbacks; char name[100]; } Model;
static const State START = {{[MASS] = 2, [FV] = 3, [SINCE] = 1e9}, 0, 0};

/* The outcome of function `id`, if it is its mood and its time. */
static int moody(Model *m, int id, const char *what) {
    int outcome = (int)m->s.v[OUTCOME];
    if (!m->s.running || (int)m->s.v[MOOD] != id || m->s.t < m->s.v[SINCE]) return 0;
    for (int i = 0; i <= (int)m->s.v[FLOOD]; i++)
        m->callbacks->log(m->callbacks->environment, m->name, outcome, "logStatusError", "%s is in a mood", what);
    return outcome;
}
#define STATUS(id) do { int o = moody(m, id, __func__); if (o > 0 && o < 100) return o; } while (0)
static void compute(Model *m) {
    double *v = m->s.v;
    v[Q] = v[X], v[QD] = v[V], v[DX] = v[V], v[DV] = (v[U] - v[FV] * v[V] EXTRA) / v[MASS];
}
void *fmi2Instantiate(const char *n, int k, const char *g, const char *r, const Callbacks *c, int vis, int l) {
    Model *m = calloc(1, sizeof *m);
    m->s = START, m->callbacks = c, strncpy(m->name, n, 99);
    return m;
}
void fmi2FreeInstance(Model *m) { free(m); }
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
int fmi2SetupExperiment(Model *m, int a, double b, double t, int c, double d) { m->s.t = t; return 0; }
int fmi2EnterInitializationMode(Model *m) { m->s.v[X] = m->s.v[X0], m->s.v[V] = m->s.v[V0]; return 0; }
int fmi2ExitInitializationMode(Model *m) { m->s.running = 1; STATUS(10); return 0; }
int fmi2Reset(Model *m) { STATUS(9); m->s = START; return 0; }
int fmi2SetReal(Model *m, const unsigned *vr, size_t n, const double *x) {
    STATUS(0);
    for (size_t i = 0; i < n; i++) m->s.v[vr[i]] = x[i];
    return 0;
}
int fmi2GetReal(Model *m, const unsigned *vr, size_t n, double *x) {
    compute(m);
    for (size_t i = 0; i < n; i++) x[i] = m->s.v[vr[i]];
    return 0;
}
int fmi2SetContinuousStates(Model *m, const double *x, size_t n) { STATUS(1); memcpy(m->s.v + X, x, 16); return 0; }
int fmi2GetContinuousStates(Model *m, double *x, size_t n) { memcpy(x, m->s.v + X, 16); return 0; }
int fmi2GetDerivatives(Model *m, double *dx, size_t n) {
    STATUS(2);
    compute(m);
    dx[0] = m->s.v[DX], dx[1] = moody(m, 2, __func__) == 100 ? NAN : m->s.v[DV];
    return 0;
}
int fmi2SetTime(Model *m, double t) { m->s.t = t; STATUS(3); return 0; }
int fmi2EnterEventMode(Model *m) { STATUS(4); return 0; }
int fmi2NewDiscreteStates(Model *m, EventInfo *e) {
    memset(e, 0, sizeof *e);
    STATUS(5);
    int outcome = moody(m, 5, __func__);
    e->terminate = outcome == 101, e->needed = outcome == 102;
    return 0;
}
int fmi2EnterContinuousTimeMode(Model *m) { STATUS(6); return 0; }
int fmi2CompletedIntegratorStep(Model *m, int a, int *event, int *terminate) {
    *event = *terminate = 0;
    STATUS(7);
    *terminate = moody(m, 7, __func__) == 101;
    return 0;
}
int fmi2GetFMUstate(Model *m, State **s) { *s = malloc(sizeof **s); **s = m->s; return 0; }
int fmi2SetFMUstate(Model *m, State *s) { STATUS(8); m->s = *s; return 0; }
int fmi2FreeFMUstate(Model *m, State **s) { free(*s); *s = 0; return 0; }
int fmi2DoStep(Model *m, double t, double h, int no) {
    STATUS(11);
    for (int i = 0; i < 10; i++) compute(m), m->s.v[X] += h / 10 * m->s.v[DX], m->s.v[V] += h / 10 * m->s.v[DV];
    if (moody(m, 11, __func__) == 100) m->s.v[V] = NAN;
    m->s.t = t + h;
    return 0;
}
"""
STUBS = (
    "SetDebugLogging Terminate GetInteger GetBoolean GetString SetInteger SetBoolean SetString SerializedFMUstateSize "
    "SerializeFMUstate DeSerializeFMUstate GetDirectionalDerivative SetRealInputDerivatives GetEventIndicators "
    "GetNominalsOfContinuousStates GetRealOutputDerivatives CancelStep GetStatus GetRealStatus GetIntegerStatus "
    "GetBooleanStatus GetStringStatus"
)
PLATFORM = {"linux": ("linux64", "so"), "darwin": ("darwin64", "dylib")}


def build_moody(folder: Path, stiffness: float = 0.0) -> Path:
    """Compile the FMU into `folder`. With a stiffness the position matters, which the description does not say."""
    compiler = shutil.which("cc")
    if compiler is None or sys.platform not in PLATFORM:
        pytest.skip("no C compiler, or no platform for the moody FMU")
    system, suffix = PLATFORM[sys.platform]
    source, library = folder / "moody.c", folder / f"moody.{suffix}"
    text = SOURCE.replace("EXTRA", f"- {stiffness} * v[X]") + "".join(
        f"int fmi2{s}() {{ return 0; }}\n" for s in STUBS.split()
    )
    source.write_text(text)
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", "-w", "-o", library, source, "-lm"], check=True)
    with zipfile.ZipFile(folder / "moody.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION.replace("DEPENDENCIES", "1 5"))
        archive.write(library, f"binaries/{system}/moody.{suffix}")
    return folder / "moody.fmu"


def moody_binding(fmu: Path, mood: str = "", outcome: int = 0, since: float = 0.0, flood: int = 0) -> Binding:
    """Its binding, in which the function called `mood` has this outcome from a time (s) on, with so many messages more.

    outcome: a status of the standard; NAN; TERMINATE or CHATTER in NewDiscreteStates.
    """
    joint = {
        "name": "axis", "input": "u", "position": "q", "velocity": "qd", "input_unit": "N", "force_unit": "N",
        "position_unit": "m", "velocity_unit": "m/s", "u_range": 10.0, "position_state": "x", "velocity_state": "v",
        "position_start": "x0", "velocity_start": "v0",
    }  # fmt: skip
    parameters = [
        {"name": "M", "unit": "kg", "a_priori": 2.0, "scale": 1.0},
        {"name": "Fv", "unit": "N.s/m", "a_priori": 3.0, "scale": 1.0},
    ]
    own = {"mood": MOODS.index(mood), "outcome": outcome, "since": since, "flood": flood} if mood else {}
    whole = {"fmu": fmu.name, "folder": str(fmu.parent), "joint": [joint], "parameter": parameters, "set": own}
    return msgspec.convert(whole, Binding)
