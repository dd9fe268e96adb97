/* FMI 2.0: the FMU state, a copy of the instance's memory; serialised behind the GUID, so that no other model's fits. */
#include "fmi2_layer.h"

#include <stdlib.h>
#include <string.h>

#define GUID_SIZE 40

fmi2Status fmi2GetFMUstate(fmi2Component pointer, fmi2FMUstate *state) {
    ENTER(ANY_MODE);
    if (!*state) *state = malloc(sizeof(Memory));
    if (!*state) {
        fail(c, "no memory for an FMU state");
        return report(component, fmi2Error, __func__);
    }
    memcpy(*state, &c->memory, sizeof(Memory));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component pointer, fmi2FMUstate state) {
    ENTER(ANY_MODE);
    if (!state) {
        fail(c, "there is no FMU state to set");
        return report(component, fmi2Error, __func__);
    }
    memcpy(&c->memory, state, sizeof(Memory));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component pointer, fmi2FMUstate *state) {
    ENTER(ANY_MODE);
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component pointer, fmi2FMUstate state, size_t *size) {
    (void)state;
    ENTER(ANY_MODE);
    *size = GUID_SIZE + sizeof(Memory);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component pointer, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    ENTER(ANY_MODE);
    if (!state || size < GUID_SIZE + sizeof(Memory)) {
        fail(c, "a serialised FMU state takes %zu bytes, not %zu", GUID_SIZE + sizeof(Memory), size);
        return report(component, fmi2Error, __func__);
    }
    memset(bytes, 0, GUID_SIZE);
    memcpy(bytes, MODEL_GUID, strlen(MODEL_GUID));
    memcpy(bytes + GUID_SIZE, state, sizeof(Memory));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component pointer, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    ENTER(ANY_MODE);
    if (size != GUID_SIZE + sizeof(Memory) || memcmp(bytes, MODEL_GUID, strlen(MODEL_GUID))) {
        fail(c, "these %zu bytes are no FMU state of %s", size, MODEL_NAME);
        return report(component, fmi2Error, __func__);
    }
    if (!*state) *state = malloc(sizeof(Memory));
    if (!*state) {
        fail(c, "no memory for an FMU state");
        return report(component, fmi2Error, __func__);
    }
    memcpy(*state, bytes + GUID_SIZE, sizeof(Memory));
    return fmi2OK;
}
