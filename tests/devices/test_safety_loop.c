/* SPDX-License-Identifier: MIT
 *
 * What must not hurt anybody, with a servo above the device, each a named case: test_safety_loop CASE.
 *     unguarded_servo    motors and a servo without start-inside or soft-start: refused with its cause
 *     asset_swapped      the files of map and shell are replaced while the loop runs on them
 */
#define _GNU_SOURCE 1 /* truncate */

#include "asset_builder.h"
#include "check.h"
#include "emulated.h"
#include "voxshell/servo_thread.h"

#include <sys/stat.h>
#include <unistd.h>

typedef struct loop {
    vxs_asset map_file, shell_file;
    vxs_voxmap map;
    vxs_pointshell shell;
    vxs_contact_static statics;
    vxs_servo_config config;
    void *memory;
    vxs_servo *servo;
} loop;

static void write_file(const char *path, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    CHECK(file && fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
}

/* The floor's height is h cells. */
static void write_assets(const char *map, const char *shell, int h)
{
    built_floor shape = {-1 + h, 60, 20};
    built_asset map_bytes = build_floor_map(0.001, &shape, BUILT_PLAIN);
    built_asset shell_bytes = build_ball_shell(0.001, 0.01, 1000);
    write_file(map, map_bytes.data, map_bytes.size);
    write_file(shell, shell_bytes.data, shell_bytes.size);
    built_free(&map_bytes);
    built_free(&shell_bytes);
}

static void open_loop(loop *l, uint32_t mode)
{
    vxs_asset_config how;
    memset(l, 0, sizeof *l);
    vxs_asset_config_default(&how);
    how.mode = mode;
    CHECK_INT(vxs_asset_open("loop.voxmap", &how, &l->map_file, NULL), VXS_OK);
    CHECK_INT(vxs_asset_open("loop.pointshell", &how, &l->shell_file, NULL), VXS_OK);
    CHECK_INT(vxs_voxmap_open(&l->map_file, &l->map), VXS_OK);
    CHECK_INT(vxs_pointshell_open(&l->shell_file, &l->shell), VXS_OK);
    l->statics = (vxs_contact_static){&l->map, NULL};
    vxs_servo_config_default(&l->config);
    l->config.statics = &l->statics;
    l->config.static_count = 1;
    l->config.shell = &l->shell;
    l->config.max_force = 4;
    l->config.contact.weighting = VXS_CONTACT_AREA;
    l->config.contact.stiffness = 1e9;
    l->config.coupling.kind = VXS_COUPLING_QUASI_STATIC;
    l->config.coupling.stiffness = 800;
    l->config.mount.position[1] = 0.014;
}

static void make_servo(loop *l)
{
    size_t size = (vxs_servo_memory(&l->config) + 63) / 64 * 64;
    l->memory = aligned_alloc(64, size);
    CHECK_INT(vxs_servo_init(l->memory, size, &l->config, &l->servo), VXS_OK);
}

static void close_loop(loop *l)
{
    free(l->memory);
    vxs_asset_close(&l->map_file);
    vxs_asset_close(&l->shell_file);
}

static void unguarded_servo(void)
{
    static emulated e;
    static vxsi_link link;
    loop l;
    write_assets("loop.voxmap", "loop.pointshell", 0);
    open_loop(&l, VXS_ASSET_MAP);
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
        make_servo(&l);
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
        free(l.memory);
    }
    CHECK_INT(vxs_servo_may_drive(NULL, &link.device.caps), VXS_PARAM);
    l.memory = NULL;
    vxs_device_close(&link.device);
    close_loop(&l);
}

/* What happens to the files while the loop runs. */
typedef enum swap { SWAP_NOTHING, SWAP_RENAMED, SWAP_REMOVED, SWAP_CUT, SWAPS } swap;

static void do_swap(swap what)
{
    if (what == SWAP_RENAMED) { /* another floor, 3 mm higher, as the tools would write it */
        write_assets("other.voxmap", "other.pointshell", 3);
        CHECK(rename("other.voxmap", "loop.voxmap") == 0 &&
              rename("other.pointshell", "loop.pointshell") == 0);
    } else if (what == SWAP_REMOVED) {
        CHECK(unlink("loop.voxmap") == 0 && unlink("loop.pointshell") == 0);
    } else if (what == SWAP_CUT) {
        CHECK(truncate("loop.voxmap", 0) == 0 && truncate("loop.pointshell", 100) == 0);
    }
}

/* The forces of all ticks, with the files swapped while the hand rests on the floor. */
static void run_over_swap(swap what, uint32_t mode, double forces[2000])
{
    static emulated e;
    static vxsi_link link;
    loop l;
    write_assets("loop.voxmap", "loop.pointshell", 0);
    open_loop(&l, mode);
    make_servo(&l);
    emulated_init(&e, &emulated_hvlink);
    CHECK_INT(emulated_link(&e, &link), VXS_OK);
    vxs_device_command command;
    vxs_device_state state;
    memset(&command, 0, sizeof command);
    for (int tick = 0; tick < 20; tick++) emulated_run(&e, &link);
    CHECK_INT(vxs_device_arm(&link.device), VXS_OK);
    for (int tick = 0; tick < 2000; tick++) {
        e.hand[1] = tick < 600 ? 0 : tick < 1000 ? -0.010 * (tick - 600) / 400 : -0.010;
        if (tick == 1400) do_swap(what);
        emulated_run(&e, &link);
        vxs_device_exchange(&link.device, &command, &state, NULL);
        vxs_servo_tick(l.servo, &state, &command, NULL);
        forces[tick] = e.force[1];
    }
    CHECK_INT(state.state, VXS_DEVICE_ARMED);
    vxs_device_close(&link.device);
    close_loop(&l);
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
        vxs_result now = vxs_asset_open("loop.voxmap", NULL, &file, NULL);
        CHECK_INT(now, what == SWAP_RENAMED ? VXS_OK : what == SWAP_REMOVED ? VXS_IO : VXS_TRUNCATED);
        vxs_asset_close(&file);
    }
    run_over_swap(SWAP_RENAMED, VXS_ASSET_COPY, after);
    CHECK(memcmp(before, after, sizeof before) == 0);
    unlink("loop.voxmap");
    unlink("loop.pointshell");
}

int main(int count, char **arguments)
{
    char folder[] = "safety_loop_XXXXXX";
    const char *only = count > 1 ? arguments[1] : "";
    CHECK(mkdtemp(folder) && chdir(folder) == 0);
    if (!*only || strcmp(only, "unguarded_servo") == 0) unguarded_servo();
    if (!*only || strcmp(only, "asset_swapped") == 0) asset_swapped();
    unlink("loop.voxmap");
    unlink("loop.pointshell");
    CHECK(chdir("..") == 0 && rmdir(folder) == 0);
    return 0;
}
