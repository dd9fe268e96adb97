/* FMI 3.0: the FMU state. */
#include "fmi3_layer.h"

#include <stdlib.h>

fmi3Status fmi3GetFMUState(fmi3Instance pointer, fmi3FMUState *state) {
    ENTER(ANY_MODE);
    GIVE(keep_state(c, state));
}

fmi3Status fmi3SetFMUState(fmi3Instance pointer, fmi3FMUState state) {
    ENTER(ANY_MODE);
    GIVE(restore_state(c, state));
}

fmi3Status fmi3FreeFMUState(fmi3Instance pointer, fmi3FMUState *state) {
    ENTER(ANY_MODE);
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance pointer, fmi3FMUState state, size_t *size) {
    (void)state;
    ENTER(ANY_MODE);
    *size = state_size();
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance pointer, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    ENTER(ANY_MODE);
    GIVE(write_state(c, state, bytes, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance pointer, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    ENTER(ANY_MODE);
    GIVE(read_state(c, bytes, size, state));
}
