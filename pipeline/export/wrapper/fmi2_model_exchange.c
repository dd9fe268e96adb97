/* FMI 2.0: Model Exchange. */
#include "fmi2_layer.h"

#include <string.h>

fmi2Status fmi2EnterEventMode(fmi2Component pointer) {
    ENTER(CONTINUOUS | EVENT);
    c->memory.mode = EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component pointer, fmi2EventInfo *info) {
    ENTER(EVENT);
    Outcome outcome;
    if (!run_event(c, &outcome)) return report2(component, fmi2Error, __func__);
    info->newDiscreteStatesNeeded = fmi2False;
    info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = outcome.states_changed;
    info->nextEventTimeDefined = outcome.next_defined;
    info->nextEventTime = outcome.next_time;
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
    set_time(c, time);
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component pointer, const fmi2Real x[], size_t n) {
    ENTER(CONTINUOUS | EVENT);
    if (!right_count(c, n, N_STATES, "states")) return report2(component, fmi2Error, __func__);
    set_states(c, x);
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component pointer, fmi2Real dx[], size_t n) {
    ENTER(EVENT | CONTINUOUS | TERMINATED);
    if (!right_count(c, n, N_STATES, "derivatives")) return report2(component, fmi2Error, __func__);
    refresh(c, STALE_DERIVATIVES);
    for (size_t i = 0; i < N_STATES; i++) dx[i] = DX(c)[i];
    return finite_derivatives(c, c->memory.time, dx) ? fmi2OK : report2(component, fmi2Discard, __func__);
}

fmi2Status fmi2GetEventIndicators(fmi2Component pointer, fmi2Real indicator[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    if (!right_count(c, n, N_RELATIONS, "event indicators")) return report2(component, fmi2Error, __func__);
    double truth[N_RELATIONS + 1];
    indicators(c, truth, indicator);
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component pointer, fmi2Real x[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    if (!right_count(c, n, N_STATES, "states")) return report2(component, fmi2Error, __func__);
    refresh(c, 0);
    memcpy(x, X(c), n * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component pointer, fmi2Real nominal[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    if (!right_count(c, n, N_STATES, "nominals")) return report2(component, fmi2Error, __func__);
    memcpy(nominal, NOMINALS, n * sizeof *nominal);
    return fmi2OK;
}
