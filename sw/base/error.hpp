// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace ti {

/// Bad input from outside: one sentence that names the file, the place and the cure.
///
/// `main` prints it and exits with status 2; nothing else exits with that status.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace ti
