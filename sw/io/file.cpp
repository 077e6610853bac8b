// SPDX-License-Identifier: Apache-2.0
#include "io/file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <iterator>
#include <system_error>

#include "base/error.hpp"

namespace ti {

namespace fs = std::filesystem;

std::string read_file(const fs::path& path) {
  std::error_code ec;
  const fs::file_status status = fs::status(path, ec);
  if (!fs::exists(status)) {
    throw Error(fmt::format("{}: there is no such file; check the path", path.string()));
  }
  if (fs::is_directory(status)) {
    throw Error(fmt::format("{}: this is a folder; name a file in it", path.string()));
  }
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) {
    throw Error(fmt::format("{}: the file cannot be read; check its permissions", path.string()));
  }
  return bytes;
}

namespace {

[[noreturn]] void cannot_write(const fs::path& path) {
  throw Error(fmt::format("{}: the file cannot be written; check permissions and free space",
                          path.string()));
}

/// Writes `bytes` to a temporary file beside `path`, making the folders above; its name.
fs::path write_part(const fs::path& path, std::string_view bytes) {
  static std::atomic<unsigned> serial{0};
  std::error_code ec;
  if (path.filename().empty() || fs::is_directory(path, ec)) {
    throw Error(
        fmt::format("{}: a file cannot be written over a folder; name a file", path.string()));
  }
  if (path.has_parent_path()) {
    fs::create_directories(path.parent_path(), ec);
    if (ec) {
      throw Error(fmt::format("{}: the folder cannot be made ({}); choose another place",
                              path.parent_path().string(), ec.message()));
    }
  }
  fs::path part = path;
  part += fmt::format(".{}.{}.part", getpid(), serial++);
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (out.fail()) {
    fs::remove(part, ec);
    cannot_write(path);
  }
  return part;
}

}  // namespace

void write_file(const fs::path& path, std::string_view bytes) { write_files({{path, bytes}}); }

void write_files(const std::vector<std::pair<fs::path, std::string_view>>& files) {
  std::vector<fs::path> parts;
  std::error_code ec;
  try {
    for (const auto& [path, bytes] : files) parts.push_back(write_part(path, bytes));
    if (files.size() > 1) fs::remove(files.back().first, ec);
    for (std::size_t i = 0; i < files.size(); ++i) {
      fs::rename(parts[i], files[i].first, ec);
      if (ec) cannot_write(files[i].first);
    }
  } catch (const Error&) {
    for (const fs::path& part : parts) fs::remove(part, ec);
    throw;
  }
}

void check_folder(const fs::path& folder) {
  std::error_code ec;
  fs::path place = folder.empty() ? fs::path(".") : folder;
  while (!fs::exists(place, ec)) {
    place = place.has_parent_path() ? place.parent_path() : fs::path(".");
  }
  if (!fs::is_directory(place, ec)) {
    throw Error(fmt::format("{}: the folder cannot be made, as {} is a file; choose another place",
                            folder.string(), place.string()));
  }
  if (access(place.c_str(), W_OK | X_OK) != 0) {
    throw Error(fmt::format("{}: nothing can be written in {}; check its permissions",
                            folder.string(), place.string()));
  }
}

}  // namespace ti
