// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace ti {

/// All bytes of `path`. Throws `Error` when it is missing, a folder or not readable.
[[nodiscard]] std::string read_file(const std::filesystem::path& path);

/// Puts `bytes` at `path`, making the folders above it. A reader sees the old file or the whole new
/// one, never a part: the bytes go to a temporary file in the same folder, which is then renamed.
/// Throws `Error` and leaves no temporary file.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// Throws `Error` when `folder` neither is nor can become a folder to write in. Makes nothing.
void check_folder(const std::filesystem::path& folder);

}  // namespace ti
