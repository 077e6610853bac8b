// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "base/config_keys.hpp"

namespace ti {

/// The configuration in a `config.json`, which `scripts/configure.py` writes.
///
/// Throws `Error` for a file that is missing or no JSON object, and for a key that is missing,
/// unknown or has a value that configs/schema.yaml does not allow.
[[nodiscard]] Config load_config(const std::filesystem::path& json);

}  // namespace ti
