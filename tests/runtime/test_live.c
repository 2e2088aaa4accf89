/* SPDX-License-Identifier: MIT
 *
 * The newest row as another process sees it: whole, and never older than the one before.
 */
#include "check.h"
#include "voxshell/live.h"

#include <stdatomic.h>
#include <sys/wait.h>
#include <unistd.h>

static const char path[] = "test_live.shared";

static vxs_servo_trace row_of(uint64_t tick)
{
    vxs_servo_trace row;
    memset(&row, 0, sizeof row);
    row.tick = tick;
    row.time_ns = (int64_t)tick;
    row.depth = (double)tick;
    row.flags = (uint32_t)tick;
    return row;
}

static int watch(void)
{
    vxs_live live;
    vxs_servo_trace row;
    uint64_t last = 0, seen = 0, number = 0;
    if (vxs_live_open(&live, path) != VXS_OK) return 2;
    while (last < 2000000) {
        uint64_t sequence = vxs_live_get(&live, &row);
        if (sequence == 0) continue;
        if (row.tick < last || (uint64_t)row.time_ns != row.tick || row.depth != (double)row.tick ||
            row.flags != row.tick)
            return 3;
        if (sequence < number || sequence != 2 * row.tick) return 4;
        seen += row.tick != last;
        last = row.tick;
        number = sequence;
    }
    vxs_live_close(&live);
    return seen > 2 ? 0 : 5;
}

int main(void)
{
    vxs_live live, other;
    vxs_servo_trace row;
    CHECK_INT(vxs_live_open(&live, "test_live.none"), VXS_IO);
    CHECK_INT(vxs_live_create(&live, "no/such/folder"), VXS_IO);
    CHECK_INT(vxs_live_create(&live, path), VXS_OK);
    CHECK_INT(vxs_live_open(&other, path), VXS_OK);
    row.tick = 77;
    CHECK(vxs_live_get(&other, &row) == 0 && row.tick == 77); /* empty */
    pid_t child = fork();
    if (child == 0) _exit(watch());
    for (uint64_t tick = 1; tick <= 2000000; tick++) {
        row = row_of(tick);
        vxs_live_put(&live, &row);
    }
    int status;
    CHECK(waitpid(child, &status, 0) == child && WIFEXITED(status));
    CHECK_INT(WEXITSTATUS(status), 0);

    /* As live.h has it for other languages. */
    uint8_t head[72];
    FILE *file = fopen(path, "rb");
    CHECK(file && fread(head, sizeof head, 1, file) == 1);
    fclose(file);
    uint32_t size;
    uint64_t sequence;
    memcpy(&size, head + 8, sizeof size);
    memcpy(&sequence, head + 64, sizeof sequence);
    CHECK(memcmp(head, "VXSLIVE1", 8) == 0 && size == sizeof row && sequence == 4000000);

    vxs_live_close(&live);
    CHECK(vxs_live_get(&other, &row) == 4000000 && row.tick == 2000000); /* who has it keeps it */
    vxs_live_close(&other);
    CHECK_INT(vxs_live_open(&live, path), VXS_IO); /* the file is gone */

    file = fopen(path, "wb"); /* somebody else's */
    CHECK(file && fwrite(head, sizeof head, 1, file) == 1);
    fclose(file);
    CHECK_INT(vxs_live_open(&live, path), VXS_TRUNCATED);
    file = fopen(path, "wb");
    CHECK(file);
    for (int n = 0; n < 1024; n++) fputc(n, file);
    fclose(file);
    CHECK_INT(vxs_live_open(&live, path), VXS_MAGIC);
    CHECK_INT(vxs_live_create(&live, path), VXS_OK); /* in its place */
    vxs_live_close(&live);
    return 0;
}
