/* FMI 3.0: Co-Simulation, without Event Mode, early return and intermediate update. */
#include "fmi3_layer.h"

fmi3Status fmi3DoStep(fmi3Instance pointer, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_set_prior,
                      fmi3Boolean *event_handling_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                      fmi3Float64 *last_successful_time) {
    (void)no_set_prior;
    ENTER(STEP);
    if (!step_allowed(c, time, step)) return report3(component, fmi3Error, __func__);
    bool done = do_step(c, time, step);
    *event_handling_needed = *terminate = *early_return = fmi3False;
    *last_successful_time = c->memory.time;
    return done ? fmi3OK : report3(component, fmi3Discard, __func__);
}

fmi3Status fmi3EnterStepMode(fmi3Instance pointer) {
    REFUSE("Step Mode is entered at the end of the initialisation: %s has no Event Mode in Co-Simulation", MODEL_NAME);
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t n_values) {
    (void)vr, (void)n, (void)orders, (void)values, (void)n_values;
    REFUSE("%s provides no derivatives of outputs", MODEL_NAME);
}
