// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ti {

/// All bytes of `path`. Throws `Error` when it is missing, a folder or not readable.
[[nodiscard]] std::string read_file(const std::filesystem::path& path);

/// Puts `bytes` at `path`, making the folders above it. A reader sees the old file or the whole new
/// one, never a part: the bytes go to a temporary file in the same folder, which is then renamed.
/// Throws `Error` and leaves no temporary file.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// The files of one run: all of them appear, or none. All bytes are written under temporary names
/// first; then the last file of an earlier run goes, and all are renamed in their order. So the
/// last one, a report, never stands beside files of another run.
void write_files(const std::vector<std::pair<std::filesystem::path, std::string_view>>& files);

/// Throws `Error` when `folder` neither is nor can become a folder to write in. Makes nothing.
void check_folder(const std::filesystem::path& folder);

}  // namespace ti
