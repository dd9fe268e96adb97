/* The FMU state: a copy of the instance's memory; serialised behind the GUID, so that no other model's fits. */
#include "instance.h"

#include <stdlib.h>
#include <string.h>

#define GUID_SIZE 40

size_t state_size(void) { return GUID_SIZE + sizeof(Memory); }

static bool copy(Instance *c, void **state, const void *memory) {
    if (!*state) *state = malloc(sizeof(Memory));
    if (!*state) return fail(c, "no memory for an FMU state");
    memcpy(*state, memory, sizeof(Memory));
    return true;
}

bool keep_state(Instance *c, void **state) { return copy(c, state, &c->memory); }

bool restore_state(Instance *c, const void *state) {
    if (!state) return fail(c, "there is no FMU state to set");
    memmove(&c->memory, state, sizeof(Memory));  /* not memcpy, for which compilers write a slow string instruction */
    return true;
}

bool write_state(Instance *c, const void *state, void *bytes, size_t size) {
    if (!state || size < state_size())
        return fail(c, "a serialised FMU state takes %zu bytes, not %zu", state_size(), size);
    memset(bytes, 0, GUID_SIZE);
    memcpy(bytes, MODEL_GUID, strlen(MODEL_GUID));
    memcpy((char *)bytes + GUID_SIZE, state, sizeof(Memory));
    return true;
}

bool read_state(Instance *c, const void *bytes, size_t size, void **state) {
    if (size != state_size() || memcmp(bytes, MODEL_GUID, strlen(MODEL_GUID)))
        return fail(c, "these %zu bytes are no FMU state of %s", size, MODEL_NAME);
    return copy(c, state, (const char *)bytes + GUID_SIZE);
}
