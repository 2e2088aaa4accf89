/* SPDX-License-Identifier: MIT
 *
 * What must not hurt anybody, with a servo above the device, each a named case: test_safety_loop CASE.
 *     unguarded_servo    motors and a servo without start-inside or soft-start: refused with its cause
 *     asset_swapped      the files of map and shell are replaced while the loop runs on them
 *     asset_cut          they are shortened under it
 */
#define _GNU_SOURCE 1 /* truncate */

#include "check.h"
#include "floor_scene.h"
#include "voxshell/servo_thread.h"

#include <sys/stat.h>
#include <unistd.h>

static const char *const map_file = "loop.voxmap", *const shell_file = "loop.pointshell";

static void unguarded_servo(void)
{
    static emulated e;
    static vxsi_link link;
    floor_scene l;
    floor_scene_build(&l);
    emulated_init(&e, &emulated_hvlink);
    CHECK_INT(emulated_link(&e, &link), VXS_OK);
    CHECK(link.device.caps.has_motors && !e.tip->caps.has_motors);
    vxs_effect effects[3];
    const uint32_t kinds[3] = {VXS_EFFECT_START_INSIDE, VXS_EFFECT_SOFT_START, VXS_EFFECT_TORQUE};
    for (uint32_t have = 0; have < 8; have++) {
        uint32_t count = 0;
        for (uint32_t n = 0; n < 3; n++)
            if (have >> n & 1) vxs_effect_default(kinds[n], &effects[count++]);
        l.config.effects = effects;
        l.config.effect_count = count;
        floor_scene_start(&l);
        int is_guarded = (have & 3) == 3;
        CHECK_INT(vxs_servo_may_drive(l.servo, &link.device.caps), is_guarded ? VXS_OK : VXS_UNGUARDED);
        CHECK_INT(vxs_servo_may_drive(l.servo, &e.tip->caps), VXS_OK);
        vxs_servo_thread_config config;
        vxs_servo_thread *thread = NULL;
        vxs_servo_thread_config_default(&config);
        config.device = &link.device;
        config.servo = l.servo;
        void *memory = aligned_alloc(64, (vxs_servo_thread_memory() + 63) / 64 * 64);
        vxs_result result = is_guarded
                                ? VXS_UNGUARDED
                                : vxs_servo_thread_start(memory, vxs_servo_thread_memory(), &config, &thread);
        CHECK_INT(result, VXS_UNGUARDED);
        CHECK(!thread && strstr(vxs_result_text(result), "start-inside and soft-start"));
        free(memory);
    }
    CHECK_INT(vxs_servo_may_drive(NULL, &link.device.caps), VXS_PARAM);
    vxs_device_close(&link.device);
    floor_scene_close(&l);
}

/* A loop of a device, its link and a servo, that rests on the floor from tick 1000 on. */
typedef struct rest {
    emulated e;
    vxsi_link link;
    floor_scene scene;
    vxs_device_command command;
    vxs_device_state state;
    uint32_t flags;
    int tick;
} rest;

static void begin_rest(rest *r, uint32_t mode)
{
    memset(r, 0, sizeof *r);
    floor_scene_write(map_file, shell_file, 0);
    floor_scene_open(&r->scene, map_file, shell_file, mode);
    floor_scene_start(&r->scene);
    emulated_init(&r->e, &emulated_hvlink);
    CHECK_INT(emulated_link(&r->e, &r->link), VXS_OK);
    for (int tick = 0; tick < 20; tick++) emulated_run(&r->e, &r->link);
    CHECK_INT(vxs_device_arm(&r->link.device), VXS_OK);
}

/* As servo.h has it for who owns the loop: a guarded asset that has lost bytes is asked for after each tick. */
static void tick_rest(rest *r)
{
    int tick = r->tick++;
    r->e.hand[1] = tick < 600 ? 0 : tick < 1000 ? -0.010 * (tick - 600) / 400 : -0.010;
    emulated_run(&r->e, &r->link);
    vxs_device_exchange(&r->link.device, &r->command, &r->state, NULL);
    r->flags = vxs_servo_tick(r->scene.servo, &r->state, &r->command, NULL);
    if (!vxs_asset_lost()) return;
    r->flags |= VXS_SERVO_FAULT;
    memset(&r->command.wrench, 0, sizeof r->command.wrench);
}

static void end_rest(rest *r)
{
    vxs_device_close(&r->link.device);
    floor_scene_close(&r->scene);
}

/* What happens to the files while the loop runs. */
typedef enum swap { SWAP_NOTHING, SWAP_RENAMED, SWAP_REMOVED, SWAP_CUT, SWAPS } swap;

