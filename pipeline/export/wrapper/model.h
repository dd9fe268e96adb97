/* What is generated for one model (model.c): tables over its variables, and its equations.

   Every equation is a CasADi function of (t, x, u, p, z, r): time, states, inputs, parameters, discrete variables, and
   the values that relations keep between events. Nothing here knows of FMI. */
#ifndef MODEL_H
#define MODEL_H

#include <stdint.h>
#include <string.h>

#include "model_counts.h"

/* The values of all variables stand in one array, in this order; a value reference is an index into it. The last one,
   behind them, is that of time. */
#define FIRST_PARAMETER 0
#define FIRST_CALCULATED (N_CONSTANTS + N_PARAMETERS)
#define FIRST_STATE (FIRST_CALCULATED + N_CALCULATED)
#define FIRST_DISCRETE (FIRST_STATE + N_STATES)
#define FIRST_INPUT (FIRST_DISCRETE + N_DISCRETES)
#define FIRST_DERIVATIVE (FIRST_INPUT + N_INPUTS)
#define FIRST_ALGEBRAIC (FIRST_DERIVATIVE + N_STATES)
#define FIRST_INDICATOR (FIRST_ALGEBRAIC + N_ALGEBRAICS)
#define N_VALUES (FIRST_INDICATOR + N_RELATIONS)
#define TIME N_VALUES

typedef enum { REAL, INTEGER, BOOLEAN } Type;

/* Who may set a variable, and when: see SETTABLE in values.c. The start value of a FOLLOWING state or discrete variable
   is computed from parameters. */
typedef enum {
    CONSTANT, FIXED, TUNABLE, CALCULATED, STATE, FOLLOWING_STATE, DISCRETE, FOLLOWING_DISCRETE, INPUT, COMPUTED,
    INDEPENDENT
} Kind;

typedef struct {
    const char *name;
    Kind kind;
    Type type;
    double start;
} Variable;

extern const char *const MODEL_NAME;
extern const char *const MODEL_GUID;
extern const Variable VARIABLES[];
extern const double NOMINALS[];         /* of the states */
extern const unsigned SOURCES[];        /* where the value of each algebraic variable stands: y = x has x's */
extern const char *const ASSERTIONS[];  /* the message of each */

typedef int ModelFunction(const double **arguments, double **results, long long *, double *recalled, int);

/* f(x), computed only where x has changed since the last time: an estimator asks for many evaluations that differ in one
   state or parameter. last: x and f(x) of then, for each place in the equations where a function stands. */
static inline double recall(double f(double), double x, double *last) {
    uint64_t now, then;
    memcpy(&now, &x, sizeof x);
    memcpy(&then, last, sizeof *last);
    if (now != then) {
        last[0] = x;
        last[1] = f(x);
    }
    return last[1];
}

ModelFunction model_calculated;   /* -> calculated parameters */
ModelFunction model_start;        /* -> start values of states and of discrete variables */
ModelFunction model_derivatives;  /* -> derivatives of the states */
ModelFunction model_algebraics;   /* -> algebraic variables */
ModelFunction model_relations;    /* -> truth of every relation, indicator of every relation */
ModelFunction model_instants;     /* -> when the relations that time alone decides switch */
ModelFunction model_clocks;       /* -> period of every clock, phase of every clock */
ModelFunction model_event;        /* (…, r_pre, flags) -> discrete variables and states after an event, violated asserts */

/* Their derivatives, by forward mode (tangents: of the results in the direction of the seeds) and by reverse mode
   (adjoint: the transpose). In the running model time, states and inputs are known; in the initialisation parameters
   and the given start values as well. w: the indicators of the relations. */
ModelFunction model_derivatives_tangent;  /* (…, dt, dx, du) -> derivatives */
ModelFunction model_algebraics_tangent;   /* (…, dt, dx, du) -> algebraic variables, w */
ModelFunction model_adjoint;              /* (…, derivatives, algebraic variables, w) -> dt, dx, du */
ModelFunction model_start_tangent;  /* (…, dt, dp, dx, dz, du) -> calculated, x, z, derivatives, algebraics, w */
ModelFunction model_start_adjoint;  /* (…, calculated, x, z, derivatives, algebraics, w) -> dt, dp, dx, dz, du */

#endif
