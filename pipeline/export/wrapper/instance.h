/* One instance of the model: its memory, and what can be done with it. Nothing here knows of an FMI version. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "model.h"

/* The modes of an instance, a bit each. STEP: Co-Simulation after its initialisation. */
typedef enum {
    INSTANTIATED = 1, INITIALIZATION = 2, EVENT = 4, CONTINUOUS = 8, STEP = 16, TERMINATED = 32
} Mode;
#define RUNNING (EVENT | CONTINUOUS | STEP)
#define ANY_MODE (INSTANTIATED | INITIALIZATION | RUNNING | TERMINATED)

/* What has to be computed again before it is read. */
enum { STALE_CALCULATED = 1, STALE_START = 2, STALE_DERIVATIVES = 4, STALE_ALGEBRAICS = 8 };
#define STALE_ALL (STALE_CALCULATED | STALE_START | STALE_DERIVATIVES | STALE_ALGEBRAICS)

#define MAX_ITERATIONS 100  /* of relations that depend on each other */

/* Everything an FMU state holds: plain numbers, copied as a whole. */
typedef struct {
    int mode;
    int stale;
    double time;
    double values[N_VALUES + 1];
    double relations[N_RELATIONS + 1];
    double periods[N_CLOCKS + 1];
    double phases[N_CLOCKS + 1];
    double ticks[N_CLOCKS + 1];  /* the next sample instant of a clock is phase + ticks * period */
} Memory;

typedef struct {
    Memory memory;
    double recalled[2 * N_RECALLED + 1];  /* see recall() in model.h: true of any state, so no part of it */
    bool co_simulation;
    char message[512];  /* why the last call failed */
} Instance;

#define P(c) ((c)->memory.values + FIRST_PARAMETER)
#define X(c) ((c)->memory.values + FIRST_STATE)
#define Z(c) ((c)->memory.values + FIRST_DISCRETE)
#define U(c) ((c)->memory.values + FIRST_INPUT)
#define DX(c) ((c)->memory.values + FIRST_DERIVATIVE)
#define Y(c) ((c)->memory.values + FIRST_ALGEBRAIC)
#define W(c) ((c)->memory.values + FIRST_INDICATOR)

/* Keep a message for the log. Always false, so that a check can end with it. */
bool fail(Instance *c, const char *format, ...);

/* Nothing is wrong in these modes; otherwise the message names the one the instance stands in. */
bool wrong_mode(Instance *c, int modes);
static inline bool in_mode(Instance *c, int modes) { return c->memory.mode & modes || wrong_mode(c, modes); }

/* An array of the caller has the length it must have. */
bool wrong_count(Instance *c, size_t n, size_t expected, const char *what);
static inline bool right_count(Instance *c, size_t n, size_t expected, const char *what) {
    return n == expected || wrong_count(c, n, expected, what);
}

/* What to say of a number that is infinite or none, whose printed form differs from machine to machine. */
const char *not_finite(double value);

/* evaluate.c */
static inline void evaluate(Instance *c, ModelFunction *function, const double **arguments, double **results) {
    function(arguments, results, NULL, c->recalled, 0);
}

void reset(Instance *c);
void changed(Instance *c, bool parameter);  /* a value was set */
void set_time(Instance *c, double time);
void set_states(Instance *c, const double *x);
void refresh(Instance *c, int what);   /* compute what is stale */
void indicators(Instance *c, double *truth, double *indicator);

/* Derivatives at any time and state, with the inputs and parameters of the instance, whose calculated parameters are
   up to date. */
static inline void derivatives(Instance *c, double time, const double *x, double *dx) {
    const double *arguments[] = {&time, x, U(c), P(c), Z(c), c->memory.relations};
    double *results[] = {dx};
    evaluate(c, model_derivatives, arguments, results);
}

bool wrong_derivative(Instance *c, double time, size_t i, double value);
static inline bool finite_derivatives(Instance *c, double time, const double *dx) {
    for (size_t i = 0; i < N_STATES; i++)
        if (!isfinite(dx[i])) return wrong_derivative(c, time, i, dx[i]);
    return true;
}

/* values.c */
bool get_values(Instance *c, const unsigned *references, size_t n, Type type, double *values);
bool get_integer(Instance *c, unsigned reference, Type type, int *value);
bool set_values(Instance *c, const unsigned *references, size_t n, Type type, const double *values);

/* There is a variable of this type behind the reference. */
bool wrong_reference(Instance *c, unsigned reference, Type type);
static inline bool is_variable(Instance *c, unsigned reference, Type type) {
    return (reference <= TIME && VARIABLES[reference].type == type) || wrong_reference(c, reference, type);
}

/* linearise.c */
bool directional_derivative(Instance *c, const unsigned *unknowns, size_t n_unknowns, const unsigned *knowns,
                            size_t n_knowns, const double *seed, double *sensitivity);
bool adjoint_derivative(Instance *c, const unsigned *unknowns, size_t n_unknowns, const unsigned *knowns,
                        size_t n_knowns, const double *seed, double *sensitivity);

/* events.c */
typedef struct {
    bool states_changed, next_defined;
    double next_time;
} Outcome;

bool start_events(Instance *c);
bool handle_event(Instance *c, bool initial);
bool run_event(Instance *c, Outcome *outcome);
bool tick_due(const Instance *c);
double next_tick(Instance *c, double *tolerance);

/* integrate.c */
bool step_allowed(Instance *c, double time, double step);
bool do_step(Instance *c, double time, double step);

/* state.c: the FMU state is a copy of the memory, serialised behind the model's GUID */
size_t state_size(void);
bool keep_state(Instance *c, void **state);
bool restore_state(Instance *c, const void *state);
bool write_state(Instance *c, const void *state, void *bytes, size_t size);
bool read_state(Instance *c, const void *bytes, size_t size, void **state);

#endif
