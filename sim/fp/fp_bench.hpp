// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "Vti_fp_top.h"
#include "base/error.hpp"
#include "model/fp.hpp"

namespace ti::sim {

using Model = Fp<TI_EXP_BITS, TI_FRAC_BITS,
                 Modes{.toward_zero = TI_TOWARD_ZERO != 0,
                       .flush = TI_FLUSH != 0,
                       .rcp_table_bits = TI_TABLE_BITS,
                       .rcp_newton_steps = TI_NEWTON_STEPS}>;

enum class FpOp { Add, Sub, Mul, Rcp, Lt, Le, Eq };
inline constexpr std::array<const char*, 7> kFpOpNames = {"add", "sub", "mul", "rcp",
                                                          "lt",  "le",  "eq"};

/// What the model says of `op`; the image of a number, or 0 or 1 for a comparison.
[[nodiscard]] inline std::uint32_t model_result(FpOp op, std::uint32_t a_bits,
                                                std::uint32_t b_bits) {
  const Model a = Model::from_bits(a_bits);
  const Model b = Model::from_bits(b_bits);
  switch (op) {
    case FpOp::Add:
      return (a + b).bits();
    case FpOp::Sub:
      return (a - b).bits();
    case FpOp::Mul:
      return (a * b).bits();
    case FpOp::Rcp:
      return reciprocal(a).bits();
    case FpOp::Lt:
      return a < b;
    case FpOp::Le:
      return a <= b;
    case FpOp::Eq:
      return a == b;
  }
  throw Error("fp_rtl: no such operation.");
}

/// Operands with the place that the caller gives them.
struct FpCase {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint64_t tag = 0;
};

/// Drives `ti_fp_top`, one call a clock cycle, and hands out each result with its operands.
///
/// It also checks the time of every result: an operator's `valid` must be the input's, its stated
/// latency earlier, in every cycle.
class FpBench {
 public:
  FpBench() : top_(std::make_unique<Vti_fp_top>(&context_)) {
    top_->valid_i = 0;
    top_->rst_ni = 0;
    for (int i = 0; i < 4; ++i) edge();
    top_->rst_ni = 1;
    top_->eval();
  }
  ~FpBench() { top_->final(); }
  FpBench(const FpBench&) = delete;
  FpBench& operator=(const FpBench&) = delete;

  /// Cycles after which every result of the last operands is out.
  [[nodiscard]] int drain_cycles() const { return top_->rcp_latency_o + 1; }
  [[nodiscard]] int add_latency() const { return top_->add_latency_o; }
  [[nodiscard]] int mul_latency() const { return top_->mul_latency_o; }
  [[nodiscard]] int rcp_latency() const { return top_->rcp_latency_o; }

  /// One cycle with `input` (a bubble when null). Calls `on_result(op, case, image)` for each
  /// result that is out in it.
  template <typename OnResult>
  void cycle(const FpCase* input, OnResult&& on_result) {
    top_->valid_i = input != nullptr;
    if (input != nullptr) {
      top_->a_i = input->a;
      top_->b_i = input->b;
    }
    history_[now_ % kHistory] = {input != nullptr, input != nullptr ? *input : FpCase{}};
    top_->eval();

    if (input != nullptr) {
      on_result(FpOp::Lt, *input, std::uint32_t{top_->lt_o});
      on_result(FpOp::Le, *input, std::uint32_t{top_->le_o});
      on_result(FpOp::Eq, *input, std::uint32_t{top_->eq_o});
      const bool nan = Model::from_bits(input->a).is_nan() || Model::from_bits(input->b).is_nan();
      if (nan != (top_->unordered_o != 0)) throw Error("fp_rtl: unordered_o is wrong.");
    }
    clocked(FpOp::Add, top_->add_latency_o, top_->add_valid_o, top_->add_result_o, on_result);
    clocked(FpOp::Sub, top_->add_latency_o, top_->sub_valid_o, top_->sub_result_o, on_result);
    clocked(FpOp::Mul, top_->mul_latency_o, top_->mul_valid_o, top_->mul_result_o, on_result);
    clocked(FpOp::Rcp, top_->rcp_latency_o, top_->rcp_valid_o, top_->rcp_result_o, on_result);
    edge();
    ++now_;
  }

 private:
  struct Issued {
    bool valid = false;
    FpCase input;
  };
  static constexpr std::uint64_t kHistory = 64;  // more than any latency

  template <typename OnResult>
  void clocked(FpOp op, std::uint64_t latency, bool valid, std::uint32_t result,
               OnResult&& on_result) {
    static const Issued kNothing;
    const Issued& issued = now_ < latency ? kNothing : history_[(now_ - latency) % kHistory];
    if (valid != issued.valid) {
      throw Error(std::string("fp_rtl: a result of ") + kFpOpNames[static_cast<std::size_t>(op)] +
                  " does not come after its stated latency of " + std::to_string(latency) +
                  " cycles.");
    }
    if (valid) on_result(op, issued.input, result);
  }

  void edge() {
    top_->clk_i = 1;
    top_->eval();
    top_->clk_i = 0;
    top_->eval();
  }

  VerilatedContext context_;
  std::unique_ptr<Vti_fp_top> top_;
  std::array<Issued, kHistory> history_{};
  std::uint64_t now_ = 0;
};

}  // namespace ti::sim
