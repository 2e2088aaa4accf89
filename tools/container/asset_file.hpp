// SPDX-License-Identifier: GPL-3.0-or-later
// An asset file opened and checked by the runtime, its refusals turned into Failure.
#pragma once

#include "container/container.hpp"

#include "voxshell/asset.h"

#include <filesystem>
#include <string>

namespace voxshell {

/// An asset on disk. Opening checks every rule, C303 (the content hash, which the runtime leaves out)
/// included. Throws Failure: system (cannot be read), unsupported (a newer major version, an unknown required
/// feature), invalid with `rule M305 section BRIK offset 1234: TEXT` for all else.
class AssetFile {
  public:
    /// `kind`: VXS_ASSET_VOXMAP, VXS_ASSET_POINTSHELL or VXS_ASSET_ANY.
    explicit AssetFile(const std::filesystem::path &path, std::uint32_t kind = VXS_ASSET_ANY);
    ~AssetFile() { vxs_asset_close(&asset_); }
    AssetFile(const AssetFile &) = delete;
    AssetFile &operator=(const AssetFile &) = delete;

    const vxs_asset &asset() const { return asset_; }
    const vxs_container_header &header() const { return *vxs_asset_header(&asset_); }
    Sha256 source_hash() const;
    Sha256 content_hash() const;
    std::string meta() const; ///< JSON text as it stands in the file
    std::span<const vxs_container_section> sections() const;
    std::span<const std::uint8_t> bytes_of(const vxs_container_section &section) const
    {
        return {asset_.data + section.offset, section.size};
    }

  private:
    vxs_asset asset_{};
};

} // namespace voxshell
