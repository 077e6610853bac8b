// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "base/format.hpp"
#include "model/fp_rules.hpp"

namespace ti {

/// A number of the format that `Source` names; bit-exact model of `rtl/fp`.
///
/// IEEE 754 rules: every operation rounds once, by the modes of the format; overflow gives
/// infinity, or the largest number where operations round toward zero; any NaN reads back as the
/// one quiet NaN (sign 0, fraction 10...0). With `flush` a subnormal operand is zero of its sign,
/// and so is a result that is below the least normal number after rounding as if exponents had no
/// end. A reciprocal by Newton steps is off by what `Format::reciprocal_half_ulps` says.
///
/// The value is held as a `float`, in which every number of every format is exact. Operations are
/// native ones: in `float` for (8, 23) in its default modes; otherwise in `double`, then rounded to
/// the format.
///
/// To nearest that is the correctly rounded result although two roundings may happen. With
/// p = M + 1 <= 24:
/// - A product has at most 2p <= 48 bits and an exponent far inside the range of `double`: exact.
/// - A sum that is subnormal in the format is a multiple of the least subnormal, hence exact. A sum
///   or quotient that is normal in it, or is rounded as if it were, is right because 53 >= 2p + 2
///   (Figueroa 1995, "When is double rounding innocuous?").
/// - 1/x is in the subnormal range only by one or two places, to precision q < p. A midpoint y of
///   that precision has at most p bits, so when x*y is not 1, |1 - x*y| is at least 2^-2p, and 1/x
///   is relatively farther than 2^-49 from y: `double` keeps it on the right side.
///
/// Toward zero two roundings are never innocuous, as a double may have been rounded up to a number
/// of the format. So the sign of its error is found: of a product none, of a sum exactly (Knuth's
/// two-sum, in which nothing overflows), of the quotient q = fl(1/x) by whether q*x > 1. Where q is
/// a number of the format q*x is exact, and elsewhere a product that comes out above 1 is above 1.
///
/// Needs a build without contraction or fast-math, and a thread that does not flush subnormals.
template <class Source>
class FpNumber {
  static_assert(std::numeric_limits<float>::is_iec559 && std::numeric_limits<double>::is_iec559);

 public:
  static constexpr auto kExpBits = Source::kExpBits;
  static constexpr auto kFracBits = Source::kFracBits;
  static constexpr auto kWidth = Source::kWidth;
  static constexpr auto kBias = Source::kBias;
  static constexpr auto kSignBit = Source::kSignBit;
  static constexpr auto kInfBits = Source::kInfBits;  ///< of +infinity
  static constexpr auto kNanBits = Source::kNanBits;

  [[nodiscard]] static constexpr const Format& format() { return rules().format; }
  [[nodiscard]] static constexpr const Modes& modes() { return rules().format.modes; }
  /// `Format::reciprocal_half_ulps`.
  [[nodiscard]] static constexpr std::uint32_t reciprocal_half_ulps() {
    return static_cast<std::uint32_t>(rules().reciprocal_half_ulps);
  }

  /// +0.
  constexpr FpNumber() = default;

  /// The value whose image is the lowest `kWidth` bits of `bits`; those above are ignored. A
  /// subnormal image stays as it is also where operations take it for zero.
  [[nodiscard]] static FpNumber from_bits(std::uint32_t bits) {
    if constexpr (kNative) {
      return FpNumber(std::bit_cast<float>(bits));
    } else {
      const int e = rules().format.exp_bits;
      const int m = rules().format.frac_bits;
      const std::uint32_t magnitude = bits & (rules().sign_bit - 1);
      const std::uint32_t sign = (bits & rules().sign_bit) << (31 - e - m);
      if (magnitude > rules().inf_bits) return FpNumber(std::numeric_limits<float>::quiet_NaN());
      if (magnitude == rules().inf_bits) return FpNumber(std::bit_cast<float>(sign | kFloatInf));
      if (e < 8 && magnitude < (std::uint32_t{1} << m)) {
        const float value = static_cast<float>(magnitude) * static_cast<float>(rules().quantum);
        return FpNumber(std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(value)));
      }
      return FpNumber(std::bit_cast<float>(sign | ((magnitude << (23 - m)) + rules().rebias)));
    }
  }

  /// `value` rounded to nearest even in every mode, as what enters an engine is (`round_to_bits`).
  [[nodiscard]] static FpNumber from_double(double value) {
    if constexpr (kNative) {
      return FpNumber(static_cast<float>(value));
    } else {
      return FpNumber(rules().nearest(value));
    }
  }

