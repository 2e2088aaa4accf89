/* SPDX-License-Identifier: MIT
 *
 * The live state's file.
 */
#define _DEFAULT_SOURCE 1 /* ftruncate */

#include "live_memory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static const char magic[8] = {'V', 'X', 'S', 'L', 'I', 'V', 'E', '1'};

static vxs_result open_error(void)
{
    return errno == EACCES || errno == EPERM ? VXS_ACCESS : VXS_IO;
}

static vxs_result map(vxs_live *live, int file, int protection)
{
    void *memory = mmap(NULL, sizeof(vxsi_live_memory), protection, MAP_SHARED, file, 0);
    close(file);
    if (memory == MAP_FAILED) return VXS_IO;
    live->memory = memory;
    live->size = sizeof(vxsi_live_memory);
    return VXS_OK;
}

/* A new file: who still reads the one before keeps that. */
vxs_result vxs_live_create(vxs_live *live, const char *path)
{
    if (!live || !path || strlen(path) >= sizeof live->path) return VXS_PARAM;
    memset(live, 0, sizeof *live);
    if (unlink(path) != 0 && errno != ENOENT) return open_error();
    int file = open(path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0644);
    if (file < 0) return open_error();
    if (ftruncate(file, sizeof(vxsi_live_memory)) != 0) {
        close(file);
        unlink(path);
        return VXS_IO;
    }
    vxs_result result = map(live, file, PROT_READ | PROT_WRITE);
    if (result != VXS_OK) {
        unlink(path);
        return result;
    }
    vxsi_live_memory *memory = live->memory;
    memset(memory, 0, sizeof *memory); /* every page is there before the first tick */
    memory->row_size = sizeof(vxs_servo_trace);
    memory->process = (uint32_t)getpid();
    memcpy(memory->magic, magic, sizeof magic);
    live->is_writer = 1;
    strcpy(live->path, path);
    return VXS_OK;
}

vxs_result vxs_live_open(vxs_live *live, const char *path)
{
    struct stat about;
    if (!live || !path || strlen(path) >= sizeof live->path) return VXS_PARAM;
    memset(live, 0, sizeof *live);
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return open_error();
    if (fstat(file, &about) != 0 || about.st_size < (off_t)sizeof(vxsi_live_memory)) {
        close(file);
        return VXS_TRUNCATED;
    }
    vxs_result result = map(live, file, PROT_READ);
    if (result != VXS_OK) return result;
    const vxsi_live_memory *memory = live->memory;
    if (memcmp(memory->magic, magic, sizeof magic) != 0)
        result = VXS_MAGIC;
    else if (memory->row_size != sizeof(vxs_servo_trace))
        result = VXS_VERSION;
    if (result != VXS_OK) vxs_live_close(live);
    return result;
}

void vxs_live_close(vxs_live *live)
{
    if (!live || !live->memory) return;
    munmap(live->memory, live->size);
    if (live->is_writer) unlink(live->path);
    live->memory = NULL;
}
