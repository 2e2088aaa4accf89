/* SPDX-License-Identifier: MIT
 *
 * A minute at 1 kHz on the simulated Phantom, every coupling and law: no number that is not
 * finite, no missed state, and the same trace to the last bit when run again.
 */
#include "servo_bench.h"

static uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t size)
{
    const uint8_t *byte = bytes;
    for (size_t n = 0; n < size; n++) hash = (hash ^ byte[n]) * 1099511628211u; /* FNV-1a */
    return hash;
}

/* Down onto the floor, sliding, up again: smooth and free of libm, so that it is the same everywhere. */
static double height_at(int tick)
{
    int phase = tick % 4000;
    double way = phase < 2000 ? phase / 2000.0 : (4000 - phase) / 2000.0;
    return 0.012 - 0.0035 * way * way * (3 - 2 * way);
}

static uint64_t run(uint32_t coupling, uint32_t law, int ticks)
{
    servo_bench b;
    bench_prepare(&b);
    b.servo_config.coupling.kind = coupling;
    b.servo_config.contact.law = law;
    bench_open(&b);
    CHECK_INT(vxs_device_arm(b.device), VXS_OK);
    uint64_t hash = 14695981039346656037u;
    long in_contact = 0;
    for (int k = 0; k < ticks; k++) {
        vxs_servo_trace row;
        uint32_t flags = bench_tick(&b, height_at(k), &row);
        CHECK(
            !(flags & (VXS_SERVO_FAULT | VXS_SERVO_MISSED | VXS_SERVO_DEVICE_STALE | VXS_SERVO_DEVICE_LOST)));
        double sum = 0;
        for (int axis = 0; axis < 3; axis++)
            sum += row.pose.position[axis] + row.collision.force[axis] + row.output.force[axis] +
                   row.command.torque[axis];
        CHECK(isfinite(sum));
        CHECK(row.pose.position[1] > 0 && row.pose.position[1] < 0.05);
        in_contact += row.points > 0;
        hash = hash_bytes(hash, &row, sizeof row);
    }
    CHECK(in_contact > ticks / 10);
    bench_close(&b);
    return hash;
}

int main(void)
{
    const int minute = (int)check_length(60000, 4000), few = (int)check_length(6000, 2000);
    uint64_t first = run(VXS_COUPLING_PT2, VXS_CONTACT_AVERAGE, minute);
    CHECK(first == run(VXS_COUPLING_PT2, VXS_CONTACT_AVERAGE, minute));
    printf("trace %016llx\n", (unsigned long long)first);
    for (uint32_t kind = VXS_COUPLING_NONE; kind <= VXS_COUPLING_QUASI_STATIC; kind++) {
        for (uint32_t law = VXS_CONTACT_ORIGINAL; law <= VXS_CONTACT_AVERAGE; law++)
            CHECK(run(kind, law, few) == run(kind, law, few));
    }
    return 0;
}
