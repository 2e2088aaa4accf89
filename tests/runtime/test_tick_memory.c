/* SPDX-License-Identifier: MIT
 *
 * A million ticks, in contact and out of it, with every law and coupling: not one allocation, system call
 * (so no lock that waits) or page fault. malloc and its kin are wrapped by the linker and counted. The
 * ticks run in a child that the kernel ends at its first system call, but for those that count the faults.
 */
#define _GNU_SOURCE
#include "servo_bench.h"

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stddef.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

/* Sanitizers call the system as they please, and take their time. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { IS_SANITIZED = 1, TICKS = 100000 };
#else
enum { IS_SANITIZED = 0, TICKS = 1000000 };
#endif
enum { LAWS = 4, COUPLINGS = 4, BENCHES = LAWS * COUPLINGS };

static long calls;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void __real_free(void *memory);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void __wrap_free(void *memory);

void *__wrap_malloc(size_t size)
{
    calls++;
    return __real_malloc(size);
}
void *__wrap_calloc(size_t count, size_t size)
{
    calls++;
    return __real_calloc(count, size);
}
void *__wrap_realloc(void *memory, size_t size)
{
    calls++;
    return __real_realloc(memory, size);
}
void __wrap_free(void *memory)
{
    calls++;
    __real_free(memory);
}

/* What a child tells. */
typedef struct outcome {
    int is_confined; /* the kernel ends it at a system call */
    long ticks, contacts, calls, faults;
} outcome;

static long page_faults(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_minflt + usage.ru_majflt;
}

/* From now on any system call but getrusage and exit_group ends the process. Returns 0 where the kernel
 * cannot do that. */
static int confine(void)
{
    const struct rlimit no_core = {0, 0};
    struct sock_filter rules[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_getrusage, 1, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit_group, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
    };
    const struct sock_fprog program = {sizeof rules / sizeof *rules, rules};
    return setrlimit(RLIMIT_CORE, &no_core) == 0 && prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

/* PT2 bears them all. */
static void add_all_effects(servo_bench *b)
{
    static const vxs_effect_keyframe frames[] = {{0, {{0, 0, 0}, {1, 0, 0, 0}}, 0, 0},
                                                 {1, {{0, 1e-4, 0}, {1, 0.001, 0, 0}}, 0, 0}};
    for (uint32_t n = 0, kind; (kind = vxs_effect_kind_at(n)) != 0; n++) {
        vxs_effect *e = bench_effect(b, kind);
        if (kind == VXS_EFFECT_PROXIMITY) e->as.proximity.reach = 0.002;
        if (kind == VXS_EFFECT_FRICTION) e->as.friction.stiffness = 200, e->as.friction.damping = 0.1;
        if (kind == VXS_EFFECT_INERTIA) e->as.inertia.mass = 0.2;
        if (kind != VXS_EFFECT_MOTION) continue;
        e->keyframes = frames;
        e->keyframe_count = 2;
    }
}

static void open_all(servo_bench *benches)
{
    const built_floor floor_shape = {-1, 60, 20};
    for (int n = 0; n < BENCHES; n++) {
        servo_bench *b = &benches[n];
        bench_prepare(b);
        built_free(&b->map_bytes);
        b->map_bytes = build_floor_map(0.001, &floor_shape, BUILT_DISTANCES);
        b->map = open_voxmap(&b->map_bytes);
        b->servo_config.coupling.kind = VXS_COUPLING_NONE + (uint32_t)(n / LAWS);
        b->servo_config.contact.law = VXS_CONTACT_ORIGINAL + (uint32_t)(n % LAWS);
        if (b->servo_config.contact.law >= VXS_CONTACT_GRADIENT)
            b->servo_config.contact.field = VXS_CONTACT_DISTANCE;
        if (b->servo_config.contact.law == VXS_CONTACT_PATCH) b->servo_config.contact.most_stiffness = 1e4;
        if (n == LAWS + 1)
            add_all_effects(b);
        else
            for (uint32_t kind = VXS_EFFECT_START_INSIDE; kind <= VXS_EFFECT_SOFT_START; kind++)
                bench_effect(b, kind);
        bench_open(b);
        CHECK_INT(vxs_device_arm(b->device), VXS_OK);
    }
}

static void run(servo_bench *benches, int ticks, outcome *out)
{
    for (int n = 0; n < BENCHES; n++) {
        for (int k = 0; k < ticks; k++) {
            vxs_servo_trace row;
            bench_tick(&benches[n], 0.0105 - 0.0018 * (k % 1000 < 700), &row);
            out->contacts += row.points > 0;
            out->ticks++;
        }
    }
}

/* All ticks in a process of its own; a bad one also does everything that a tick must not. Returns how it
 * ended (wait). */
static int run_child(outcome *out, int ticks, int is_bad)
{
    fflush(NULL);
    pid_t pid = fork();
    CHECK(pid >= 0);
    if (pid == 0) {
        static servo_bench benches[BENCHES];
        open_all(benches);
        char *untouched = mmap(NULL, 1, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        CHECK(untouched != MAP_FAILED);
        outcome told = {.is_confined = !IS_SANITIZED && confine()};
        /* The program's own pages come when they are first needed: in the first round. */
        for (int round = 0; round < 2; round++) {
            told.ticks = told.contacts = 0;
            told.calls = -calls;
            told.faults = -page_faults();
            run(benches, round ? ticks : 2000, &told);
            if (is_bad && round) {
                void *volatile used = malloc(1);
                (void)used;
                *untouched = 1;
            }
            told.faults += page_faults();
            told.calls += calls;
        }
        *out = told;
        if (is_bad) syscall(SYS_getppid);
        syscall(SYS_exit_group, 0);
    }
    int status;
    CHECK(waitpid(pid, &status, 0) == pid);
    return status;
}

int main(void)
{
    outcome *out = mmap(NULL, sizeof *out, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    CHECK(out != MAP_FAILED);
    int status = run_child(out, 100, 1);
    CHECK(out->calls == 1 && out->faults >= 1);
    if (out->is_confined) CHECK(WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS);

    status = run_child(out, TICKS / BENCHES + 1, 0);
    printf("%ld ticks, %ld in contact: %ld allocations, %ld page faults, wait status %d\n", out->ticks,
           out->contacts, out->calls, out->faults, status);
    CHECK_INT(status, 0); /* not ended by a system call */
    CHECK(out->ticks >= TICKS && out->contacts > out->ticks / 10);
    CHECK_INT(out->calls, 0);
    if (IS_SANITIZED) return 0;
    CHECK_INT(out->faults, 0);
    if (!out->is_confined) SKIP("no seccomp here, system calls went unseen");
    return 0;
}
