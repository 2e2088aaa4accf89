/* SPDX-License-Identifier: MIT
 *
 * A mapped file that is shortened under its reader. The handler puts zeros in the place of what is gone, from
 * the lost page to the mapping's end, so that the instruction that faulted goes on. No jump out of a tick: a
 * kernel may be in the middle of a sum, and zeros lead nowhere outside the file (an entry 0 is free cells).
 */
#define _DEFAULT_SOURCE 1 /* MAP_ANONYMOUS, siginfo_t */

#include "asset_check.h"

#include <errno.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/mman.h>
#include <unistd.h>

enum { MOST = 1024 };

/* A signal's handler has no argument of ours: the runtime's only variables. */
static struct {
    atomic_uintptr_t first, end; /* first: 0 where the row is free */
    atomic_uint is_lost;
} guarded[MOST];
static atomic_uint lost;
static atomic_flag is_changing = ATOMIC_FLAG_INIT;
static atomic_int is_installed;
static struct sigaction before;
static uintptr_t page_size;

static int replace(uintptr_t at)
{
    for (int n = 0; n < MOST; n++) {
        uintptr_t first = atomic_load(&guarded[n].first), end = atomic_load(&guarded[n].end);
        if (first == 0 || at < first || at >= end) continue;
        uintptr_t page = at / page_size * page_size;
        if (mmap((void *)page, end - page, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) ==
            MAP_FAILED)
            return 0;
        if (!atomic_exchange(&guarded[n].is_lost, 1)) atomic_fetch_add(&lost, 1);
        return 1;
    }
    return 0;
}

static void handle(int number, siginfo_t *info, void *context)
{
    int error = errno, is_sent = info->si_code <= 0; /* by kill() */
    int is_replaced = !is_sent && replace((uintptr_t)info->si_addr);
    errno = error;
    if (is_replaced) return;
    if (before.sa_flags & SA_SIGINFO)
        before.sa_sigaction(number, info, context);
    else if (before.sa_handler != SIG_DFL && before.sa_handler != SIG_IGN)
        before.sa_handler(number);
    else if (!is_sent || before.sa_handler == SIG_DFL) {
        (void)sigaction(number, &before, NULL);
        (void)raise(number); /* when this returns: as without a guard */
    }
}

static vxs_result install(void)
{
    if (atomic_load(&is_installed)) return VXS_OK;
    struct sigaction action = {.sa_sigaction = handle, .sa_flags = SA_SIGINFO | SA_ONSTACK};
    (void)sigemptyset(&action.sa_mask);
    page_size = (uintptr_t)sysconf(_SC_PAGESIZE);
    if (sigaction(SIGBUS, &action, &before) != 0) return VXS_UNSUPPORTED;
    atomic_store(&is_installed, 1);
    return VXS_OK;
}

static int row_of(uintptr_t first)
{
    int n = 0;
    while (n < MOST && atomic_load(&guarded[n].first) != first) n++;
    return n;
}

vxs_result vxs_asset_guard(const vxs_asset *asset)
{
    if (!asset || !asset->data) return VXS_PARAM;
    uintptr_t first = (uintptr_t)asset->data;
    if (asset->mapped_size == 0 || row_of(first) < MOST) return VXS_OK;
    while (atomic_flag_test_and_set(&is_changing)) {
    }
    vxs_result result = install();
    int n = row_of(0);
    if (result == VXS_OK && n == MOST) result = VXS_LIMIT;
    if (result == VXS_OK) {
        atomic_store(&guarded[n].is_lost, 0);
        atomic_store(&guarded[n].end,
                     (first + (uintptr_t)asset->mapped_size + page_size - 1) / page_size * page_size);
        atomic_store(&guarded[n].first, first);
    }
    atomic_flag_clear(&is_changing);
    return result;
}

void vxsi_asset_unguard(const vxs_asset *asset)
{
    int n = atomic_load(&is_installed) && asset->data ? row_of((uintptr_t)asset->data) : MOST;
    if (n == MOST) return;
    if (atomic_exchange(&guarded[n].is_lost, 0)) atomic_fetch_sub(&lost, 1);
    atomic_store(&guarded[n].first, 0);
}

uint32_t vxs_asset_lost(void)
{
    return atomic_load_explicit(&lost, memory_order_relaxed);
}
