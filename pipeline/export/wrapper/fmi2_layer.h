/* What the files of the FMI 2.0 layer share. */
#ifndef FMI2_LAYER_H
#define FMI2_LAYER_H

#include "fmi2Functions.h"
#include "instance.h"

/* The FMI layer's part of an instance. */
typedef struct {
    Instance instance;
    fmi2CallbackFunctions callbacks;
    char *name;
    bool logging;
} Component2;

/* Log the instance's message and give back `status`. */
fmi2Status report2(Component2 *component, fmi2Status status, const char *function);

/* Every function may be called in some modes only. */
#define ENTER(modes) ENTER_AS(modes, __func__)
#define ENTER_AS(modes, function)                                                           \
    Component2 *component = pointer;                                                        \
    if (!component) return fmi2Error;                                                       \
    Instance *c = &component->instance;                                                     \
    if (!in_mode(c, modes)) return report2(component, fmi2Error, function)
#define GIVE(succeeded) return (succeeded) ? fmi2OK : report2(component, fmi2Error, __func__)

#endif
