/* Values that follow from others, computed when they are read. */
#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

bool fail(Instance *c, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(c->message, sizeof c->message, format, arguments);
    va_end(arguments);
    return false;
}

const char *not_finite(double value) { return isnan(value) ? "not a number" : "infinite"; }

bool wrong_mode(Instance *c, int modes) {
    static const struct { int mode; const char *name; } NAMES[] = {
        {INSTANTIATED, "Instantiated"}, {INITIALIZATION, "Initialization Mode"}, {EVENT, "Event Mode"},
        {CONTINUOUS, "Continuous-Time Mode"}, {STEP, "Step Mode"}, {TERMINATED, "Terminated"}};
    const char *now = "", *wanted = "";
    for (size_t i = 0; i < sizeof NAMES / sizeof *NAMES; i++) {
        if (NAMES[i].mode & c->memory.mode) now = NAMES[i].name;
        if (NAMES[i].mode & modes && !*wanted) wanted = NAMES[i].name;
    }
    return fail(c, "not allowed in the state %s (first allowed in: %s)", now, wanted);
}

bool wrong_count(Instance *c, size_t n, size_t expected, const char *what) {
    return fail(c, "%zu %s asked for, %s has %zu", n, what, MODEL_NAME, expected);
}

void reset(Instance *c) {
    memset(&c->memory, 0, sizeof c->memory);
    for (size_t i = 0; i < N_VALUES; i++) c->memory.values[i] = VARIABLES[i].start;
    c->memory.mode = INSTANTIATED;
    c->memory.stale = STALE_ALL;
    for (size_t i = 0; i < 2 * N_RECALLED; i++) c->recalled[i] = NAN;
}

static void moved(Instance *c) {
    c->memory.stale |= STALE_DERIVATIVES | STALE_ALGEBRAICS;
    if (c->memory.mode & (INSTANTIATED | INITIALIZATION)) c->memory.stale |= STALE_START;
}

void changed(Instance *c, bool parameter) {
    if (parameter) c->memory.stale |= STALE_CALCULATED;
    moved(c);
}

void set_time(Instance *c, double time) {
    c->memory.time = time;
    moved(c);
}

/* One by one: a wide load of what the caller has just written one by one would have to wait for it. */
void set_states(Instance *c, const double *x) {
    for (size_t i = 0; i < N_STATES; i++) X(c)[i] = x[i];
    moved(c);
}

static void start_values(Instance *c, const double **arguments) {
    double x[N_STATES + 1], z[N_DISCRETES + 1];
    double *results[] = {x, z};
    evaluate(c, model_start, arguments, results);
    for (size_t i = 0; i < N_STATES; i++)
        if (VARIABLES[FIRST_STATE + i].kind == FOLLOWING_STATE) X(c)[i] = x[i];
    for (size_t i = 0; i < N_DISCRETES; i++)
        if (VARIABLES[FIRST_DISCRETE + i].kind == FOLLOWING_DISCRETE) Z(c)[i] = z[i];
}

/* Before the first event no relation is held: each follows from the start values. */
static void start_relations(Instance *c, const double **arguments) {
    double truth[N_RELATIONS + 1];
    double *results[] = {truth, W(c)};
    for (int k = 0; N_RELATIONS > 0 && k < MAX_ITERATIONS; k++) {
        evaluate(c, model_relations, arguments, results);
        bool settled = !memcmp(truth, c->memory.relations, N_RELATIONS * sizeof *truth);
        memcpy(c->memory.relations, truth, N_RELATIONS * sizeof *truth);
        if (settled) return;
    }
}

void refresh(Instance *c, int what) {
    Memory *m = &c->memory;
    const double *arguments[] = {&m->time, X(c), U(c), P(c), Z(c), m->relations};
    if (!(m->stale & (what | STALE_CALCULATED | STALE_START))) return;
    if (m->stale & STALE_CALCULATED) {
        double *results[] = {m->values + FIRST_CALCULATED};
        evaluate(c, model_calculated, arguments, results);
    }
    if (m->stale & STALE_START) {
        start_values(c, arguments);
        start_relations(c, arguments);
    }
    m->stale &= ~(STALE_CALCULATED | STALE_START);
    if (m->stale & what & STALE_DERIVATIVES) {
        double *results[] = {DX(c)};
        evaluate(c, model_derivatives, arguments, results);
    }
    if (m->stale & what & STALE_ALGEBRAICS) {
        double *results[] = {Y(c)};
        evaluate(c, model_algebraics, arguments, results);
    }
    m->stale &= ~what;
}

bool wrong_derivative(Instance *c, double time, size_t i, double value) {
    return fail(c, "%s is %s at time %g s: check parameters, inputs and states", VARIABLES[FIRST_DERIVATIVE + i].name,
                not_finite(value), time);
}

void indicators(Instance *c, double *truth, double *indicator) {
    Memory *m = &c->memory;
    refresh(c, 0);
    const double *arguments[] = {&m->time, X(c), U(c), P(c), Z(c), m->relations};
    double *results[] = {truth, indicator};
    evaluate(c, model_relations, arguments, results);
}
