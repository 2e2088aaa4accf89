/* SPDX-License-Identifier: MIT
 *
 * The operating system's part of opening an asset. Mapping is the only memory that it takes.
 */
#define _DEFAULT_SOURCE 1 /* MAP_ANONYMOUS, MAP_POPULATE */
#define _FILE_OFFSET_BITS 64

#include "asset_check.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#ifndef MAP_POPULATE
#define MAP_POPULATE 0
#endif

void vxs_asset_config_default(vxs_asset_config *config)
{
    memset(config, 0, sizeof *config);
    config->struct_size = sizeof *config;
}

static vxs_result give(vxs_result result, const vxsi_check *check, vxs_asset *out, vxs_asset_issue *issue)
{
    if (result != VXS_OK) memset(out, 0, sizeof *out);
    if (issue) *issue = check->issue;
    return result;
}

static vxs_result fail(vxs_result result, const char *text, int system_error, vxs_asset *out,
                       vxs_asset_issue *issue)
{
    vxsi_check check = {0};
    check.issue.text = text;
    check.issue.system_error = system_error;
    return give(result, &check, out, issue);
}

static vxs_result take_config(const vxs_asset_config *given, vxs_asset_config *config)
{
    vxs_asset_config_default(config);
    if (!given) return VXS_OK;
    if (given->struct_size != sizeof *given) return VXS_CONFIG;
    *config = *given;
    return config->kind <= VXS_ASSET_PLAN && config->mode <= VXS_ASSET_COPY ? VXS_OK : VXS_PARAM;
}

vxs_result vxs_asset_from_memory(const void *data, size_t size, const vxs_asset_config *given, vxs_asset *out,
                                 vxs_asset_issue *issue)
{
    if (!out) return VXS_PARAM;
    vxs_asset_config config;
    vxs_result result = take_config(given, &config);
    if (result != VXS_OK || !data) {
        if (result == VXS_OK) result = VXS_PARAM;
        return fail(result, vxs_result_text(result), 0, out, issue);
    }
    if ((uintptr_t)data % VXS_CONTAINER_ALIGNMENT != 0)
        return fail(VXS_BUFFER, "the memory is not 64-byte aligned", 0, out, issue);
    vxsi_check check = {.data = data,
                        .size = size,
                        .skip_checksums = config.skip_checksums || config.trusted,
                        .trusted = config.trusted != 0};
    return give(vxsi_check_asset(&check, config.kind, out), &check, out, issue);
}

/* Reads until size bytes are there; a file that ends early leaves zeros, which no checksum
 * and no header accepts. */
static int read_all(int fd, uint8_t *to, size_t size)
{
    while (size > 0) {
        ssize_t got = read(fd, to, size);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return -1;
        if (got == 0) return 0;
        to += got;
        size -= (size_t)got;
    }
    return 0;
}

static void *take_bytes(int fd, size_t size, uint32_t mode)
{
    if (mode == VXS_ASSET_MAP) return mmap(NULL, size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, fd, 0);
    void *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return memory;
    if (read_all(fd, memory, size) != 0) {
        int error = errno;
        munmap(memory, size);
        errno = error;
        return MAP_FAILED;
    }
    (void)mprotect(memory, size, PROT_READ);
    return memory;
}

vxs_result vxs_asset_open(const char *path, const vxs_asset_config *given, vxs_asset *out,
                          vxs_asset_issue *issue)
{
    if (!out) return VXS_PARAM;
    vxs_asset_config config;
    vxs_result result = take_config(given, &config);
    if (result == VXS_OK && !path) result = VXS_PARAM;
    if (result != VXS_OK) return fail(result, vxs_result_text(result), 0, out, issue);

    int fd;
    do fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    while (fd < 0 && errno == EINTR);
    if (fd < 0) return fail(VXS_IO, "the file cannot be opened", errno, out, issue);
    struct stat status;
    if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
        close(fd);
        return fail(VXS_IO, "not a regular file", EINVAL, out, issue);
    }
    if (status.st_size == 0 || (uint64_t)status.st_size > SIZE_MAX) {
        close(fd);
        if (status.st_size == 0) {
            vxsi_check empty = {.data = (const uint8_t *)"", .size = 0};
            return give(vxsi_check_asset(&empty, config.kind, out), &empty, out, issue);
        }
        return fail(VXS_IO, "the file exceeds the address space", EFBIG, out, issue);
    }
    size_t size = (size_t)status.st_size;
    void *bytes = take_bytes(fd, size, config.mode);
    int error = errno;
    close(fd);
    if (bytes == MAP_FAILED) return fail(VXS_IO, "the file cannot be read into memory", error, out, issue);

    vxsi_check check = {.data = bytes,
                        .size = size,
                        .skip_checksums = config.skip_checksums || config.trusted,
                        .trusted = config.trusted != 0};
    result = give(vxsi_check_asset(&check, config.kind, out), &check, out, issue);
    if (result == VXS_OK)
        out->mapped_size = size;
    else
        munmap(bytes, size);
    return result;
}

void vxs_asset_close(vxs_asset *asset)
{
    if (!asset) return;
    vxsi_asset_unguard(asset);
    if (asset->mapped_size > 0) munmap((void *)(uintptr_t)asset->data, (size_t)asset->mapped_size);
    memset(asset, 0, sizeof *asset);
}
