/* FMI 2.0: Model Exchange. */
#include "fmi2_layer.h"

#include <float.h>
#include <string.h>

fmi2Status fmi2EnterEventMode(fmi2Component pointer) {
    ENTER(CONTINUOUS | EVENT);
    c->memory.mode = EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component pointer, fmi2EventInfo *info) {
    ENTER(EVENT);
    double before[N_STATES + 1], how_exactly;
    memcpy(before, X(c), N_STATES * sizeof *before);
    if (!handle_event(c, false)) return report(component, fmi2Error, __func__);
    info->newDiscreteStatesNeeded = fmi2False;
    info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = memcmp(before, X(c), N_STATES * sizeof *before) != 0;
    info->nextEventTime = next_tick(c, &how_exactly);
    info->nextEventTimeDefined = info->nextEventTime < DBL_MAX;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component pointer) {
    ENTER(EVENT);
    c->memory.mode = CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component pointer, fmi2Boolean no_set_prior, fmi2Boolean *enter_event_mode,
                                       fmi2Boolean *terminate) {
    (void)no_set_prior;
    ENTER(CONTINUOUS);
    *enter_event_mode = *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component pointer, fmi2Real time) {
    ENTER(EVENT | CONTINUOUS);
    c->memory.time = time;
    c->memory.stale |= STALE_DERIVATIVES | STALE_ALGEBRAICS;
    return fmi2OK;
}

static fmi2Status check_count(Component *component, size_t n, size_t expected, const char *what, const char *function) {
    if (n == expected) return fmi2OK;
    fail(&component->instance, "%zu %s asked for, %s has %zu", n, what, MODEL_NAME, expected);
    return report(component, fmi2Error, function);
}

fmi2Status fmi2SetContinuousStates(fmi2Component pointer, const fmi2Real x[], size_t n) {
    ENTER(CONTINUOUS | EVENT);
    if (n != N_STATES) return check_count(component, n, N_STATES, "states", __func__);
    memcpy(X(c), x, n * sizeof *x);
    c->memory.stale |= STALE_DERIVATIVES | STALE_ALGEBRAICS;
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component pointer, fmi2Real dx[], size_t n) {
    ENTER(EVENT | CONTINUOUS);
    if (n != N_STATES) return check_count(component, n, N_STATES, "derivatives", __func__);
    refresh(c, STALE_DERIVATIVES);
    memcpy(dx, DX(c), n * sizeof *dx);
    return finite_derivatives(c, c->memory.time, dx) ? fmi2OK : report(component, fmi2Discard, __func__);
}

fmi2Status fmi2GetEventIndicators(fmi2Component pointer, fmi2Real indicator[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS);
    if (n != N_RELATIONS) return check_count(component, n, N_RELATIONS, "event indicators", __func__);
    double truth[N_RELATIONS + 1];
    indicators(c, truth, indicator);
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component pointer, fmi2Real x[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    if (n != N_STATES) return check_count(component, n, N_STATES, "states", __func__);
    refresh(c, 0);
    memcpy(x, X(c), n * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component pointer, fmi2Real nominal[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    if (n != N_STATES) return check_count(component, n, N_STATES, "nominals", __func__);
    memcpy(nominal, NOMINALS, n * sizeof *nominal);
    return fmi2OK;
}
