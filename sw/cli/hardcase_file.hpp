// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmpxx.h>

#include <optional>
#include <string>
#include <string_view>

#include "cli/hardcases.hpp"

namespace ti {

/// The number that `text` writes as an integer, a fraction "a/b" or a decimal "1.25", with an
/// optional sign; none for other text.
[[nodiscard]] std::optional<mpq_class> parse_rational(const std::string& text);

/// The word for `rule` in a file of cases.
[[nodiscard]] std::string_view rule_name(CaseRule rule);

}  // namespace ti
