/* Directional and adjoint derivatives of the equations, where the instance stands; relations keep their values.

   Seeds and sensitivities stand in arrays like that of the variables' values: see model.h. */
#include "instance.h"

#include <math.h>
#include <string.h>

typedef double Values[TIME + 1];

/* The modes in which a variable of each kind is a known and an unknown (FMI 2.0.5, 2.1.9 and 2.2.8; 3.0.2, 2.2.11).
   A discrete variable is held between events: no known moves it. */
static const int KNOWN[] = {
    [FIXED] = INITIALIZATION,
    [TUNABLE] = INITIALIZATION,
    [STATE] = INITIALIZATION | RUNNING,
    [FOLLOWING_STATE] = RUNNING,
    [DISCRETE] = INITIALIZATION,
    [INPUT] = INITIALIZATION | RUNNING,
    [INDEPENDENT] = INITIALIZATION | RUNNING,
};

static const int UNKNOWN[] = {
    [CALCULATED] = INITIALIZATION,
    [STATE] = INITIALIZATION | RUNNING,
    [FOLLOWING_STATE] = INITIALIZATION | RUNNING,
    [DISCRETE] = INITIALIZATION | RUNNING,
    [FOLLOWING_DISCRETE] = INITIALIZATION | RUNNING,
    [COMPUTED] = INITIALIZATION | RUNNING,
    [INDEPENDENT] = 0,
};

static const char *const WHAT[] = {
    [CONSTANT] = "a constant of the built FMU",
    [FIXED] = "a parameter, known in Initialization Mode only",
    [TUNABLE] = "a parameter, known in Initialization Mode only",
    [CALCULATED] = "a calculated parameter, unknown in Initialization Mode only",
    [STATE] = "a state",
    [FOLLOWING_STATE] = "a state whose start value follows from parameters",
    [DISCRETE] = "a discrete variable, known in Initialization Mode only",
    [FOLLOWING_DISCRETE] = "a discrete variable whose start value follows from parameters",
    [INPUT] = "an input",
    [COMPUTED] = "computed by the equations",
    [INDEPENDENT] = "the independent variable",
};

static bool all_are(Instance *c, const int *modes, const char *role, const unsigned *references, size_t n) {
    for (size_t i = 0; i < n; i++) {
        if (!is_variable(c, references[i], REAL)) return false;
        const Variable *variable = &VARIABLES[references[i]];
        if (!(modes[variable->kind] & c->memory.mode))
            return fail(c, "%s is no %s of a derivative now: it is %s", variable->name, role, WHAT[variable->kind]);
    }
    return true;
}

static bool finite(Instance *c, const unsigned *references, size_t n, const double *sensitivity) {
    for (size_t i = 0; i < n; i++)
        if (!isfinite(sensitivity[i]))
            return fail(c, "the derivative of %s is %s at time %g s: check parameters, inputs and states",
                        VARIABLES[references[i]].name, not_finite(sensitivity[i]), c->memory.time);
    return true;
}

static bool any_in(const unsigned *references, size_t n, unsigned first, unsigned end) {
    for (size_t i = 0; i < n; i++)
        if (references[i] >= first && references[i] < end) return true;
    return false;
}

/* The arguments of every function of the model, and after them more. */
#define ARGUMENTS(c, ...) {&(c)->memory.time, X(c), U(c), P(c), Z(c), (c)->memory.relations, __VA_ARGS__}

/* Fill in the tangents of what is computed, as far as it is asked for: the states stand for themselves. */
static void running_tangent(Instance *c, const unsigned *unknowns, size_t n, double *v) {
    const double *arguments[] = ARGUMENTS(c, v + TIME, v + FIRST_STATE, v + FIRST_INPUT);
    if (any_in(unknowns, n, FIRST_DERIVATIVE, FIRST_ALGEBRAIC)) {
        double *results[] = {v + FIRST_DERIVATIVE};
        evaluate(c, model_derivatives_tangent, arguments, results);
    }
    if (any_in(unknowns, n, FIRST_ALGEBRAIC, TIME)) {
        double *results[] = {v + FIRST_ALGEBRAIC, v + FIRST_INDICATOR};
        evaluate(c, model_algebraics_tangent, arguments, results);
    }
}

