/* What the files of the FMI 3.0 layer share. */
#ifndef FMI3_LAYER_H
#define FMI3_LAYER_H

#include "fmi3Functions.h"
#include "instance.h"

/* The FMI layer's part of an instance. */
typedef struct {
    Instance instance;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Component3;

/* Log the instance's message and give back `status`. */
fmi3Status report3(Component3 *component, fmi3Status status, const char *function);

/* Every function may be called in some modes only. */
#define ENTER(modes)                                                                        \
    Component3 *component = pointer;                                                        \
    if (!component) return fmi3Error;                                                       \
    Instance *c = &component->instance;                                                     \
    if (!in_mode(c, modes)) return report3(component, fmi3Error, __func__)
#define GIVE(succeeded) return (succeeded) ? fmi3OK : report3(component, fmi3Error, __func__)

/* A function of a part of the standard that no FMU of ours offers: there is nothing to call it for. */
#define REFUSE(...)                                                                         \
    do {                                                                                    \
        ENTER(ANY_MODE);                                                                    \
        GIVE(fail(c, __VA_ARGS__));                                                         \
    } while (0)

#endif
