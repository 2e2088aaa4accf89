/* SPDX-License-Identifier: MIT
 *
 * Any bytes as a .voxmap: refused by a rule, or every look-up stays inside it and a good shell feels it.
 */
#include "asset_mutator.h"
#include "asset_use.h"
#include "fuzz_target.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static use_pair pair;
    if (!pair.shell) use_pair_open(&pair, use_shell());
    vxs_asset asset;
    uint64_t variant;
    vxs_voxmap map;
    uint8_t *copy = use_open(bytes, size, &asset, &variant);
    if (!copy) return 0;
    if (vxs_voxmap_open(&asset, &map) == VXS_OK) {
        use_look_up(&map, variant);
        use_touch(&pair, &map, variant);
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
    return asset_seed(".voxmap", number, bytes, most);
}
