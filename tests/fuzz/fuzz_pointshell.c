/* SPDX-License-Identifier: MIT
 *
 * Any bytes as a .pointshell: refused by a rule, or pressed into a good map.
 */
#include "asset_mutator.h"
#include "asset_use.h"
#include "fuzz_target.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    vxs_asset asset;
    uint64_t variant;
    vxs_pointshell shell;
    uint8_t *copy = use_open(bytes, size, &asset, &variant);
    if (!copy) return 0;
    if (vxs_pointshell_open(&asset, &shell) == VXS_OK) {
        FUZZ_CHECK(shell.point_count >= 1 && shell.padded_count % 16 == 0 && shell.radius >= 0);
        use_pair pair;
        use_pair_open(&pair, &shell);
        use_touch(&pair, use_map((int)(variant >> 30 & 1)), variant);
        use_pair_close(&pair);
    }
    use_close(copy, &asset);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t most, unsigned int seed)
{
    return asset_mutate(bytes, size, most, seed);
}

size_t fuzz_seed(uint32_t number, uint8_t *bytes, size_t most)
{
    return asset_seed(".pointshell", number, bytes, most);
}
