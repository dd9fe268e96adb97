/* Co-Simulation: fourth-order Runge-Kutta or explicit Euler with a fixed step, from event to event. */
#include "instance.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define MAX_EVENTS 1000

/* A step of h from the states x at a time to those next, which may be x itself. */
typedef bool Method(Instance *c, double time, double h, const double *x, double *next);

static bool euler(Instance *c, double time, double h, const double *x, double *next) {
    double k[N_STATES + 1];
    derivatives(c, time, x, k);
    if (!finite_derivatives(c, time, k)) return false;
    for (size_t i = 0; i < N_STATES; i++) next[i] = x[i] + h * k[i];
    return true;
}

static bool runge_kutta(Instance *c, double time, double h, const double *x, double *next) {
    double k1[N_STATES + 1], k2[N_STATES + 1], k3[N_STATES + 1], k4[N_STATES + 1], stage[N_STATES + 1];
    derivatives(c, time, x, k1);
    if (!finite_derivatives(c, time, k1)) return false;
    for (size_t i = 0; i < N_STATES; i++) stage[i] = x[i] + h / 2 * k1[i];
    derivatives(c, time + h / 2, stage, k2);
    for (size_t i = 0; i < N_STATES; i++) stage[i] = x[i] + h / 2 * k2[i];
    derivatives(c, time + h / 2, stage, k3);
    for (size_t i = 0; i < N_STATES; i++) stage[i] = x[i] + h * k3[i];
    derivatives(c, time + h, stage, k4);
    for (size_t i = 0; i < N_STATES; i++) k4[i] = (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]) / 6;
    if (!finite_derivatives(c, time, k4)) return false;
    for (size_t i = 0; i < N_STATES; i++) next[i] = x[i] + h * k4[i];
    return true;
}

static void move(Instance *c, double time, const double *x) {
    c->memory.time = time;
    memcpy(X(c), x, N_STATES * sizeof *x);
    c->memory.stale |= STALE_DERIVATIVES | STALE_ALGEBRAICS;
}

static bool switched(Instance *c) {
    double truth[N_RELATIONS + 1], indicator[N_RELATIONS + 1];
    indicators(c, truth, indicator);
    return memcmp(truth, c->memory.relations, N_RELATIONS * sizeof *truth) != 0;
}

/* A step in which relations may switch: on to the first switch (by bisection), and the event there, until h is done. */
static bool step_with_events(Instance *c, Method *method, double h) {
    double x[N_STATES + 1], next[N_STATES + 1];
    double end = c->memory.time + h;
    for (int k = 0; k < MAX_EVENTS; k++) {
        double time = c->memory.time, low = 0, high = end - time;
        if (!(high > 0)) return true;
        memcpy(x, X(c), N_STATES * sizeof *x);
        if (!method(c, time, high, x, next)) return false;
        move(c, end, next);
        if (!switched(c)) return true;
        while (high - low > 4e-16 * (fabs(time) + high)) {
            double middle = low + (high - low) / 2;
            if (middle <= low || middle >= high) break;
            if (!method(c, time, middle, x, next)) return false;
            move(c, time + middle, next);
            if (switched(c)) high = middle; else low = middle;
        }
        if (!method(c, time, high, x, next)) return false;
        move(c, high == end - time ? end : time + high, next);
        if (!handle_event(c, false)) return false;
    }
    return fail(c, "%d events within %g s before time %g s: relations keep switching", MAX_EVENTS, h, end);
}

/* Integrate over a duration in equal steps of internalOrder, none longer than internalStep. What follows from the
   states is stale before and after. */
static bool integrate(Instance *c, double duration) {
#ifdef INTERNAL_STEP  /* there are states, or relations that time switches */
    double start = c->memory.time;
    double longest = P(c)[INTERNAL_STEP], order = P(c)[INTERNAL_ORDER];
    if (!(longest > 0)) return fail(c, "internalStep is %g s: it must be positive", longest);
    if (order != 4 && order != 1) return fail(c, "internalOrder is %g: it must be 4 (Runge-Kutta) or 1 (explicit Euler)", order);
    Method *method = order == 4 ? runge_kutta : euler;
    double n = ceil(duration / longest - 1e-9);
    if (!(n > 1)) n = 1;
    double h = duration / n;
    refresh(c, 0);
    for (double i = 0; i < n; i++) {
        if (N_RELATIONS > 0) {
            if (!step_with_events(c, method, start + (i + 1) * h - c->memory.time)) return false;
        } else {
            if (!method(c, start + i * h, h, X(c), X(c))) return false;
            c->memory.time = start + (i + 1) * h;
        }
    }
#endif
    return true;
}

/* How far round-off may move a communication point: never so far that a step repeated or left out passes for it. */
static double slack(double time, double step) {
    return fmin(1e-6 * (step + fabs(time)), 1e-2 * step) + 4 * DBL_EPSILON * fabs(time);
}

bool step_allowed(Instance *c, double time, double step) {
    if (!isfinite(time) || !isfinite(step))
        return fail(c, "the time or the communication step is %s", not_finite(time + step));
    if (step < 0) return fail(c, "the communication step is %g s at time %g s: it must not be negative", step, time);
    if (time != c->memory.time && fabs(time - c->memory.time) > slack(time, step))
        return fail(c, "the step starts at %.9g s, but the instance stands at %.9g s", time, c->memory.time);
    return true;
}

/* From one communication point to the next. Sample instants at its start tick first, on the inputs as they now are;
   those within it split the integration; one at its end belongs to the next step. */
bool do_step(Instance *c, double time, double step) {
    double end = time + step, how_exactly;
    c->memory.time = time;
    c->memory.stale |= STALE_DERIVATIVES | STALE_ALGEBRAICS;
    for (;;) {
        if (tick_due(c) || N_RELATIONS > 0 || N_ASSERTIONS > 0)
            if (!handle_event(c, false)) return false;
        double tick = next_tick(c, &how_exactly);
        bool last = tick > end - how_exactly;
        double stop = last ? end : tick;
        double duration = last && c->memory.time == time ? step : stop - c->memory.time;
        if (duration > 0 && !integrate(c, duration)) return false;
        c->memory.time = stop;
        c->memory.stale |= STALE_DERIVATIVES | STALE_ALGEBRAICS;
        if (last) return true;
    }
}
