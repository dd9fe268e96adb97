/* FMI 2.0: what Model Exchange and Co-Simulation have in common. */
#include "fmi2_layer.h"

#include <stdlib.h>
#include <string.h>

fmi2Status report2(Component2 *component, fmi2Status status, const char *function) {
    const char *category = status == fmi2Discard ? "logStatusDiscard" : "logStatusError";
    if (component->callbacks.logger)
        component->callbacks.logger(component->callbacks.componentEnvironment, component->name, status, category,
                                    "%s: %s", function, component->instance.message);
    return status;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component pointer, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)n, (void)categories;
    ENTER(ANY_MODE);
    component->logging = on;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)resources, (void)visible;
    Component2 *component = calloc(1, sizeof *component);
    if (!component) return NULL;
    if (callbacks) component->callbacks = *callbacks;
    component->logging = logging;
    component->instance.co_simulation = type == fmi2CoSimulation;
    component->name = calloc(1, strlen(name ? name : "") + 1);
    if (component->name) strcpy(component->name, name ? name : "");
    reset(&component->instance);
    if (component->name && guid && !strcmp(guid, MODEL_GUID)) return component;
    fail(&component->instance, "the GUID is %s, but the model description of %s must have %s", guid ? guid : "missing",
         MODEL_NAME, MODEL_GUID);
    report2(component, fmi2Error, __func__);
    fmi2FreeInstance(component);
    return NULL;
}

void fmi2FreeInstance(fmi2Component pointer) {
    Component2 *component = pointer;
    if (!component) return;
    free(component->name);
    free(component);
}

fmi2Status fmi2SetupExperiment(fmi2Component pointer, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start_time, fmi2Boolean stop_time_defined, fmi2Real stop_time) {
    (void)tolerance_defined, (void)tolerance, (void)stop_time_defined, (void)stop_time;
    ENTER(INSTANTIATED);
    set_time(c, start_time);
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component pointer) {
    ENTER(INSTANTIATED);
    c->memory.mode = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component pointer) {
    ENTER(INITIALIZATION);
    if (!start_events(c)) return report2(component, fmi2Error, __func__);
    c->memory.mode = c->co_simulation ? STEP : EVENT;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component pointer) {
    ENTER(RUNNING);
    c->memory.mode = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component pointer) {
    ENTER(ANY_MODE);
    reset(c);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component pointer, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    ENTER(ANY_MODE);
    GIVE(get_values(c, vr, n, REAL, value));
}

fmi2Status fmi2SetReal(fmi2Component pointer, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    ENTER(ANY_MODE);
    GIVE(set_values(c, vr, n, REAL, value));
}

static fmi2Status get_integers(fmi2Component pointer, const fmi2ValueReference vr[], size_t n, int value[], Type type,
                               const char *function) {
    ENTER_AS(ANY_MODE, function);
    for (size_t i = 0; i < n; i++)
        if (!get_integer(c, vr[i], type, value + i)) return report2(component, fmi2Error, function);
    return fmi2OK;
}

static fmi2Status set_integers(fmi2Component pointer, const fmi2ValueReference vr[], size_t n, const int value[],
                               Type type, const char *function) {
    ENTER_AS(ANY_MODE, function);
    for (size_t i = 0; i < n; i++) {
        double number = type == BOOLEAN ? value[i] != 0 : value[i];
        if (!set_values(c, vr + i, 1, type, &number)) return report2(component, fmi2Error, function);
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component pointer, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]) {
    return get_integers(pointer, vr, n, value, INTEGER, __func__);
}

fmi2Status fmi2SetInteger(fmi2Component pointer, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    return set_integers(pointer, vr, n, value, INTEGER, __func__);
}

fmi2Status fmi2GetBoolean(fmi2Component pointer, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]) {
    return get_integers(pointer, vr, n, value, BOOLEAN, __func__);
}

fmi2Status fmi2SetBoolean(fmi2Component pointer, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) {
    return set_integers(pointer, vr, n, value, BOOLEAN, __func__);
}

static fmi2Status no_strings(fmi2Component pointer, size_t n, const char *function) {
    ENTER_AS(ANY_MODE, function);
    if (!n) return fmi2OK;
    fail(c, "%s has no String variables", MODEL_NAME);
    return report2(component, fmi2Error, function);
}

fmi2Status fmi2GetString(fmi2Component pointer, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    (void)vr, (void)value;
    return no_strings(pointer, n, __func__);
}

fmi2Status fmi2SetString(fmi2Component pointer, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    (void)vr, (void)value;
    return no_strings(pointer, n, __func__);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component pointer, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real dknown[],
                                        fmi2Real dunknown[]) {
    ENTER(INITIALIZATION | RUNNING);
    GIVE(directional_derivative(c, unknown, n_unknown, known, n_known, dknown, dunknown));
}