static void do_swap(swap what)
{
    if (what == SWAP_RENAMED) { /* another floor, 3 mm higher, as the tools would write it */
        floor_scene_write("other.voxmap", "other.pointshell", 3);
        CHECK(rename("other.voxmap", map_file) == 0 && rename("other.pointshell", shell_file) == 0);
    } else if (what == SWAP_REMOVED) {
        CHECK(unlink(map_file) == 0 && unlink(shell_file) == 0);
    } else if (what == SWAP_CUT) {
        CHECK(truncate(map_file, 0) == 0 && truncate(shell_file, 100) == 0);
    }
}

/* The forces of all ticks, with the files swapped while the hand rests on the floor. */
static void run_over_swap(swap what, uint32_t mode, double forces[2000])
{
    static rest r;
    begin_rest(&r, mode);
    while (r.tick < 2000) {
        if (r.tick == 1400) do_swap(what);
        tick_rest(&r);
        forces[r.tick - 1] = r.e.force[1];
    }
    CHECK_INT(r.state.state, VXS_DEVICE_ARMED);
    end_rest(&r);
}

/* A loop goes on with what it opened, to the last bit: a file that is replaced or removed stays where it is
 * mapped, and one that is copied may be shortened, too. The next opening sees the new one. */
static void asset_swapped(void)
{
    static double before[2000], after[2000];
    run_over_swap(SWAP_NOTHING, VXS_ASSET_MAP, before);
    CHECK(before[1999] > 0.5);
    for (swap what = SWAP_RENAMED; what < SWAPS; what++) {
        run_over_swap(what, what == SWAP_CUT ? VXS_ASSET_COPY : VXS_ASSET_MAP, after);
        CHECK(memcmp(before, after, sizeof before) == 0);
        vxs_asset file;
        vxs_result now = vxs_asset_open(map_file, NULL, &file, NULL);
        CHECK_INT(now, what == SWAP_RENAMED ? VXS_OK : what == SWAP_REMOVED ? VXS_IO : VXS_TRUNCATED);
        vxs_asset_close(&file);
    }
    run_over_swap(SWAP_RENAMED, VXS_ASSET_COPY, after);
    CHECK(memcmp(before, after, sizeof before) == 0);
}

/* Guarded: the tick that meets what is gone commands zero and is a FAULT, the motors are at zero with the next
 * packet, and neither arming anew nor a file that is whole again makes force, until it is opened anew. */
static void cut(const char *file, off_t left)
{
    static rest r;
    begin_rest(&r, VXS_ASSET_MAP);
    CHECK_INT(vxs_asset_guard(&r.scene.map_file), VXS_OK);
    CHECK_INT(vxs_asset_guard(&r.scene.shell_file), VXS_OK);
    while (r.tick < 1400) tick_rest(&r);
    CHECK(r.e.force[1] > 0.5 && !(r.flags & VXS_SERVO_FAULT));
    CHECK(truncate(file, left) == 0);
    int until = 0; /* the loop meets what is gone */
    while (!(r.flags & VXS_SERVO_FAULT)) {
        CHECK(until++ < 2);
        tick_rest(&r);
    }
    CHECK_INT(vxs_asset_lost(), 1); /* the cause */
    for (int n = 0; n < 2000; n++) {
        if (n == 500) {
            CHECK_INT(vxs_device_disarm(&r.link.device), VXS_OK);
            tick_rest(&r);
            CHECK_INT(vxs_device_arm(&r.link.device), VXS_OK);
        }
        if (n == 1000) {
            vxs_servo_clear(r.scene.servo);
            floor_scene_write(map_file, shell_file, 0);
        }
        for (int i = 0; i < 3; i++) CHECK(r.command.wrench.force[i] == 0 && r.command.wrench.torque[i] == 0);
        tick_rest(&r);
        CHECK(r.flags & VXS_SERVO_FAULT);
        CHECK(n == 0 || emulated_force(&r.e) == 0); /* the first exchange hands the zero to the wire */
    }
    end_rest(&r);
    CHECK_INT(vxs_asset_lost(), 0);
    begin_rest(&r, VXS_ASSET_MAP);
    while (r.tick < 1400) tick_rest(&r);
    CHECK(r.e.force[1] > 0.5);
    end_rest(&r);
}

static void asset_cut(void)
{
    cut(map_file, 0);
    cut(map_file, 4096);
    cut(shell_file, 0);
}

int main(int count, char **arguments)
{
    char folder[] = "safety_loop_XXXXXX";
    const char *only = count > 1 ? arguments[1] : "";
    CHECK(mkdtemp(folder) && chdir(folder) == 0);
    if (!*only || strcmp(only, "unguarded_servo") == 0) unguarded_servo();
    if (!*only || strcmp(only, "asset_swapped") == 0) asset_swapped();
    if (!*only || strcmp(only, "asset_cut") == 0) asset_cut();
    unlink(map_file);
    unlink(shell_file);
    CHECK(chdir("..") == 0 && rmdir(folder) == 0);
    return 0;
}
