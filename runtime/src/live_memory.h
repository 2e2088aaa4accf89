/* SPDX-License-Identifier: MIT
 *
 * live_memory.h - private: what live.h says of its file, in C.
 */
#ifndef VXSI_LIVE_MEMORY_H
#define VXSI_LIVE_MEMORY_H

#include "devices/mailbox.h"
#include "voxshell/live.h"

#include <stdalign.h>
#include <stddef.h>

typedef struct vxsi_live_memory {
    char magic[8];
    uint32_t row_size, process;
    alignas(64) vxsi_mailbox box;
} vxsi_live_memory;

_Static_assert(sizeof(vxs_servo_trace) <= 8 * VXSI_MAILBOX_WORDS, "a row fits");
_Static_assert(offsetof(vxsi_live_memory, box) == 64 && offsetof(vxsi_mailbox, words) == 8, "as live.h says");

#endif
