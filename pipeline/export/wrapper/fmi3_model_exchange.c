/* FMI 3.0: Model Exchange. */
#include "fmi3_layer.h"

#include <string.h>

fmi3Status fmi3EnterEventMode(fmi3Instance pointer) {
    ENTER(CONTINUOUS | EVENT);
    c->memory.mode = EVENT;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance pointer, fmi3Boolean *needs_update, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *states_changed,
                                    fmi3Boolean *next_defined, fmi3Float64 *next_time) {
    ENTER(EVENT);
    Outcome outcome;
    if (!run_event(c, &outcome)) return report3(component, fmi3Error, __func__);
    *needs_update = *terminate = *nominals_changed = fmi3False;
    *states_changed = outcome.states_changed;
    *next_defined = outcome.next_defined;
    *next_time = outcome.next_time;
    return fmi3OK;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance pointer) {
    ENTER(EVENT);
    c->memory.mode = CONTINUOUS;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance pointer, fmi3Boolean no_set_prior, fmi3Boolean *enter_event_mode,
                                       fmi3Boolean *terminate) {
    (void)no_set_prior;
    ENTER(CONTINUOUS);
    *enter_event_mode = *terminate = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance pointer, fmi3Float64 time) {
    ENTER(EVENT | CONTINUOUS);
    set_time(c, time);
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance pointer, const fmi3Float64 x[], size_t n) {
    ENTER(CONTINUOUS | EVENT);
    if (!right_count(c, n, N_STATES, "states")) return report3(component, fmi3Error, __func__);
    set_states(c, x);
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance pointer, fmi3Float64 dx[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    if (!right_count(c, n, N_STATES, "derivatives")) return report3(component, fmi3Error, __func__);
    refresh(c, STALE_DERIVATIVES);
    for (size_t i = 0; i < N_STATES; i++) dx[i] = DX(c)[i];
    return finite_derivatives(c, c->memory.time, dx) ? fmi3OK : report3(component, fmi3Discard, __func__);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance pointer, fmi3Float64 indicator[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    if (!right_count(c, n, N_RELATIONS, "event indicators")) return report3(component, fmi3Error, __func__);
    double truth[N_RELATIONS + 1];
    indicators(c, truth, indicator);
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance pointer, fmi3Float64 x[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    if (!right_count(c, n, N_STATES, "states")) return report3(component, fmi3Error, __func__);
    refresh(c, 0);
    memcpy(x, X(c), n * sizeof *x);
    return fmi3OK;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance pointer, fmi3Float64 nominal[], size_t n) {
    ENTER(INITIALIZATION | EVENT | CONTINUOUS | TERMINATED);
    if (!right_count(c, n, N_STATES, "nominals")) return report3(component, fmi3Error, __func__);
    memcpy(nominal, NOMINALS, n * sizeof *nominal);
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance pointer, size_t *n) {
    ENTER(ANY_MODE);
    *n = N_RELATIONS;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance pointer, size_t *n) {
    ENTER(ANY_MODE);
    *n = N_STATES;
    return fmi3OK;
}
