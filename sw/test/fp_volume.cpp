// SPDX-License-Identifier: Apache-2.0

/// The model of the operators against MPFR, at volume.
///
/// `fp_volume --pairs 10000000 --seed 1` prints one line a format and operation with the number of
/// cases and of differences; exit status 1 when there is any. Formats of up to 10 bits run through
/// all pairs; the others through `--pairs` random and special ones.

#include <mpfr.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "base/format.hpp"
#include "model/fp.hpp"
#include "test/fp_pairs.hpp"

namespace {

constexpr std::array<const char*, 7> kNames = {"add", "sub", "mul", "rcp", "lt", "le", "eq"};
constexpr int kDifferencesShown = 5;

/// Three MPFR numbers of one format, with its range of exponents set for the whole process.
class Oracle {
 public:
  explicit Oracle(ti::Format format) : format_(format) {
    mpfr_set_emin(2 - format.bias() - format.frac_bits);
    mpfr_set_emax(format.bias() + 1);
    for (auto* number : {a_, b_, r_}) mpfr_init2(number, format.frac_bits + 1);
  }
  ~Oracle() {
    for (auto* number : {a_, b_, r_}) mpfr_clear(number);
  }
  Oracle(const Oracle&) = delete;
  Oracle& operator=(const Oracle&) = delete;

  /// Results in the order of `kNames`.
  std::array<std::uint32_t, 7> operator()(std::uint32_t a, std::uint32_t b) {
    mpfr_set_d(a_, ti::value_of_bits(format_, a), MPFR_RNDN);
    mpfr_set_d(b_, ti::value_of_bits(format_, b), MPFR_RNDN);
    return {rounded(mpfr_add(r_, a_, b_, MPFR_RNDN)),
            rounded(mpfr_sub(r_, a_, b_, MPFR_RNDN)),
            rounded(mpfr_mul(r_, a_, b_, MPFR_RNDN)),
            rounded(mpfr_ui_div(r_, 1, a_, MPFR_RNDN)),
            mpfr_less_p(a_, b_) != 0,
            mpfr_lessequal_p(a_, b_) != 0,
            mpfr_equal_p(a_, b_) != 0};
  }

 private:
  std::uint32_t rounded(int ternary) {
    mpfr_subnormalize(r_, ternary, MPFR_RNDN);
    return ti::round_to_bits(format_, mpfr_get_d(r_, MPFR_RNDN));
  }

  ti::Format format_;
  mpfr_t a_, b_, r_;
};

template <int E, int M>
std::array<std::uint32_t, 7> model(std::uint32_t a_bits, std::uint32_t b_bits) {
  const auto a = ti::Fp<E, M>::from_bits(a_bits);
  const auto b = ti::Fp<E, M>::from_bits(b_bits);
  return {(a + b).bits(), (a - b).bits(), (a * b).bits(), reciprocal(a).bits(),
          a < b,          a <= b,         a == b};
}

/// Number of differences.
template <int E, int M>
std::uint64_t run(std::uint64_t pairs, std::uint64_t seed) {
  constexpr bool kExhaustive = 1 + E + M <= 10;
  Oracle oracle({E, M});
  ti::test::FpPairs source(E, M, seed);
  if (kExhaustive) pairs = std::uint64_t{1} << (2 * (1 + E + M));

  std::array<std::uint64_t, 7> differences{};
  for (std::uint64_t i = 0; i < pairs; ++i) {
    auto [a, b] = kExhaustive ? std::pair(static_cast<std::uint32_t>(i >> (1 + E + M)),
                                          static_cast<std::uint32_t>(i & ((2u << (E + M)) - 1)))
                              : source.next();
    const auto want = oracle(a, b);
    const auto got = model<E, M>(a, b);
    if (want == got) continue;
    for (std::size_t op = 0; op < kNames.size(); ++op) {
      if (want[op] == got[op]) continue;
      if (++differences[op] <= kDifferencesShown) {
        std::printf("(%d,%d) %s %x %x: MPFR %x, model %x\n", E, M, kNames[op], a, b, want[op],
                    got[op]);
      }
    }
  }

  std::uint64_t total = 0;
  for (std::size_t op = 0; op < kNames.size(); ++op) {
    std::printf("(%d,%d) %-3s %llu %s, %llu differences\n", E, M, kNames[op],
                static_cast<unsigned long long>(pairs),
                kExhaustive ? "pairs (all)" : "random and special pairs",
                static_cast<unsigned long long>(differences[op]));
    total += differences[op];
  }
  std::fflush(stdout);
  return total;
}

std::uint64_t number(const char* option, const char* text) {
  try {
    std::size_t used = 0;
    const std::uint64_t value = std::stoull(text, &used);
    if (used == std::strlen(text) && text[0] != '-') return value;
  } catch (const std::exception&) {
  }
  throw ti::Error(std::string("fp_volume: ") + option + " needs a whole number, not '" + text +
                  "'.");
}

int run_all(int argc, char** argv) {
  std::uint64_t pairs = 10'000'000;
  std::uint64_t seed = 1;
  for (int i = 1; i < argc; i += 2) {
    const std::string_view option = argv[i];
    if ((option != "--pairs" && option != "--seed") || i + 1 == argc) {
      throw ti::Error("fp_volume: usage is fp_volume [--pairs N] [--seed N].");
    }
    (option == "--pairs" ? pairs : seed) = number(argv[i], argv[i + 1]);
  }
  std::printf("seed %llu, MPFR %s\n", static_cast<unsigned long long>(seed), mpfr_get_version());
  std::uint64_t total = 0;
  total += run<3, 2>(pairs, seed);
  total += run<3, 4>(pairs, seed);
  total += run<4, 3>(pairs, seed);
  total += run<4, 5>(pairs, seed);
  total += run<5, 4>(pairs, seed);
  total += run<8, 23>(pairs, seed);
  total += run<7, 16>(pairs, seed);
  total += run<5, 10>(pairs, seed);
  std::printf("%llu differences in all\n", static_cast<unsigned long long>(total));
  return total == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run_all(argc, argv);
  } catch (const ti::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
