// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "base/format.hpp"

namespace ti {

/// The keys of `configs/<name>.yaml` that programs need; read from the `config.json` that
/// `scripts/configure.py` writes.
struct Config {
  std::string name = "paper";
  std::string json;  ///< all keys, as the file has them
  Format format;
  int num_trv = 24;
  int num_list = 6;
  int num_ist1 = 8;
  int trv_slots = 32;
  int stack_depth = 4;
  int line_bytes = 64;
  int deal_tile = 16;
  int watchdog_steps = 65535;
  int clock_mhz = 500;
};

/// Throws `Error` when the file is missing or lacks a key.
[[nodiscard]] Config load_config(const std::filesystem::path& json);

}  // namespace ti
