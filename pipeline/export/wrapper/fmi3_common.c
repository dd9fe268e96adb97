/* FMI 3.0: what Model Exchange and Co-Simulation have in common. */
#include "fmi3_layer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

fmi3Status report3(Component3 *component, fmi3Status status, const char *function) {
    char message[sizeof component->instance.message + 64];
    snprintf(message, sizeof message, "%s: %s", function, component->instance.message);
    if (component->log)
        component->log(component->environment, status, status == fmi3Discard ? "logStatusDiscard" : "logStatusError",
                       message);
    return status;
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance pointer, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    (void)on, (void)n, (void)categories;
    ENTER(ANY_MODE);
    return fmi3OK;
}

static fmi3Instance refuse(Component3 *component, const char *function) {
    report3(component, fmi3Error, function);
    free(component);
    return NULL;
}

static Component3 *create(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    Component3 *component = calloc(1, sizeof *component);
    if (!component) return NULL;
    component->environment = environment;
    component->log = log;
    reset(&component->instance);
    return component;
}

static fmi3Instance instantiate(Component3 *component, fmi3String token, const char *function) {
    if (!component || (token && !strcmp(token, MODEL_GUID))) return component;
    fail(&component->instance, "the instantiation token is %s, but the model description of %s must have %s",
         token ? token : "missing", MODEL_NAME, MODEL_GUID);
    return refuse(component, function);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    (void)name, (void)resources, (void)visible, (void)logging;
    return instantiate(create(environment, log), token, __func__);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[], size_t n_intermediate,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)early_return;
    (void)intermediate, (void)n_intermediate, (void)update;
    Component3 *component = create(environment, log);
    if (component) component->instance.co_simulation = true;
    if (component && event_mode) {
        fail(&component->instance, "%s has no Event Mode in Co-Simulation (hasEventMode): eventModeUsed must be false",
             MODEL_NAME);
        return refuse(component, __func__);
    }
    return instantiate(component, token, __func__);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback clock_update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    (void)clock_update, (void)lock, (void)unlock;
    Component3 *component = create(environment, log);
    if (!component) return NULL;
    fail(&component->instance, "%s offers Model Exchange and Co-Simulation, no Scheduled Execution", MODEL_NAME);
    return refuse(component, __func__);
}

void fmi3FreeInstance(fmi3Instance pointer) { free(pointer); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance pointer, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start_time, fmi3Boolean stop_time_defined, fmi3Float64 stop_time) {
    (void)tolerance_defined, (void)tolerance, (void)stop_time_defined, (void)stop_time;
    ENTER(INSTANTIATED);
    set_time(c, start_time);
    c->memory.mode = INITIALIZATION;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance pointer) {
    ENTER(INITIALIZATION);
    if (!start_events(c)) return report3(component, fmi3Error, __func__);
    c->memory.mode = c->co_simulation ? STEP : EVENT;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance pointer) {
    ENTER(RUNNING);
    c->memory.mode = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance pointer) {
    ENTER(ANY_MODE);
    reset(c);
    return fmi3OK;
}