  /// The image in the lowest `kWidth` bits; the canonical quiet NaN for any NaN.
  [[nodiscard]] std::uint32_t bits() const {
    if (is_nan()) return rules().nan_bits;
    const std::uint32_t image = std::bit_cast<std::uint32_t>(value_);
    if constexpr (kNative) {
      return image;
    } else {
      const int e = rules().format.exp_bits;
      const int m = rules().format.frac_bits;
      const std::uint32_t sign = (image >> 31) << (e + m);
      const std::uint32_t magnitude = image & 0x7fffffffu;
      if (magnitude == kFloatInf) return sign | rules().inf_bits;
      if (e < 8 && magnitude < rules().rebias + (std::uint32_t{1} << 23)) {
        const double quanta = std::fabs(static_cast<double>(value_)) * rules().quanta;
        return sign | static_cast<std::uint32_t>(quanta);
      }
      return sign | ((magnitude - rules().rebias) >> (23 - m));
    }
  }

  [[nodiscard]] double to_double() const { return static_cast<double>(value_); }
  [[nodiscard]] float to_float() const { return value_; }

  [[nodiscard]] bool is_nan() const { return value_ != value_; }
  [[nodiscard]] bool is_inf() const { return std::fabs(value_) == kFloatInfinity; }
  [[nodiscard]] bool is_finite() const { return std::fabs(value_) < kFloatInfinity; }
  [[nodiscard]] bool is_zero() const { return operand() == 0.0f; }

  /// The sign bit of `bits()`: true for -0, false for NaN.
  [[nodiscard]] bool signbit() const { return !is_nan() && std::signbit(value_); }

  [[nodiscard]] friend FpNumber operator+(FpNumber a, FpNumber b) {
    if constexpr (kNative) return FpNumber(a.value_ + b.value_);
    return sum(a.wide(), b.wide());
  }
  [[nodiscard]] friend FpNumber operator-(FpNumber a, FpNumber b) {
    if constexpr (kNative) return FpNumber(a.value_ - b.value_);
    return sum(a.wide(), -b.wide());
  }
  [[nodiscard]] friend FpNumber operator*(FpNumber a, FpNumber b) {
    if constexpr (kNative) return FpNumber(a.value_ * b.value_);
    const double product = a.wide() * b.wide();
    return FpNumber(modes().toward_zero ? rules().toward_zero(product, 0.0)
                                        : rules().nearest(product));
  }
  [[nodiscard]] FpNumber operator-() const { return FpNumber(-value_); }

  /// 1 / x, correctly rounded unless it is found by Newton steps; 1/0 and 1/infinity are infinity
  /// and 0 with the sign of x.
  [[nodiscard]] friend FpNumber reciprocal(FpNumber x) {
    if constexpr (kNative) return FpNumber(1.0f / x.value_);
    if (modes().rcp_table_bits > 0) return FpNumber(rules().newton(x.wide()));
    const double quotient = 1.0 / x.wide();
    if (!modes().toward_zero) return FpNumber(rules().nearest(quotient));
    return FpNumber(rules().toward_zero(quotient, quotient * x.wide() > 1.0 ? -quotient : 0.0));
  }

  // Values are compared: -0 equals +0, and each comparison with NaN is false.
  [[nodiscard]] friend bool operator<(FpNumber a, FpNumber b) { return a.operand() < b.operand(); }
  [[nodiscard]] friend bool operator<=(FpNumber a, FpNumber b) {
    return a.operand() <= b.operand();
  }
  [[nodiscard]] friend bool operator>(FpNumber a, FpNumber b) { return a.operand() > b.operand(); }
  [[nodiscard]] friend bool operator>=(FpNumber a, FpNumber b) {
    return a.operand() >= b.operand();
  }
  [[nodiscard]] friend bool operator==(FpNumber a, FpNumber b) {
    return a.operand() == b.operand();
  }

  /// The value `n` steps farther from zero: magnitude image + n, at most infinity. NaN stays.
  [[nodiscard]] FpNumber ulps_up(std::uint32_t n) const {
    if (is_nan()) return *this;
    const std::uint32_t image = bits();
    const std::uint32_t magnitude = image & (rules().sign_bit - 1);
    const std::uint32_t inf = rules().inf_bits;
    const std::uint32_t moved = n >= inf - magnitude ? inf : magnitude + n;
    return from_bits((image & rules().sign_bit) | moved);
  }

