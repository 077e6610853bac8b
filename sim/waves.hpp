// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "base/error.hpp"
#include "verilated.h"
#ifdef TI_WAVES
#include "verilated_fst_c.h"
#endif

namespace ti::sim {

/// The dump of a machine as FST: every signal, at both edges of each cycle, 10 ns apart. Only a
/// library that was built with `waves=1` can write one. `Top` is the machine under Verilator.
template <typename Top>
class Waves {
 public:
#ifdef TI_WAVES
  static constexpr bool kBuilt = true;

  /// Before the machine is made.
  static void prepare(VerilatedContext& context) { context.traceEverOn(true); }

  void open(Top& top, const std::filesystem::path& file) {
    constexpr int kAllLevels = 99;
    dump_ = std::make_unique<VerilatedFstC>();
    top.trace(dump_.get(), kAllLevels);
    dump_->open(file.c_str());
    if (!dump_->isOpen()) throw Error(file.string() + ": it cannot be written");
  }
  void sample() {
    if (!dump_) return;
    dump_->dump(time_);
    time_ += kHalfCycle;
  }
  void close() {
    if (dump_) dump_->close();
    dump_.reset();
  }

 private:
  static constexpr std::uint64_t kHalfCycle = 5;
  std::unique_ptr<VerilatedFstC> dump_;
  std::uint64_t time_ = 0;
#else
  static constexpr bool kBuilt = false;

  static void prepare(VerilatedContext&) {}
  void open(Top&, const std::filesystem::path&) {
    throw Error("this library of the RTL was built without waves: give WAVES=1");
  }
  void sample() {}
  void close() {}
#endif
};

}  // namespace ti::sim
