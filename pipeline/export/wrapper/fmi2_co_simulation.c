/* FMI 2.0: Co-Simulation. */
#include "fmi2_layer.h"

fmi2Status fmi2DoStep(fmi2Component pointer, fmi2Real time, fmi2Real step, fmi2Boolean no_set_prior) {
    (void)no_set_prior;
    ENTER(STEP);
    if (!step_allowed(c, time, step)) return report2(component, fmi2Error, __func__);
    return do_step(c, time, step) ? fmi2OK : report2(component, fmi2Discard, __func__);
}

fmi2Status fmi2CancelStep(fmi2Component pointer) {
    ENTER(STEP);
    fail(c, "no step is under way: steps are not asynchronous");
    return report2(component, fmi2Error, __func__);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component pointer, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    (void)vr, (void)n, (void)order, (void)value;
    ENTER(ANY_MODE);
    fail(c, "inputs are held during a step: they have no derivatives");
    return report2(component, fmi2Error, __func__);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component pointer, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
    (void)vr, (void)n, (void)order, (void)value;
    ENTER(ANY_MODE);
    fail(c, "%s provides no derivatives of outputs", MODEL_NAME);
    return report2(component, fmi2Error, __func__);
}

fmi2Status fmi2GetRealStatus(fmi2Component pointer, const fmi2StatusKind kind, fmi2Real *value) {
    ENTER(ANY_MODE);
    if (kind == fmi2LastSuccessfulTime) {
        *value = c->memory.time;
        return fmi2OK;
    }
    fail(c, "this status is known of asynchronous steps only");
    return report2(component, fmi2Discard, __func__);
}

static fmi2Status no_status(fmi2Component pointer, const char *function) {
    ENTER_AS(ANY_MODE, function);
    fail(c, "this status is known of asynchronous steps only");
    return report2(component, fmi2Discard, function);
}

fmi2Status fmi2GetStatus(fmi2Component pointer, const fmi2StatusKind kind, fmi2Status *value) {
    (void)kind, (void)value;
    return no_status(pointer, __func__);
}

fmi2Status fmi2GetIntegerStatus(fmi2Component pointer, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)kind, (void)value;
    return no_status(pointer, __func__);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component pointer, const fmi2StatusKind kind, fmi2Boolean *value) {
    ENTER(ANY_MODE);
    if (kind != fmi2Terminated) return no_status(pointer, __func__);
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component pointer, const fmi2StatusKind kind, fmi2String *value) {
    (void)kind, (void)value;
    return no_status(pointer, __func__);
}
