/* FMI 2.0: the FMU state. */
#include "fmi2_layer.h"

#include <stdlib.h>

fmi2Status fmi2GetFMUstate(fmi2Component pointer, fmi2FMUstate *state) {
    ENTER(ANY_MODE);
    GIVE(keep_state(c, state));
}

fmi2Status fmi2SetFMUstate(fmi2Component pointer, fmi2FMUstate state) {
    ENTER(ANY_MODE);
    GIVE(restore_state(c, state));
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
    *size = state_size();
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component pointer, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    ENTER(ANY_MODE);
    GIVE(write_state(c, state, bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component pointer, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    ENTER(ANY_MODE);
    GIVE(read_state(c, bytes, size, state));
}
