/* Reading and setting variables by value reference. */
#include "instance.h"

#include <limits.h>
#include <math.h>

/* The modes in which a variable of each kind may be set. For states Model Exchange has a call of its own, but there are
   importers that use this one. */
static const int SETTABLE[] = {
    [CONSTANT] = 0,
    [FIXED] = INSTANTIATED | INITIALIZATION,
    [TUNABLE] = INSTANTIATED | INITIALIZATION | EVENT | STEP,
    [CALCULATED] = 0,
    [STATE] = INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | STEP,
    [FOLLOWING_STATE] = EVENT | CONTINUOUS | STEP,
    [DISCRETE] = INSTANTIATED | INITIALIZATION,
    [FOLLOWING_DISCRETE] = 0,
    [INPUT] = INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | STEP,
    [COMPUTED] = 0,
    [INDEPENDENT] = 0,
};

static const char *const WHEN[] = {
    [CONSTANT] = "a constant of the built FMU",
    [FIXED] = "a fixed parameter, set before or in the initialisation only",
    [TUNABLE] = "a tunable parameter, in Model Exchange set in Event Mode only",
    [CALCULATED] = "computed from other parameters",
    [STATE] = "a state of a terminated instance",
    [FOLLOWING_STATE] = "a state whose start value follows from parameters",
    [DISCRETE] = "a discrete variable, set before or in the initialisation only",
    [FOLLOWING_DISCRETE] = "a discrete variable whose start value follows from parameters",
    [INPUT] = "an input of a terminated instance",
    [COMPUTED] = "computed by the equations",
    [INDEPENDENT] = "the independent variable",
};

static const char *const TYPES[] = {"Real", "Integer", "Boolean"};

bool wrong_reference(Instance *c, unsigned reference, Type type) {
    return fail(c, "value reference %u is no %s variable of %s", reference, TYPES[type], MODEL_NAME);
}

static double value_of(Instance *c, unsigned reference) {
    double truth[N_RELATIONS + 1];
    if (reference == TIME) return c->memory.time;
    if (reference >= FIRST_INDICATOR)
        indicators(c, truth, W(c));
    else if (reference >= FIRST_ALGEBRAIC) {
        unsigned source = SOURCES[reference - FIRST_ALGEBRAIC];
        if (source != reference) return c->memory.values[source];
        refresh(c, STALE_ALGEBRAICS);
    } else if (reference >= FIRST_DERIVATIVE)
        refresh(c, STALE_DERIVATIVES);
    return c->memory.values[reference];
}

bool get_values(Instance *c, const unsigned *references, size_t n, Type type, double *values) {
    refresh(c, 0);
    for (size_t i = 0; i < n; i++) {
        if (!is_variable(c, references[i], type)) return false;
        values[i] = value_of(c, references[i]);
    }
    return true;
}

/* An Integer or Boolean: all values are kept as numbers, and equations may leave the range. */
bool get_integer(Instance *c, unsigned reference, Type type, int *value) {
    double number;
    if (!get_values(c, &reference, 1, type, &number)) return false;
    if (!(number >= INT_MIN && number <= INT_MAX))
        return fail(c, "%s is %g: no Integer of 32 bits", VARIABLES[reference].name, number);
    *value = (int)number;
    return true;
}

bool set_values(Instance *c, const unsigned *references, size_t n, Type type, const double *values) {
    bool parameter = false;
    for (size_t i = 0; i < n; i++) {
        unsigned reference = references[i];
        if (!is_variable(c, reference, type)) return false;
        const Variable *variable = &VARIABLES[reference];
        if (!(SETTABLE[variable->kind] & c->memory.mode))
            return fail(c, "%s cannot be set now: it is %s", variable->name, WHEN[variable->kind]);
        if (!isfinite(values[i])) return fail(c, "%s cannot be set to what is %s", variable->name, not_finite(values[i]));
    }
    for (size_t i = 0; i < n; i++) {
        c->memory.values[references[i]] = values[i];
        parameter |= references[i] < FIRST_CALCULATED;
    }
    changed(c, parameter);
    return true;
}
