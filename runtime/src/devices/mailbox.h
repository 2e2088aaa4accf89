/* SPDX-License-Identifier: MIT
 *
 * mailbox.h - private: the newest of something, from one thread to another; neither ever waits.
 *
 * A sequence lock whose words are atomic: odd while they are written. Each word is stored with release and
 * loaded with acquire, so that no fence is needed: whoever sees a new word sees the odd number, too.
 */
#ifndef VXSI_MAILBOX_H
#define VXSI_MAILBOX_H

#include <stdatomic.h>
#include <stdint.h>
#include <string.h>

enum { VXSI_MAILBOX_WORDS = 64, VXSI_MAILBOX_TRIES = 8 };

typedef struct vxsi_mailbox {
    atomic_uint_least64_t sequence; /* 0: empty */
    atomic_uint_least64_t words[VXSI_MAILBOX_WORDS];
} vxsi_mailbox;

/* One writer. size: at most 8 VXSI_MAILBOX_WORDS. */
static inline void vxsi_mailbox_put(vxsi_mailbox *box, const void *what, size_t size)
{
    uint64_t words[VXSI_MAILBOX_WORDS] = {0};
    memcpy(words, what, size);
    uint64_t sequence = atomic_load_explicit(&box->sequence, memory_order_relaxed);
    atomic_store_explicit(&box->sequence, sequence + 1, memory_order_relaxed);
    for (size_t n = 0; n < (size + 7) / 8; n++)
        atomic_store_explicit(&box->words[n], words[n], memory_order_release);
    atomic_store_explicit(&box->sequence, sequence + 2, memory_order_release);
}

/* One reader. Returns which one it is (2, 4, ...); 0, what untouched: empty, or the writer was at it each
 * time. */
static inline uint64_t vxsi_mailbox_get(vxsi_mailbox *box, void *what, size_t size)
{
    for (int n = 0; n < VXSI_MAILBOX_TRIES; n++) {
        uint64_t words[VXSI_MAILBOX_WORDS];
        uint64_t before = atomic_load_explicit(&box->sequence, memory_order_acquire);
        if (before == 0) return 0;
        for (size_t i = 0; i < (size + 7) / 8; i++)
            words[i] = atomic_load_explicit(&box->words[i], memory_order_acquire);
        if (before % 2 == 0 && atomic_load_explicit(&box->sequence, memory_order_relaxed) == before) {
            memcpy(what, words, size);
            return before;
        }
    }
    return 0;
}

#endif
