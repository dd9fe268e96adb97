/* FMI 3.0: clocks, Scheduled Execution and structural parameters, which no FMU of ours has. */
#include "fmi3_layer.h"

#define NO_CLOCKS REFUSE("%s has no clocks", MODEL_NAME)
#define NO_CONFIGURATION REFUSE("%s has no structural parameters", MODEL_NAME)

fmi3Status fmi3EnterConfigurationMode(fmi3Instance pointer) { NO_CONFIGURATION; }

fmi3Status fmi3ExitConfigurationMode(fmi3Instance pointer) { NO_CONFIGURATION; }

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance pointer) {
    REFUSE("%s evaluates its discrete states in fmi3UpdateDiscreteStates only", MODEL_NAME);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance pointer, fmi3ValueReference clock, fmi3Float64 time) {
    (void)clock, (void)time;
    NO_CLOCKS;
}

fmi3Status fmi3GetClock(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, fmi3Clock values[]) {
    (void)vr, (void)n, (void)values;
    NO_CLOCKS;
}

fmi3Status fmi3SetClock(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, const fmi3Clock values[]) {
    (void)vr, (void)n, (void)values;
    NO_CLOCKS;
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
    (void)vr, (void)n, (void)intervals, (void)qualifiers;
    NO_CLOCKS;
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n,
                                   fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[]) {
    (void)vr, (void)n, (void)counters, (void)resolutions, (void)qualifiers;
    NO_CLOCKS;
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, fmi3Float64 shifts[]) {
    (void)vr, (void)n, (void)shifts;
    NO_CLOCKS;
}

fmi3Status fmi3GetShiftFraction(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counters[],
                                fmi3UInt64 resolutions[]) {
    (void)vr, (void)n, (void)counters, (void)resolutions;
    NO_CLOCKS;
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n,
                                  const fmi3Float64 intervals[]) {
    (void)vr, (void)n, (void)intervals;
    NO_CLOCKS;
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n,
                                   const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]) {
    (void)vr, (void)n, (void)counters, (void)resolutions;
    NO_CLOCKS;
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n,
                               const fmi3Float64 shifts[]) {
    (void)vr, (void)n, (void)shifts;
    NO_CLOCKS;
}

fmi3Status fmi3SetShiftFraction(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n,
                                const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]) {
    (void)vr, (void)n, (void)counters, (void)resolutions;
    NO_CLOCKS;
}