  /// The value `n` steps nearer to zero: magnitude image - n, at least 0; the sign stays. NaN
  /// stays.
  [[nodiscard]] FpNumber ulps_down(std::uint32_t n) const {
    if (is_nan()) return *this;
    const std::uint32_t image = bits();
    const std::uint32_t magnitude = image & (rules().sign_bit - 1);
    const std::uint32_t moved = n >= magnitude ? 0 : magnitude - n;
    return from_bits((image & rules().sign_bit) | moved);
  }

 private:
  static constexpr bool kNative = Source::kNative;
  static constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();
  static constexpr std::uint32_t kFloatInf = 0x7f800000u;

  [[nodiscard]] static constexpr const FpRules& rules() { return Source::rules(); }

  constexpr explicit FpNumber(float value) : value_(value) {}

  /// The value that operations see.
  [[nodiscard]] float operand() const {
    if (!modes().flush) return value_;
    const bool tiny = std::fabs(value_) < static_cast<float>(rules().least_normal);
    return tiny ? std::copysign(0.0f, value_) : value_;
  }
  [[nodiscard]] double wide() const { return static_cast<double>(operand()); }

  [[nodiscard]] static FpNumber sum(double a, double b) {
    const double value = a + b;
    if (!modes().toward_zero) return FpNumber(rules().nearest(value));
    const double b_part = value - a;
    const double error = (a - (value - b_part)) + (b - b_part);
    return FpNumber(rules().toward_zero(value, error));
  }

  float value_ = 0.0f;
};

/// A format that is known when the model is compiled.
template <int E, int M, Modes kModes>
struct FixedFormat {
  static_assert(E >= 3 && E <= 8 && M >= 2 && M <= 23);
  static constexpr FpRules kRules{Format{E, M, kModes}};
  [[nodiscard]] static constexpr const FpRules& rules() { return kRules; }

  static constexpr bool kNative = E == 8 && M == 23 && kModes == Modes{};
  static constexpr int kExpBits = E;
  static constexpr int kFracBits = M;
  static constexpr int kWidth = 1 + E + M;
  static constexpr int kBias = (1 << (E - 1)) - 1;
  static constexpr std::uint32_t kSignBit = kRules.sign_bit;
  static constexpr std::uint32_t kInfBits = kRules.inf_bits;
  static constexpr std::uint32_t kNanBits = kRules.nan_bits;
};

/// A number of `E` exponent and `M` fraction bits.
template <int E, int M, Modes kModes = Modes{}>
using Fp = FpNumber<FixedFormat<E, M, kModes>>;

/// The format that this thread's `AnyFp` numbers have while the object lives; the one before then
/// returns.
class FormatScope {
 public:
  explicit FormatScope(const FpRules& rules) : before_(current_) { current_ = &rules; }
  ~FormatScope() { current_ = before_; }
  FormatScope(const FormatScope&) = delete;
  FormatScope& operator=(const FormatScope&) = delete;

  /// Of the innermost scope; there must be one.
  [[nodiscard]] static const FpRules& rules() { return *current_; }

 private:
  static inline constinit thread_local const FpRules* current_ = nullptr;
  const FpRules* before_;
};

/// A format that is known when the model runs. The constants are read where they are used.
struct ScopedFormat {
  template <auto kRead>
  struct Constant {
    using Value = decltype(kRead(std::declval<const FpRules&>()));
    operator Value() const { return kRead(FormatScope::rules()); }  // NOLINT: reads as its value
  };
  [[nodiscard]] static const FpRules& rules() { return FormatScope::rules(); }

  static constexpr bool kNative = false;
  static constexpr Constant<[](const FpRules& r) { return r.format.exp_bits; }> kExpBits{};
  static constexpr Constant<[](const FpRules& r) { return r.format.frac_bits; }> kFracBits{};
  static constexpr Constant<[](const FpRules& r) { return r.format.width(); }> kWidth{};
  static constexpr Constant<[](const FpRules& r) { return r.format.bias(); }> kBias{};
  static constexpr Constant<[](const FpRules& r) { return r.sign_bit; }> kSignBit{};
  static constexpr Constant<[](const FpRules& r) { return r.inf_bits; }> kInfBits{};
  static constexpr Constant<[](const FpRules& r) { return r.nan_bits; }> kNanBits{};
};

/// A number of the format of the innermost `FormatScope`: any format, some times slower than one
/// that is compiled.
using AnyFp = FpNumber<ScopedFormat>;

}  // namespace ti
