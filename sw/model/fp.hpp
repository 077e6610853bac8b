// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace ti {

/// A number of `E` exponent and `M` fraction bits; bit-exact model of `rtl/fp`.
///
/// IEEE 754 rules: every operation rounds once, to nearest even; subnormals are kept; overflow
/// gives infinity; any NaN reads back as the one quiet NaN (sign 0, fraction 10...0).
///
/// The value is held as a `float`, in which every number of every format is exact. Operations are
/// native ones: in `float` for (8, 23); otherwise in `double`, then rounded to the format. That is
/// the correctly rounded result although two roundings may happen. With p = M + 1 <= 24:
/// - A product has at most 2p <= 48 bits and an exponent far inside the range of `double`: exact.
/// - A sum that is subnormal in the format is a multiple of the least subnormal, hence exact. A sum
/// or
///   quotient that is normal in it is right because 53 >= 2p + 2 (Figueroa 1995, "When is double
///   rounding innocuous?").
/// - 1/x is in the subnormal range only by one or two places, to precision q < p. A midpoint y of
/// that
///   precision has at most p bits, so when x*y is not 1, |1 - x*y| is at least 2^-2p, and 1/x is
///   relatively farther than 2^-49 from y: `double` keeps it on the right side.
///
/// Needs a build without contraction or fast-math, and a thread that does not flush subnormals.
template <int E, int M>
class Fp {
  static_assert(E >= 3 && E <= 8 && M >= 2 && M <= 23);
  static_assert(std::numeric_limits<float>::is_iec559 && std::numeric_limits<double>::is_iec559);

 public:
  static constexpr int kExpBits = E;
  static constexpr int kFracBits = M;
  static constexpr int kWidth = 1 + E + M;
  static constexpr int kBias = (1 << (E - 1)) - 1;
  static constexpr std::uint32_t kSignBit = std::uint32_t{1} << (E + M);
  static constexpr std::uint32_t kInfBits = ((std::uint32_t{1} << E) - 1) << M;  ///< of +infinity
  static constexpr std::uint32_t kNanBits = kInfBits | (std::uint32_t{1} << (M - 1));

  /// +0.
  constexpr Fp() = default;

