// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <string>
#include <string_view>

namespace ti {

/// What a picture may call for beside its primary rays.
enum class Effect : std::size_t {
  Shadows,          ///< of lights without an area
  SoftShadows,      ///< of emissive triangles
  Interreflection,  ///< light that comes from matt surfaces or the background
  Glossy,
  Mirror,
  Glass,
  Lens,              ///< depth of field
  Roulette,          ///< dim paths end at random, and those that go on count for more
  AmbientOcclusion,  ///< an integrator of its own
  Motion,            ///< what differs from frame to frame
  DimPaths,          ///< paths that cannot add a step of the output any more
};
constexpr std::size_t kEffects = 11;

using EffectSet = std::bitset<kEffects>;

[[nodiscard]] std::string_view name_of(Effect effect);

/// What `EFFECTS=` asks for.
///
/// `auto`, `all` or `none`, then effects with + or - (`auto-glossy`, `none+shadows+mirror`); or the
/// name of one effect (`ao`), which stands for `none` and that one.
struct EffectRequest {
  enum class Base { Auto, All, None };
  Base base = Base::Auto;
  EffectSet added;
  EffectSet removed;

  /// Throws `Error` for a word that is none of these.
  [[nodiscard]] static EffectRequest of(const std::string& text);
};

}  // namespace ti
