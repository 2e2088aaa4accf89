/* SPDX-License-Identifier: MIT
 *
 * A long random walk in and out of contact, every coupling, PT2 from 0.05 Hz to 0.49 of the rate. At each
 * tick every double of the state is finite and none is denormal; each constant force comes out as it went in,
 * at the end as at the beginning; and the walk again is the same to the last bit. test_coupling_walk 10000000
 * so many ticks for each
 */
#include "check.h"
#include "coupling_table.h"

#include <stdlib.h>

static uint8_t memory[1024] __attribute__((aligned(16)));

static uint64_t seed;
static long contacts;
static double noise(void) /* -1 .. 1 */
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(int64_t)seed * (1.0 / 9223372036854775808.0);
}

static uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t size)
{
    const uint64_t *word = bytes; /* all doubles */
    for (size_t n = 0; n < size / sizeof *word; n++) hash = (hash ^ word[n]) * 1099511628211u;
    return hash;
}

static void check_state(const vxs_coupling *coupling)
{
    for (int n = 0; n < VXS_COUPLING_DOUBLES; n++)
        CHECK(coupling->state[n] == 0 ||
              (isfinite(coupling->state[n]) && fabs(coupling->state[n]) >= 2.3e-308));
    CHECK(coupling->depth == 0 || isnormal(coupling->depth));
}

/* A floor at y = 0 that also turns, and gives nothing above; the lever makes torques. */
static double touch(const vxs_pose *body, vxs_wrench *wrench)
{
    memset(wrench, 0, sizeof *wrench);
    double depth = -body->position[1];
    if (!(depth > 0)) return 0;
    contacts++;
    wrench->force[1] = 2000 * depth;
    wrench->force[0] = 1e-170 * depth; /* on its way to a denormal number */
    wrench->torque[0] = 0.01 * wrench->force[1] - 0.5 * body->orientation[1];
    wrench->torque[2] = -0.02 * wrench->force[1] - 0.5 * body->orientation[3];
    return depth;
}

static void tick(vxs_coupling *coupling, const vxs_pose *device, vxs_wrench *out)
{
    vxs_pose body;
    vxs_wrench contact;
    double depth;
    do {
        vxs_coupling_pose(coupling, device, &body);
        depth = touch(&body, &contact);
    } while (vxs_coupling_refine(coupling, &contact, depth, device));
    CHECK_INT(vxs_coupling_step(coupling, &contact, device, out), 0);
}

/* How far a constant force is from itself at the end of the filter, from wherever the state is. */
static double rest_error(vxs_coupling *coupling, const vxs_coupling_config *config)
{
    const vxs_wrench push = {{3, -2, 1}, {0.1, 0.2, -0.3}};
    const vxs_pose device = vxs_pose_identity();
    vxs_wrench out;
    double slowest = config->omega0 * fmin(config->damping, 0.5 / config->damping);
    long most = config->kind == VXS_COUPLING_PT2 ? (long)(40 / (slowest * config->sample_time)) + 1000 : 3000;
    for (long n = 0; n < most; n++) vxs_coupling_step(coupling, &push, &device, &out);
    double worst = 0;
    for (int axis = 0; axis < 3; axis++)
        worst = fmax(worst, fmax(fabs(out.force[axis] - push.force[axis]),
                                 fabs(out.torque[axis] - push.torque[axis])));
    return worst;
}

static uint64_t walk(const vxs_coupling_config *config, long ticks, double error[2])
{
    vxs_coupling *coupling;
    CHECK(vxs_coupling_memory() <= sizeof memory);
    CHECK_INT(vxs_coupling_init(memory, sizeof memory, config, &coupling), VXS_OK);
    uint64_t hash = 14695981039346656037u;
    seed = 1;
    error[0] = rest_error(coupling, config);
    vxs_pose device = vxs_pose_identity();
    long at_rest = 0;
    contacts = 0;
    for (long n = 0; n < ticks; n++) {
        /* Every 20 000 ticks it rests at the origin for 5 000: what dies away has time to. */
        if (n % 20000 == 15000) {
            device = vxs_pose_identity();
            at_rest = 5000;
        }
        if (at_rest > 0) {
            at_rest--;
        } else {
            for (int i = 0; i < 3; i++) device.position[i] = 0.999 * device.position[i] + 1e-4 * noise();
            for (int i = 1; i < 4; i++)
                device.orientation[i] = 0.999 * device.orientation[i] + 1e-3 * noise();
        }
        vxs_wrench out;
        tick(coupling, &device, &out);
        check_state(coupling);
        hash = hash_bytes(hash, &out, sizeof out);
    }
    CHECK(contacts > ticks / 5);
    error[1] = rest_error(coupling, config);
    return hash;
}

int main(int argc, char **argv)
{
    long ticks = argc > 1 ? atol(argv[1]) : check_length(100000, 40000);
    CHECK(ticks >= 40000);
    const double hertz[] = {0.05, 0.5, 5, 50, 200, 490};
    for (uint32_t kind = VXS_COUPLING_NONE; kind <= VXS_COUPLING_QUASI_STATIC; kind++) {
        for (int f = 0; f < (kind == VXS_COUPLING_PT2 ? 6 : 1); f++) {
            for (int d = 0; d < (kind == VXS_COUPLING_PT2 ? check_length(3, 1) : 1); d++) {
                vxs_coupling_config config;
                vxs_coupling_config_default(&config);
                config.kind = kind;
                config.omega0 = 2 * 3.14159265358979323846 * hertz[f];
                config.damping = d == 0 ? 1 : d == 1 ? 0.1 : 10;
                if (kind != VXS_COUPLING_PT2) config.damping = 0.7;
                double error[2], again[2];
                uint64_t hash = walk(&config, ticks, error);
                CHECK(hash == walk(&config, ticks, again));
                printf("%-13s %6g Hz, d %4g: a constant force %.1e N off before, %.1e N after %ld ticks; "
                       "%016llx\n",
                       vxs_coupling_kind_name(kind), kind == VXS_COUPLING_PT2 ? hertz[f] : 0, config.damping,
                       error[0], error[1], ticks, (unsigned long long)hash);
                CHECK(error[0] < 1e-9 && error[1] < 1e-9);
            }
        }
    }
    return 0;
}
