// SPDX-License-Identifier: Apache-2.0

/// The RTL operators of one format against the model, or against lines of Berkeley TestFloat.
///
/// `fp_rtl [--pairs N] [--seed N]` runs all pairs of a format of up to 10 bits, else N random and
/// special ones, once without a pause and once with bubbles. `fp_rtl --testfloat FILE --op OP`
/// replays a file. Exit status 0: no difference; 1: differences; 2: bad input, in one sentence.

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <map>
#include <random>
#include <string>
#include <string_view>
#include <tuple>

#include "fp_bench.hpp"
#include "test/fp_pairs.hpp"
#include "testfloat_file.hpp"

namespace ti::sim {
namespace {

constexpr int kDifferencesShown = 10;
constexpr bool kExhaustive = Model::kWidth <= 10;

struct Options {
  std::uint64_t pairs = 100'000;
  std::uint64_t seed = 1;
  std::string testfloat;
  std::string op;
};

[[nodiscard]] const char* name(FpOp op) { return kFpOpNames[static_cast<std::size_t>(op)]; }

/// Differences between RTL and model over the whole volume; every cycle has operands, or every
/// cycle has them with probability 1/2.
std::uint64_t run_volume(const Options& options, bool bubbles) {
  FpBench bench;
  test::FpPairs source(Model::kExpBits, Model::kFracBits, options.seed);
  std::mt19937_64 pauses(options.seed);
  std::array<std::uint64_t, kFpOpNames.size()> results{};
  std::array<std::uint64_t, kFpOpNames.size()> differences{};

  const auto check = [&](FpOp op, const FpCase& input, std::uint32_t got) {
    const auto index = static_cast<std::size_t>(op);
    ++results[index];
    const std::uint32_t want = model_result(op, input.a, input.b);
    if (got == want) return;
    if (++differences[index] > kDifferencesShown) return;
    std::printf("%s %x %x: model %x, RTL %x\n", name(op), input.a, input.b, want, got);
  };

  const std::uint64_t pairs = kExhaustive ? std::uint64_t{1} << (2 * Model::kWidth) : options.pairs;
  for (std::uint64_t i = 0; i < pairs; ++i) {
    while (bubbles && (pauses() & 1) != 0) bench.cycle(nullptr, check);
    FpCase input;
    if constexpr (kExhaustive) {
      input.a = static_cast<std::uint32_t>(i >> Model::kWidth);
      input.b = static_cast<std::uint32_t>(i) & (2 * Model::kSignBit - 1);
    } else {
      std::tie(input.a, input.b) = source.next();
    }
    bench.cycle(&input, check);
  }
  for (int i = 0; i < bench.drain_cycles(); ++i) bench.cycle(nullptr, check);

  std::uint64_t total = 0;
  for (std::size_t op = 0; op < kFpOpNames.size(); ++op) {
    std::printf("(%d,%d) %-3s %llu %s, %s: %llu differences\n", Model::kExpBits, Model::kFracBits,
                kFpOpNames[op], static_cast<unsigned long long>(results[op]),
                kExhaustive ? "pairs (all)" : "random and special pairs",
                bubbles ? "with bubbles" : "one a cycle",
                static_cast<unsigned long long>(differences[op]));
    total += differences[op];
    if (results[op] != pairs) throw Error("fp_rtl: the number of results is not that of operands.");
  }
  if (!bubbles) {
    std::printf("(%d,%d) latencies measured: add %d, mul %d, rcp %d\n", Model::kExpBits,
                Model::kFracBits, bench.add_latency(), bench.mul_latency(), bench.rcp_latency());
  }
  return total;
}

/// TestFloat's names of the comparisons name the signalling of flags too, which we do not have.
FpOp op_of(const std::string& text) {
  static const std::map<std::string_view, std::string_view> kAliases = {
      {"lt_quiet", "lt"}, {"le_quiet", "le"}, {"eq_signaling", "eq"}};
  const auto alias = kAliases.find(text);
  const std::string_view wanted = alias == kAliases.end() ? text : alias->second;
  for (std::size_t op = 0; op < kFpOpNames.size(); ++op) {
    if (wanted == kFpOpNames[op]) return static_cast<FpOp>(op);
  }
  throw Error("There is no operation '" + text + "': OP is add, sub, mul, rcp, lt, le or eq.");
}

[[nodiscard]] bool same_value(bool is_number, std::uint32_t got, std::uint32_t want) {
  if (got == want) return true;
  return is_number && Model::from_bits(got).is_nan() && Model::from_bits(want).is_nan();
}

int run_testfloat(const Options& options) {
  const FpOp op = op_of(options.op);
  const bool is_number = op != FpOp::Lt && op != FpOp::Le && op != FpOp::Eq;
  TestFloatFile file(options.testfloat, op == FpOp::Rcp ? 1 : 2, Model::kWidth,
                     is_number ? Model::kWidth : 1);
  FpBench bench;
  std::array<TestFloatLine, 64> pending{};  // more than any latency
  std::uint64_t lines = 0;
  std::uint64_t model_differences = 0;
  std::uint64_t rtl_differences = 0;
  std::uint64_t results = 0;

  const auto check = [&](FpOp done, const FpCase& input, std::uint32_t got) {
    if (done != op) return;
    ++results;
    const TestFloatLine& line = pending[input.tag % pending.size()];
    const std::uint32_t model = model_result(op, line.a, line.b);
    const bool model_differs = !same_value(is_number, model, line.result);
    const bool rtl_differs = !same_value(is_number, got, line.result);
    model_differences += model_differs;
    rtl_differences += rtl_differs;
    if (!model_differs && !rtl_differs) return;
    if (std::max(model_differences, rtl_differences) > kDifferencesShown) return;
    std::printf("line %llu: %s %x %x: file %x, model %x, RTL %x\n",
                static_cast<unsigned long long>(line.number), name(op), line.a, line.b, line.result,
                model, got);
  };

  for (TestFloatLine line; file.next(line); ++lines) {
    pending[lines % pending.size()] = line;
    const FpCase input{line.a, line.b, lines};
    bench.cycle(&input, check);
  }
  for (int i = 0; i < bench.drain_cycles(); ++i) bench.cycle(nullptr, check);
  if (lines == 0) throw Error("The TestFloat file '" + options.testfloat + "' has no lines.");
  if (results != lines) throw Error("fp_rtl: the number of results is not that of lines.");

  std::printf("%s (%d,%d): values compared, any NaN equals any NaN; the operators have no flags\n",
              name(op), Model::kExpBits, Model::kFracBits);
  std::printf("%llu lines, %llu model differences, %llu RTL differences\n",
              static_cast<unsigned long long>(lines),
              static_cast<unsigned long long>(model_differences),
              static_cast<unsigned long long>(rtl_differences));
  return model_differences + rtl_differences == 0 ? 0 : 1;
}

std::uint64_t whole_number(const std::string& option, const std::string& text) {
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) {
    throw Error("fp_rtl: " + option + " needs a whole number, not '" + text + "'.");
  }
  return value;
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2) {
    const std::string option = argv[i];
    const bool known =
        option == "--pairs" || option == "--seed" || option == "--testfloat" || option == "--op";
    if (!known || i + 1 == argc) {
      throw Error("fp_rtl: usage is fp_rtl [--pairs N] [--seed N] or --testfloat FILE --op OP.");
    }
    const std::string text = argv[i + 1];
    if (option == "--pairs") options.pairs = whole_number(option, text);
    if (option == "--seed") options.seed = whole_number(option, text);
    if (option == "--testfloat") options.testfloat = text;
    if (option == "--op") options.op = text;
  }
  if (options.testfloat.empty() != options.op.empty()) {
    throw Error("fp_rtl: --testfloat FILE and --op OP go together.");
  }
  return options;
}

}  // namespace
}  // namespace ti::sim

int main(int argc, char** argv) {
  try {
    const ti::sim::Options options = ti::sim::parse(argc, argv);
    if (!options.testfloat.empty()) return ti::sim::run_testfloat(options);
    std::printf("seed %llu\n", static_cast<unsigned long long>(options.seed));
    const std::uint64_t differences =
        ti::sim::run_volume(options, false) + ti::sim::run_volume(options, true);
    std::printf("%llu differences in all\n", static_cast<unsigned long long>(differences));
    return differences == 0 ? 0 : 1;
  } catch (const ti::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
