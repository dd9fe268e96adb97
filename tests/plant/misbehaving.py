"""A small Co-Simulation FMU that fails on command: y = 2 u, then a bad status or NaN from a time on."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="misbehaving" guid="{1}">
<CoSimulation modelIdentifier="misbehaving"/>
<ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output" initial="exact"><Real start="0"/></ScalarVariable>
<ScalarVariable name="fail_at" valueReference="2" causality="parameter" variability="fixed"><Real start="1e9"/>
</ScalarVariable>
<ScalarVariable name="status" valueReference="3" causality="parameter" variability="fixed"><Real start="0"/>
</ScalarVariable>
<ScalarVariable name="nan_at" valueReference="4" causality="parameter" variability="fixed"><Real start="1e9"/>
</ScalarVariable>
<ScalarVariable name="refuse" valueReference="5" causality="parameter" variability="fixed"><Real start="0"/>
</ScalarVariable>
<ScalarVariable name="count" valueReference="6" causality="output" initial="exact"><Integer start="0"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/><Unknown index="7"/></Outputs></ModelStructure>
</fmiModelDescription>
"""

# refuse = 1: exitInitializationMode returns Error; 2: SetReal does from the start of the run on.
SOURCE = r"""
#include <math.h>
#include <stddef.h>
typedef struct { double v[6]; double t; int running; } Model;
static Model model;
void *fmi2Instantiate(const char *n, int k, const char *g, const char *r, const void *c, int v, int l) {
    Model fresh = {{0, 0, 1e9, 0, 1e9, 0}, 0, 0};
    model = fresh;
    return &model;
}
void fmi2FreeInstance(void *c) { }
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
int fmi2ExitInitializationMode(void *c) { model.running = 1; return model.v[5] == 1 ? 3 : 0; }
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *x) {
    for (size_t i = 0; i < n; i++) model.v[vr[i]] = x[i];
    return model.running && model.v[5] == 2 ? 3 : 0;
}
int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *x) {
    for (size_t i = 0; i < n; i++) x[i] = model.v[vr[i]];
    return 0;
}
int fmi2DoStep(void *c, double t, double h, int no) {
    model.v[1] = t >= model.v[4] ? NAN : 2 * model.v[0];
    return t >= model.v[2] ? (int)model.v[3] : 0;
}
"""
STUBS = (
    "SetDebugLogging SetupExperiment EnterInitializationMode Terminate Reset GetInteger GetBoolean GetString "
    "SetInteger SetBoolean SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize "
    "SerializeFMUstate DeSerializeFMUstate GetDirectionalDerivative SetRealInputDerivatives "
    "GetRealOutputDerivatives CancelStep GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus "
    "GetStringStatus"
)
PLATFORM = {"linux": ("linux64", "so"), "darwin": ("darwin64", "dylib")}


def build_misbehaving(folder: Path) -> Path | None:
    """Compile the FMU into `folder`; None where there is no C compiler or no platform for it."""
    compiler = shutil.which("cc")
    if compiler is None or sys.platform not in PLATFORM:
        return None
    system, suffix = PLATFORM[sys.platform]
    source, library = folder / "misbehaving.c", folder / f"misbehaving.{suffix}"
    source.write_text(SOURCE + "".join(f"int fmi2{name}() {{ return 0; }}\n" for name in STUBS.split()))
    subprocess.run([compiler, "-shared", "-fPIC", "-w", "-o", library, source, "-lm"], check=True)
    with zipfile.ZipFile(folder / "misbehaving.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.write(library, f"binaries/{system}/misbehaving.{suffix}")
    return folder / "misbehaving.fmu"
