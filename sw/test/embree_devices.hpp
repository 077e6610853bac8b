// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "truth/embree.hpp"

namespace ti::test {

/// Embree as it chooses for itself, then with each instruction set that this processor has: its
/// last bits differ between them, the truth must not.
inline const std::vector<std::string>& embree_devices() {
  static const std::vector<std::string> devices = [] {
    std::vector<std::string> all = EmbreeScene::devices();
    all.insert(all.begin(), "");
    return all;
  }();
  return devices;
}

/// One of `embree_devices()`; the test case around it runs once for each.
inline std::string each_embree_device() {
  std::string chosen;
  for (const std::string& device : embree_devices()) {
    SUBCASE((device.empty() ? "Embree's choice" : device.c_str())) { chosen = device; }
  }
  return chosen;
}

}  // namespace ti::test
