// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include "cli/summary.hpp"
#include "cli/traced_run.hpp"
#include "io/file.hpp"

namespace ti {

int image(Arguments& arguments) {
  const std::filesystem::path& file = arguments.run.out;
  check_folder(file.parent_path());
  arguments.run.engine = EngineKind::Model;
  arguments.run.truth = false;
  const Session session(arguments.run, load(arguments));
  session.require_triangles();
  print_tree(session);
  const auto bytes = session.image().bytes();
  write_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  fmt::print("{}: {} bytes\n", file.string(), bytes.size());
  return kGood;
}

}  // namespace ti