  /// The value whose image is the lowest `kWidth` bits of `bits`; those above are ignored.
  [[nodiscard]] static Fp from_bits(std::uint32_t bits) {
    if constexpr (kNative) {
      return Fp(std::bit_cast<float>(bits));
    } else {
      const std::uint32_t magnitude = bits & (kSignBit - 1);
      const std::uint32_t sign = (bits & kSignBit) << (31 - E - M);
      if (magnitude > kInfBits) return Fp(std::numeric_limits<float>::quiet_NaN());
      if (magnitude == kInfBits) return Fp(std::bit_cast<float>(sign | kFloatInf));
      if (E < 8 && magnitude < (std::uint32_t{1} << M)) {
        const float value = static_cast<float>(magnitude) * static_cast<float>(kQuantum);
        return Fp(std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(value)));
      }
      return Fp(std::bit_cast<float>(sign | ((magnitude << (23 - M)) + kRebias)));
    }
  }

  /// `value` rounded to nearest even.
  [[nodiscard]] static Fp from_double(double value) {
    if constexpr (kNative) {
      return Fp(static_cast<float>(value));
    } else {
      return Fp(round(value));
    }
  }

  /// The image in the lowest `kWidth` bits; the canonical quiet NaN for any NaN.
  [[nodiscard]] std::uint32_t bits() const {
    if (is_nan()) return kNanBits;
    const std::uint32_t image = std::bit_cast<std::uint32_t>(value_);
    if constexpr (kNative) {
      return image;
    } else {
      const std::uint32_t sign = (image >> 31) << (E + M);
      const std::uint32_t magnitude = image & 0x7fffffffu;
      if (magnitude == kFloatInf) return sign | kInfBits;
      if (E < 8 && magnitude < kRebias + (std::uint32_t{1} << 23)) {
        const double quanta = std::fabs(static_cast<double>(value_)) * (1.0 / kQuantum);
        return sign | static_cast<std::uint32_t>(quanta);
      }
      return sign | ((magnitude - kRebias) >> (23 - M));
    }
  }

  [[nodiscard]] double to_double() const { return static_cast<double>(value_); }
  [[nodiscard]] float to_float() const { return value_; }

  [[nodiscard]] bool is_nan() const { return value_ != value_; }
  [[nodiscard]] bool is_inf() const { return std::fabs(value_) == kFloatInfinity; }
  [[nodiscard]] bool is_finite() const { return std::fabs(value_) < kFloatInfinity; }
  [[nodiscard]] bool is_zero() const { return value_ == 0.0f; }

  /// The sign bit of `bits()`: true for -0, false for NaN.
  [[nodiscard]] bool signbit() const { return !is_nan() && std::signbit(value_); }

  [[nodiscard]] friend Fp operator+(Fp a, Fp b) {
    if constexpr (kNative) return Fp(a.value_ + b.value_);
    return from_double(a.to_double() + b.to_double());
  }
  [[nodiscard]] friend Fp operator-(Fp a, Fp b) {
    if constexpr (kNative) return Fp(a.value_ - b.value_);
    return from_double(a.to_double() - b.to_double());
  }
  [[nodiscard]] friend Fp operator*(Fp a, Fp b) {
    if constexpr (kNative) return Fp(a.value_ * b.value_);
    return from_double(a.to_double() * b.to_double());
  }
  [[nodiscard]] Fp operator-() const { return Fp(-value_); }

  /// 1 / x correctly rounded; 1/0 and 1/infinity are infinity and 0 with the sign of x.
  [[nodiscard]] friend Fp reciprocal(Fp x) {
    if constexpr (kNative) return Fp(1.0f / x.value_);
    return from_double(1.0 / x.to_double());
  }

  // Values are compared: -0 equals +0, and each comparison with NaN is false.
  [[nodiscard]] friend bool operator<(Fp a, Fp b) { return a.value_ < b.value_; }
  [[nodiscard]] friend bool operator<=(Fp a, Fp b) { return a.value_ <= b.value_; }
  [[nodiscard]] friend bool operator>(Fp a, Fp b) { return a.value_ > b.value_; }
  [[nodiscard]] friend bool operator>=(Fp a, Fp b) { return a.value_ >= b.value_; }
  [[nodiscard]] friend bool operator==(Fp a, Fp b) { return a.value_ == b.value_; }

  /// The value `n` steps farther from zero: magnitude image + n, at most infinity. NaN stays.
  [[nodiscard]] Fp ulps_up(std::uint32_t n) const {
    if (is_nan()) return *this;
    const std::uint32_t image = bits();
    const std::uint32_t magnitude = image & (kSignBit - 1);
    const std::uint32_t moved = n >= kInfBits - magnitude ? kInfBits : magnitude + n;
    return from_bits((image & kSignBit) | moved);
  }

  /// The value `n` steps nearer to zero: magnitude image - n, at least 0; the sign stays. NaN
  /// stays.
  [[nodiscard]] Fp ulps_down(std::uint32_t n) const {
    if (is_nan()) return *this;
    const std::uint32_t image = bits();
    const std::uint32_t magnitude = image & (kSignBit - 1);
    const std::uint32_t moved = n >= magnitude ? 0 : magnitude - n;
    return from_bits((image & kSignBit) | moved);
  }

 private:
  static constexpr bool kNative = E == 8 && M == 23;
  static constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();
  static constexpr std::uint32_t kFloatInf = 0x7f800000u;
  /// What a float image has on top of that of the format, for normal numbers.
  static constexpr std::uint32_t kRebias = static_cast<std::uint32_t>(127 - kBias) << 23;

  /// 2^exponent, exact, for normal doubles.
  static constexpr double pow2(int exponent) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
  }
  static constexpr double kMinNormal = pow2(1 - kBias);
  static constexpr double kQuantum = pow2(1 - kBias - M);  ///< least subnormal

  constexpr explicit Fp(float value) : value_(value) {}

  /// `value` rounded to the format; the float is exact.
  static float round(double value) {
    constexpr int kDropped = 52 - M;
    constexpr std::uint64_t kHalf = std::uint64_t{1} << (kDropped - 1);
    constexpr std::uint64_t kOverflow = static_cast<std::uint64_t>(1023 + kBias + 1) << 52;
    const double magnitude = std::fabs(value);
    if (magnitude < kMinNormal) {
      // In this binade of double one unit is one quantum, so that the addition rounds.
      constexpr double kShift = pow2(52) * kQuantum;
      return static_cast<float>(std::copysign((magnitude + kShift) - kShift, value));
    }
    std::uint64_t image = std::bit_cast<std::uint64_t>(magnitude);
    if (magnitude != magnitude) return std::numeric_limits<float>::quiet_NaN();
    image += kHalf - 1 + ((image >> kDropped) & 1);
    image &= ~((std::uint64_t{1} << kDropped) - 1);
    const double rounded =
        image >= kOverflow ? std::numeric_limits<double>::infinity() : std::bit_cast<double>(image);
    return static_cast<float>(std::copysign(rounded, value));
  }

  float value_ = 0.0f;
};

}  // namespace ti
