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
} Component;

/* Log the instance's message and give back `status`. */
fmi2Status report(Component *component, fmi2Status status, const char *function);

/* Every function may be called in some modes only. */
fmi2Status check_mode(Component *component, int modes, const char *function);

#define ENTER(modes) ENTER_AS(modes, __func__)
#define ENTER_AS(modes, function)                                                           \
    Component *component = pointer;                                                         \
    if (!component) return fmi2Error;                                                       \
    Instance *c = &component->instance;                                                     \
    (void)c;                                                                                \
    if (!(c->memory.mode & (modes))) return check_mode(component, modes, function)
#define GIVE(succeeded) return (succeeded) ? fmi2OK : report(component, fmi2Error, __func__)

#define RUNNING (EVENT | CONTINUOUS | STEP)
#define ANY_MODE (INSTANTIATED | INITIALIZATION | RUNNING | TERMINATED)

#endif
