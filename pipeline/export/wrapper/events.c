/* Events: sample instants, relations that switch, the initialisation. */
#include "instance.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Without them no event changes anything. */
#define ACTORS (N_CLOCKS + N_RELATIONS + N_DISCRETES + N_ASSERTIONS + N_REINITS)

/* How far round-off may move a communication point, which is k*dt or a running sum of dt: relative to the time since
   0 and 1 s, but never more than this part of a sample period. */
#define TIME_TOLERANCE 1e-8
#define PERIOD_TOLERANCE 1e-4

static double instant(const Memory *m, size_t i) { return m->phases[i] + m->ticks[i] * m->periods[i]; }

static double tolerance(const Memory *m, size_t i) {
    return fmin(PERIOD_TOLERANCE * m->periods[i], TIME_TOLERANCE * (1 + fabs(m->time)));
}

/* The time in periods of a clock, since its phase. */
static double periods(const Memory *m, size_t i, double offset) {
    return (m->time + offset - m->phases[i]) / m->periods[i];
}

static bool due(const Memory *m, size_t i) { return m->time >= instant(m, i) - tolerance(m, i); }

bool tick_due(const Instance *c) {
    for (size_t i = 0; i < N_CLOCKS; i++)
        if (due(&c->memory, i)) return true;
    return false;
}

/* The next instant of a relation that time alone decides, DBL_MAX without one. */
static double next_instant(Instance *c) {
    double instants[N_INSTANTS + 1], next = DBL_MAX;
    if (!N_INSTANTS) return next;
    const double *arguments[] = {&c->memory.time, X(c), U(c), P(c), Z(c), c->memory.relations};
    double *results[] = {instants};
    evaluate(c, model_instants, arguments, results);
    for (size_t i = 0; i < N_INSTANTS; i++)
        if (instants[i] > c->memory.time) next = fmin(next, instants[i]);
    return next;
}

/* The next time event, DBL_MAX without one, and how exactly a point of time has to meet it. */
double next_tick(Instance *c, double *how_exactly) {
    double next = next_instant(c);
    *how_exactly = 0;
    for (size_t i = 0; i < N_CLOCKS; i++)
        if (instant(&c->memory, i) < next) {
            next = instant(&c->memory, i);
            *how_exactly = tolerance(&c->memory, i);
        }
    return next;
}

/* Set the flags of the clocks that are due and move these on: a second event at the same instant finds none. */
static void take_ticks(Memory *m, double *flags) {
    for (size_t i = 0; i < N_CLOCKS; i++) {
        flags[i] = due(m, i);
        if (flags[i]) m->ticks[i] = fmax(m->ticks[i], floor(periods(m, i, tolerance(m, i)))) + 1;
    }
}

static bool start_clocks(Instance *c) {
    Memory *m = &c->memory;
    const double *arguments[] = {&m->time, X(c), U(c), P(c), Z(c), m->relations};
    double *results[] = {m->periods, m->phases};
    evaluate(c, model_clocks, arguments, results);
    for (size_t i = 0; i < N_CLOCKS; i++) {
        if (!(m->periods[i] > 0)) return fail(c, "a sample period is %g s: it must be positive", m->periods[i]);
        m->ticks[i] = fmax(0, ceil(periods(m, i, -tolerance(m, i))));
    }
    return true;
}

/* One pass: the relations as they now are, the clauses that act on them. *settled: nothing has changed. */
static bool pass(Instance *c, const double *flags, bool *settled) {
    Memory *m = &c->memory;
    double truth[N_RELATIONS + 1], indicator[N_RELATIONS + 1];
    double x[N_STATES + 1], z[N_DISCRETES + 1], violated[N_ASSERTIONS + 1];
    indicators(c, truth, indicator);
    const double *arguments[] = {&m->time, X(c), U(c), P(c), Z(c), truth, m->relations, flags};
    double *results[] = {z, x, violated};
    evaluate(c, model_event, arguments, results);
    for (size_t i = 0; i < N_ASSERTIONS; i++)
        if (violated[i] != 0) return fail(c, "at time %g s: %s", m->time, ASSERTIONS[i]);
    *settled = !memcmp(truth, m->relations, N_RELATIONS * sizeof *truth) &&
               !memcmp(x, X(c), N_STATES * sizeof *x) && !memcmp(z, Z(c), N_DISCRETES * sizeof *z);
    memcpy(m->relations, truth, N_RELATIONS * sizeof *truth);
    memcpy(X(c), x, N_STATES * sizeof *x);
    memcpy(Z(c), z, N_DISCRETES * sizeof *z);
    m->stale |= STALE_DERIVATIVES | STALE_ALGEBRAICS;
    return true;
}

/* Run an event to its end: clauses act on ticks in the first pass, on relations that switch in any. */
bool handle_event(Instance *c, bool initial) {
    double flags[N_CLOCKS + 1] = {initial};
    bool settled = false;
    if (!initial) take_ticks(&c->memory, flags + 1);
    for (int k = 0; k < MAX_ITERATIONS; k++) {
        if (!pass(c, flags, &settled)) return false;
        if (settled && k > 0) return true;
        memset(flags, 0, sizeof flags);
    }
    return fail(c, "the event at time %g s does not settle: relations keep switching", c->memory.time);
}

/* An event that the importer has entered. */
bool run_event(Instance *c, Outcome *outcome) {
    double before[N_STATES + 1], how_exactly;
    *outcome = (Outcome){.next_time = DBL_MAX};
    if (ACTORS == 0) return true;
    memcpy(before, X(c), N_STATES * sizeof *before);
    if (!handle_event(c, false)) return false;
    outcome->states_changed = memcmp(before, X(c), N_STATES * sizeof *before) != 0;
    outcome->next_time = next_tick(c, &how_exactly);
    outcome->next_defined = outcome->next_time < DBL_MAX;
    return true;
}

/* The end of the initialisation. No relation rises here: a when-clause acts from now on. */
bool start_events(Instance *c) {
    refresh(c, 0);
    return ACTORS == 0 || (start_clocks(c) && handle_event(c, true));
}
