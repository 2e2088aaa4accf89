/* SPDX-License-Identifier: MIT
 *
 * Many exchanges with each emulated device while everything goes wrong at random:
 *     test_exchanges [EXCHANGES [SEED]]
 * Held to: no crash, no hang, no leak (sanitizers); never a number at a motor that is not finite or above the
 * peak; no force later than 10 ms after the device stopped being ARMED; ARMED only ever after
 * vxs_device_arm().
 */
#include "check.h"
#include "emulated.h"

static uint64_t state = 88172645463325252u;
static uint32_t random_below(uint32_t end)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)((state >> 32) * end >> 32);
}

static void cause_trouble(emulated *e)
{
    static const uint32_t shares[] = {0, 0, 0, 30, 300, 3000, 20000};
    emulated_trouble *t = &e->trouble;
    uint32_t *parts[] = {&t->lost,  &t->doubled, &t->damaged,    &t->delayed,
                         &t->split, &t->random,  &t->not_finite, &t->jump};
    memset(t, 0, sizeof *t);
    if (random_below(3) == 0) return;
    for (size_t n = 0; n < sizeof parts / sizeof *parts; n++)
        if (random_below(4) == 0)
            *parts[n] = shares[random_below(sizeof shares / sizeof *shares)] / (n >= 6 ? 64 : 1);
}

static void run(const emulated_kind *kind, unsigned long exchanges)
{
    static emulated e;
    static vxsi_link link;
    uint64_t faults = 0, unplugged = 0, armings = 0, armed_ticks = 0;
    for (unsigned long n = 0; n < exchanges;) {
        memset(&link, 0, sizeof link);
        emulated_init(&e, kind);
        e.random += random_below(1u << 30);
        int opened = emulated_link(&e, &link) == VXS_OK;
        CHECK(opened);
        vxs_device_command command;
        vxs_device_state seen;
        vxs_device_report report;
        int expects_armed = 0, quiet = 0;
        uint32_t life = 500 + random_below(8000), is_gone = 0;
        for (uint32_t tick = 0; tick < life && n < exchanges; tick++, n++) {
            if (random_below(500) == 0) cause_trouble(&e);
            if (random_below(20000) == 0) e.trouble.unplug_at = e.calls + 1 + random_below(10);
            if (random_below(3000) == 0) e.is_silent = random_below(2);
            if (random_below(30000) == 0) e.now_ns -= random_below(20) * 1000000;
            if (random_below(2000) == 0) e.is_homed = random_below(4) > 0;
            if (kind == &emulated_hvlink && random_below(5000) == 0)
                vxs_hvlink_device_fail(&e.hvlink, (uint8_t)random_below(12));
            for (int i = 0; i < 3; i++)
                e.hand[i] = e.hand[i] * 0.999 + ((double)random_below(2001) - 1000) * 2e-8;
            for (int i = 0; i < 6; i++) e.axes.axis[i] = (int16_t)(random_below(1000) - 500);
            emulated_run(&e, &link);
            double force = emulated_force(&e);
            CHECK(isfinite(force) && force < 25);
            memset(&command, 0, sizeof command);
            for (int i = 0; i < 6; i++)
                (i < 3 ? command.wrench.force : command.wrench.torque)[i % 3] =
                    ((double)random_below(2001) - 1000) * 5e-3;
            command.hold_ns = e.now_ns + 2000000;
            command.expires_ns = e.now_ns + 12000000;
            if (random_below(4000) == 0)
                command.wrench.force[random_below(3)] = random_below(2) ? NAN : INFINITY;
            vxs_device_exchange(&link.device, random_below(10) ? &command : NULL, &seen, &report);
            CHECK(isfinite(seen.pose.position[0] + seen.pose.position[1] + seen.pose.position[2]));
            CHECK(isfinite(report.rendered.force[0] + report.rendered.force[1] + report.rendered.force[2]));
            if (seen.state == VXS_DEVICE_ARMED) CHECK(expects_armed);
            armed_ticks += seen.state == VXS_DEVICE_ARMED;
            if (seen.state != VXS_DEVICE_ARMED) {
                faults += expects_armed && seen.state == VXS_DEVICE_FAULT;
                expects_armed = 0;
                for (int i = 0; i < 3; i++) CHECK(report.rendered.force[i] == 0);
                /* What was on its way, and what the wire lost, is over after 10 ms; of a device that is cut
                 * off nothing can be known, and a wire that loses a third of all packets has it longer. */
                quiet = seen.state != VXS_DEVICE_GONE && e.trouble.lost < 10000 ? quiet + 1 : 0;
                if (quiet > 10 && e.trouble.lost == 0) CHECK(force == 0);
                if (seen.state == VXS_DEVICE_FAULT && random_below(30) == 0) vxs_device_disarm(&link.device);
                if (seen.state == VXS_DEVICE_READY && random_below(30) == 0 &&
                    vxs_device_arm(&link.device) == VXS_OK) {
                    expects_armed = 1;
                    quiet = 0;
                    armings++;
                }
            } else {
                quiet = 0;
                if (random_below(5000) == 0 && vxs_device_disarm(&link.device) == VXS_OK) expects_armed = 0;
            }
            is_gone = seen.state == VXS_DEVICE_GONE;
            if (is_gone && random_below(20) == 0) break;
        }
        unplugged += is_gone;
        vxs_device_close(&link.device);
        CHECK(e.is_closed);
    }
    printf("%s: %lu exchanges, %llu ARMED, %llu armings, %llu faults while armed, %llu unplugged\n",
           kind->name, exchanges, (unsigned long long)armed_ticks, (unsigned long long)armings,
           (unsigned long long)faults, (unsigned long long)unplugged);
    if (exchanges >= 20000 && kind->has_force) CHECK(faults > 0 && unplugged > 0 && armings > 10);
}

int main(int count, char **arguments)
{
    unsigned long exchanges = count > 1 ? strtoul(arguments[1], NULL, 10) : 100000;
    state ^= count > 2 ? strtoul(arguments[2], NULL, 10) : 0;
    for (int k = 0; k < 4; k++) run(emulated_kinds[k], exchanges);
    return 0;
}
