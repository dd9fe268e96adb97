/* FMI 3.0: reading and setting variables, each a scalar. */
#include "fmi3_layer.h"

static bool scalars(Instance *c, size_t n, size_t n_values) {
    return n == n_values || fail(c, "%zu values for %zu variables: every variable is a scalar", n_values, n);
}

fmi3Status fmi3GetFloat64(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[],
                          size_t n_values) {
    ENTER(ANY_MODE);
    GIVE(scalars(c, n, n_values) && get_values(c, vr, n, REAL, values));
}

fmi3Status fmi3SetFloat64(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[],
                          size_t n_values) {
    ENTER(ANY_MODE);
    GIVE(scalars(c, n, n_values) && set_values(c, vr, n, REAL, values));
}

/* The types whose values are kept as numbers of another one. */
#define CONVERTED(Name, TYPE)                                                                                       \
    fmi3Status fmi3Get##Name(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, fmi3##Name values[],    \
                             size_t n_values) {                                                                     \
        ENTER(ANY_MODE);                                                                                            \
        bool good = scalars(c, n, n_values);                                                                        \
        for (size_t i = 0; good && i < n; i++) {                                                                    \
            int number = 0;                                                                                         \
            good = get_integer(c, vr[i], TYPE, &number);                                                            \
            values[i] = (fmi3##Name)number;                                                                         \
        }                                                                                                           \
        GIVE(good);                                                                                                 \
    }                                                                                                               \
                                                                                                                    \
    fmi3Status fmi3Set##Name(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n,                         \
                             const fmi3##Name values[], size_t n_values) {                                          \
        ENTER(ANY_MODE);                                                                                            \
        bool good = scalars(c, n, n_values);                                                                        \
        for (size_t i = 0; good && i < n; i++) {                                                                    \
            double number = (double)values[i];                                                                      \
            good = set_values(c, vr + i, 1, TYPE, &number);                                                         \
        }                                                                                                           \
        GIVE(good);                                                                                                 \
    }

CONVERTED(Int32, INTEGER)
CONVERTED(Boolean, BOOLEAN)

/* The types that no variable has. */
#define ABSENT(Name)                                                                                                \
    fmi3Status fmi3Get##Name(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, fmi3##Name values[],    \
                             size_t n_values) {                                                                     \
        (void)vr, (void)values, (void)n_values;                                                                     \
        ENTER(ANY_MODE);                                                                                            \
        GIVE(!n || fail(c, "%s has no " #Name " variables", MODEL_NAME));                                           \
    }                                                                                                               \
                                                                                                                    \
    fmi3Status fmi3Set##Name(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n,                         \
                             const fmi3##Name values[], size_t n_values) {                                          \
        (void)vr, (void)values, (void)n_values;                                                                     \
        ENTER(ANY_MODE);                                                                                            \
        GIVE(!n || fail(c, "%s has no " #Name " variables", MODEL_NAME));                                           \
    }

ABSENT(Float32)
ABSENT(Int8)
ABSENT(UInt8)
ABSENT(Int16)
ABSENT(UInt16)
ABSENT(UInt32)
ABSENT(Int64)
ABSENT(UInt64)
ABSENT(String)

fmi3Status fmi3GetBinary(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, size_t sizes[],
                         fmi3Binary values[], size_t n_values) {
    (void)vr, (void)sizes, (void)values, (void)n_values;
    ENTER(ANY_MODE);
    GIVE(!n || fail(c, "%s has no Binary variables", MODEL_NAME));
}

fmi3Status fmi3SetBinary(fmi3Instance pointer, const fmi3ValueReference vr[], size_t n, const size_t sizes[],
                         const fmi3Binary values[], size_t n_values) {
    (void)vr, (void)sizes, (void)values, (void)n_values;
    ENTER(ANY_MODE);
    GIVE(!n || fail(c, "%s has no Binary variables", MODEL_NAME));
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance pointer, fmi3ValueReference vr, size_t *n) {
    (void)vr, (void)n;
    REFUSE("dependencies are listed in the model description of %s only", MODEL_NAME);
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance pointer, fmi3ValueReference dependent, size_t elements[],
                                       fmi3ValueReference independents[], size_t elements_of_independents[],
                                       fmi3DependencyKind kinds[], size_t n) {
    (void)dependent, (void)elements, (void)independents, (void)elements_of_independents, (void)kinds, (void)n;
    REFUSE("dependencies are listed in the model description of %s only", MODEL_NAME);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance pointer, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                        const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                        size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {
    ENTER(INITIALIZATION | RUNNING);
    GIVE(scalars(c, n_knowns, n_seed) && scalars(c, n_unknowns, n_sensitivity) &&
         directional_derivative(c, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity));
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance pointer, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                    const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                    size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {
    ENTER(INITIALIZATION | RUNNING);
    GIVE(scalars(c, n_unknowns, n_seed) && scalars(c, n_knowns, n_sensitivity) &&
         adjoint_derivative(c, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity));
}
