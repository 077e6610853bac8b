// SPDX-License-Identifier: Apache-2.0
//
// A board of ordinary files in a folder, until its input ends: board_stand_in FOLDER CONFIG
// [FAULT].
#include "board_stand_in.hpp"

#include <fmt/core.h>

#include <iostream>

#include "engine/session.hpp"

int main(int argc, char** argv) {
  using ti::test::BoardStandIn;
  using Fault = BoardStandIn::Fault;
  const std::map<std::string, BoardStandIn::Options> kinds{
      {"", {}},
      {"dma", {.fault = Fault::RaysUnmapped}},
      {"silent", {.fault = Fault::Silent, .seconds = 2.0}},
      {"version", {.fault = Fault::Version}},
      {"small", {.buffer_bytes = 4096}}};
  const auto found = kinds.find(argc == 4 ? argv[3] : "");
  if (argc < 3 || argc > 4 || found == kinds.end()) return 2;
  BoardStandIn::Options options = found->second;
  options.model = ti::tracer_options_of(ti::load_config(argv[2]));
  const BoardStandIn board(argv[1], options);
  fmt::print("{}\n", board.file().string());
  std::fflush(stdout);
  std::cin.get();
}