static void start_tangent(Instance *c, double *v) {
    Values seed;
    memcpy(seed, v, sizeof seed);
    const double *arguments[] = ARGUMENTS(c, seed + TIME, seed + FIRST_PARAMETER, seed + FIRST_STATE,
                                          seed + FIRST_DISCRETE, seed + FIRST_INPUT);
    double *results[] = {v + FIRST_CALCULATED, v + FIRST_STATE,     v + FIRST_DISCRETE,
                         v + FIRST_DERIVATIVE, v + FIRST_ALGEBRAIC, v + FIRST_INDICATOR};
    evaluate(c, model_start_tangent, arguments, results);
}

/* The transposes of both: from the weights of the unknowns to those of the knowns. */
static void running_adjoint(Instance *c, double *v) {
    double x[N_STATES + 1];
    const double *arguments[] = ARGUMENTS(c, v + FIRST_DERIVATIVE, v + FIRST_ALGEBRAIC, v + FIRST_INDICATOR);
    double *results[] = {v + TIME, x, v + FIRST_INPUT};
    evaluate(c, model_adjoint, arguments, results);
    for (size_t i = 0; i < N_STATES; i++) v[FIRST_STATE + i] += x[i];
}

static void start_adjoint(Instance *c, double *v) {
    Values weight;
    memcpy(weight, v, sizeof weight);
    const double *arguments[] = ARGUMENTS(c, weight + FIRST_CALCULATED, weight + FIRST_STATE, weight + FIRST_DISCRETE,
                                          weight + FIRST_DERIVATIVE, weight + FIRST_ALGEBRAIC,
                                          weight + FIRST_INDICATOR);
    double *results[] = {v + TIME, v + FIRST_PARAMETER, v + FIRST_STATE, v + FIRST_DISCRETE, v + FIRST_INPUT};
    evaluate(c, model_start_adjoint, arguments, results);
}

bool directional_derivative(Instance *c, const unsigned *unknowns, size_t n_unknowns, const unsigned *knowns,
                            size_t n_knowns, const double *seed, double *sensitivity) {
    Values v = {0};
    if (!all_are(c, UNKNOWN, "unknown", unknowns, n_unknowns) || !all_are(c, KNOWN, "known", knowns, n_knowns))
        return false;
    for (size_t i = 0; i < n_knowns; i++) v[knowns[i]] += seed[i];
    refresh(c, 0);
    if (c->memory.mode == INITIALIZATION)
        start_tangent(c, v);
    else
        running_tangent(c, unknowns, n_unknowns, v);
    for (size_t i = 0; i < n_unknowns; i++) sensitivity[i] = v[unknowns[i]];
    return finite(c, unknowns, n_unknowns, sensitivity);
}

bool adjoint_derivative(Instance *c, const unsigned *unknowns, size_t n_unknowns, const unsigned *knowns,
                        size_t n_knowns, const double *seed, double *sensitivity) {
    Values v = {0};
    if (!all_are(c, UNKNOWN, "unknown", unknowns, n_unknowns) || !all_are(c, KNOWN, "known", knowns, n_knowns))
        return false;
    for (size_t i = 0; i < n_unknowns; i++) v[unknowns[i]] += seed[i];
    refresh(c, 0);
    if (c->memory.mode == INITIALIZATION)
        start_adjoint(c, v);
    else
        running_adjoint(c, v);
    for (size_t i = 0; i < n_knowns; i++) sensitivity[i] = v[knowns[i]];
    return finite(c, knowns, n_knowns, sensitivity);
}
