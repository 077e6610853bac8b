// SPDX-License-Identifier: Apache-2.0
//
// The DRAM answers every request once, like any memory, and takes the time of gddr3.ini.
#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include "dram/dram_memory.hpp"

namespace ti::sim {
namespace {

constexpr std::uint64_t kLine = 64;
constexpr std::uint64_t kRow = 32768;  // of all channels: 8 times 4 KB
const std::vector<std::uint8_t> kImage = [] {
  std::vector<std::uint8_t> bytes(std::size_t{1} << 23U);
  std::mt19937 random(1);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}();

/// Lines of one bank of one channel, each in another row than the 31 before it.
std::uint64_t of_one_bank(std::uint64_t i) { return i % 32 * 8 * kRow + i / 32 % 64 * 8 * kLine; }

struct Got {
  std::uint64_t cycle;
  int port;
  Memory::Answer answer;
};

/// A memory and the cycles of an engine beside it.
class Bench {
 public:
  explicit Bench(const DramSettings& settings = {})
      : memory(make_dram_memory(kImage, settings)), ports_(settings.ports) {}

  /// A cycle of the engine, whose ports take all answers.
  void cycle() {
    memory->tick();
    ++now;
    for (int port = 0; port < ports_; ++port) {
      if (const auto answer = memory->answer(port)) got.push_back({now, port, *answer});
    }
  }
  /// Waits until the port can take the request; the cycle in which it did.
  std::uint64_t ask(int port, std::uint32_t id, std::uint64_t offset) {
    while (!memory->ready(port)) cycle();
    memory->request(port, id, Memory::kBase + offset);
    return now;
  }
  /// Cycles until as many answers are there.
  std::uint64_t wait(std::size_t answers) {
    const std::uint64_t start = now;
    while (got.size() < answers && now < start + 1'000'000) cycle();
    return now - start;
  }
  /// Cycles of one request in an idle memory.
  std::uint64_t latency(std::uint64_t offset) {
    ask(0, 0, offset);
    return wait(got.size() + 1);
  }

  std::unique_ptr<Memory> memory;
  std::uint64_t now = 0;
  std::vector<Got> got;

 private:
  int ports_;
};

/// Requests of all ports to random lines of the first `lines`, a request a port and cycle.
Bench random_traffic(const DramSettings& settings, int requests, std::uint64_t lines) {
  Bench bench(settings);
  std::mt19937_64 random(7);
  for (int i = 0; i < requests; ++i) {
    for (int port = 0; port < settings.ports; ++port) {
      if (!bench.memory->ready(port)) continue;
      const std::uint64_t line = random() % lines;
      bench.memory->request(port, static_cast<std::uint32_t>(i),
                            Memory::kBase + line * static_cast<std::uint64_t>(settings.line_bytes));
    }
    bench.cycle();
  }
  bench.wait(bench.memory->bytes() / static_cast<std::uint64_t>(settings.line_bytes));
  return bench;
}

TEST_CASE("every request is answered once, at its port, with its line") {
  for (const int line_bytes : {32, 64, 128}) {
    for (const std::uint64_t lines : {std::uint64_t{3}, std::uint64_t{4096}}) {
      for (const std::uint64_t shuffle : {std::uint64_t{0}, std::uint64_t{5}}) {
        CAPTURE(line_bytes);
        CAPTURE(lines);
        CAPTURE(shuffle);
        Bench bench({.ports = 3, .line_bytes = line_bytes, .shuffle_seed = shuffle});
        std::mt19937_64 random(3);
        std::map<std::pair<int, std::uint32_t>, std::uint64_t> asked;
        for (std::uint32_t id = 0; id < 2000; ++id) {
          const int port = static_cast<int>(random() % 3);
          const std::uint64_t offset = random() % lines * static_cast<std::uint64_t>(line_bytes);
          bench.ask(port, id, offset);
          asked[{port, id}] = offset;
          if (random() % 4 == 0) bench.cycle();
        }
        bench.wait(2000);
        for (int i = 0; i < 5000; ++i) bench.cycle();  // nothing may follow
        REQUIRE(bench.got.size() == 2000);
        for (const Got& got : bench.got) {
          const auto found = asked.find({got.port, got.answer.id});
          REQUIRE(found != asked.end());
          REQUIRE(got.answer.address == Memory::kBase + found->second);
          REQUIRE(!got.answer.error);
          std::vector<std::uint32_t> words(static_cast<std::size_t>(line_bytes) / 4);
          bench.memory->read(got.answer, words.data());
          std::uint32_t first = 0;
          for (int b = 3; b >= 0; --b)
            first = first << 8U | kImage[found->second + static_cast<std::size_t>(b)];
          REQUIRE(words[0] == first);
          asked.erase(found);
        }
        REQUIRE(asked.empty());
        REQUIRE(bench.memory->bytes() == 2000 * static_cast<std::uint64_t>(line_bytes));
      }
    }
  }
}

TEST_CASE("requests for one line are all answered, in their order, and share its read") {
  Bench bench({.ports = 2});
  for (std::uint32_t id = 0; id < 6; ++id) bench.ask(static_cast<int>(id % 2), id, 640);
  bench.wait(6);
  for (int i = 0; i < 2000; ++i) bench.cycle();

  REQUIRE(bench.got.size() == 6);
  for (int port = 0; port < 2; ++port) {
    std::vector<std::uint32_t> ids;
    for (const Got& got : bench.got) {
      if (got.port == port) ids.push_back(got.answer.id);
    }
    CHECK(std::is_sorted(ids.begin(), ids.end()));
    CHECK(ids.size() == 3);
  }
  CHECK(bench.memory->dram()->answers == 6);
  CHECK(bench.memory->dram()->reads < 6);
  // One that comes later reads again.
  const std::uint64_t reads = bench.memory->dram()->reads;
  bench.latency(640);
  CHECK(bench.memory->dram()->reads == reads + 1);
}

TEST_CASE("lines outside of the image are errors, and no read") {
  Bench bench;
  bench.ask(0, 1, kImage.size());
  bench.ask(0, 2, kImage.size() - kLine);
  bench.ask(0, 3, std::uint64_t{1} << 40U);
  bench.ask(0, 4, -std::uint64_t{4096});
  bench.wait(4);

  REQUIRE(bench.got.size() == 4);
  for (const Got& got : bench.got) CHECK(got.answer.error == (got.answer.id != 2));
  CHECK(bench.memory->dram()->reads == 1);
}

TEST_CASE("each n-th line is an error when the settings say so") {
  Bench bench({.error_every = 3});
  for (std::uint32_t id = 1; id <= 9; ++id) bench.ask(0, id, 64 * id);
  bench.wait(9);

  for (const Got& got : bench.got) CHECK(got.answer.error == (got.answer.id % 3 == 0));
}

TEST_CASE("a full channel holds its port back, and its port alone") {
  Bench bench({.ports = 2});
  int taken = 0;
  while (bench.memory->ready(0)) {
    bench.memory->request(0, static_cast<std::uint32_t>(taken), Memory::kBase);
    ++taken;
  }
  CHECK(taken == kPortQueue);
  std::uint64_t waits = 0;
  std::uint32_t id = 0;
  for (int i = 0; i < 400; ++i) {
    if (bench.memory->ready(0)) {
      ++id;
      bench.memory->request(0, id, Memory::kBase + of_one_bank(id));
    } else {
      ++waits;
    }
    bench.cycle();
  }
  CHECK(waits > 300);
  CHECK(bench.memory->ready(1));
  const std::uint64_t start = bench.ask(1, 77, kLine);
  while (std::none_of(bench.got.begin(), bench.got.end(),
                      [](const Got& got) { return got.port == 1; }))
    bench.cycle();
  CHECK(bench.now - start < 40);
  bench.wait(bench.memory->bytes() / kLine);
  CHECK(bench.got.size() == bench.memory->bytes() / kLine);
}

TEST_CASE("ports that want one channel get equal shares of it") {
  Bench bench({.ports = 4});
  std::vector<std::uint64_t> answers(4);
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    for (int port = 0; port < 4; ++port) {
      if (bench.memory->ready(port))
        bench.memory->request(port, i, Memory::kBase + 8 * kLine * ((4 * i + port) % 4096));
    }
    bench.cycle();
  }
  for (const Got& got : bench.got) ++answers[static_cast<std::size_t>(got.port)];
  const auto [least, most] = std::minmax_element(answers.begin(), answers.end());
  CHECK(*least > 0.9 * static_cast<double>(*most));
}

TEST_CASE("a row that is open is read sooner than one that has to be opened, or closed first") {
  Bench bench;
  const std::uint64_t closed = bench.latency(0);
  const std::uint64_t hit = bench.latency(8 * kLine);  // the next line of the channel
  const std::uint64_t miss = bench.latency(8 * kRow);  // another row of its bank

  // CL and the burst are 14 ns, tRCD 12, tRP 10; in cycles of 2 ns, and up to 4 of hand-over.
  CHECK(hit >= 7);
  CHECK(hit <= 11);
  CHECK(closed >= hit + 5);
  CHECK(closed <= hit + 7);
  CHECK(miss >= closed + 4);
  CHECK(miss <= closed + 6);
  CHECK(bench.memory->dram()->reads == 3);
  CHECK(bench.memory->dram()->row_hits == 1);
}

/// GB/s of the lines at these offsets, as fast as the ports take them.
double bandwidth(int line_bytes, const std::function<std::uint64_t(std::uint64_t)>& offset) {
  constexpr int kPorts = 8;
  constexpr std::uint64_t kCycles = 20'000;
  Bench bench({.ports = kPorts, .line_bytes = line_bytes});
  std::uint64_t next = 0;
  while (bench.now < kCycles) {
    for (int port = 0; port < kPorts; ++port) {
      if (!bench.memory->ready(port)) continue;
      bench.memory->request(port, 0, Memory::kBase + offset(next++) % kImage.size());
    }
    bench.cycle();
  }
  const double bytes = static_cast<double>(bench.got.size()) * line_bytes;
  return bytes / (2.0 * static_cast<double>(kCycles));  // of 2 ns
}

TEST_CASE("a stream comes with almost 128 GB/s, whatever the size of lines, and never more") {
  for (const int line_bytes : {32, 64, 128}) {
    CAPTURE(line_bytes);
    const double stream = bandwidth(line_bytes, [line_bytes](std::uint64_t i) {
      return i * static_cast<std::uint64_t>(line_bytes);
    });
    MESSAGE("GB/s of a stream of " << line_bytes << " bytes a line: " << stream);
    CHECK(stream <= 128.0);
    // Eight ports of an engine at 500 MHz ask for 4 lines a ns.
    CHECK(stream > 0.9 * 128.0);
  }
}

TEST_CASE("one channel gives an eighth of it, and rows of one bank far less") {
  const double channel = bandwidth(64, [](std::uint64_t i) { return i * 8 * kLine; });
  CHECK(channel <= 16.0);
  CHECK(channel > 0.85 * 16.0);
  const double bank = bandwidth(64, of_one_bank);
  CHECK(bank < 64.0 / 35.0 + 0.01);  // a line each tRC
  CHECK(bank > 0.85 * 64.0 / 35.0);
}

TEST_CASE("refreshes come every 3.9 us in each channel, with and without work") {
  Bench idle;
  for (int i = 0; i < 39'000; ++i) idle.cycle();
  CHECK(idle.memory->dram()->cycles == 78'000);
  CHECK(idle.memory->dram()->refreshes >= 8 * 19);
  CHECK(idle.memory->dram()->refreshes <= 8 * 20);
  const Bench busy = random_traffic({.ports = 4}, 39'000, 131'072);
  const DramCounts counts = *busy.memory->dram();
  const std::uint64_t due = 8 * (counts.cycles / 3900);
  CHECK(counts.refreshes >= due - 16);
  CHECK(counts.refreshes <= due);
}

TEST_CASE("the counts fit one another and what was seen from outside") {
  const Bench bench = random_traffic({.ports = 4}, 20'000, 131'072);
  const DramCounts counts = *bench.memory->dram();
  CHECK(counts.cycles == 2 * bench.now);
  CHECK(counts.answers == bench.got.size());
  CHECK(counts.reads <= counts.answers);
  CHECK(counts.bytes == kLine * counts.reads);
  CHECK(counts.row_hits < counts.reads);
  // Little's law: requests in the channels, and before them those in the queues of the ports.
  CHECK(counts.queued < counts.waited);
  CHECK(counts.queued > 0);
}

TEST_CASE("the same requests take the same cycles") {
  const DramSettings settings{.ports = 4, .shuffle_seed = 9};
  const Bench a = random_traffic(settings, 5000, 65'536);
  const Bench b = random_traffic(settings, 5000, 65'536);
  REQUIRE(a.got.size() == b.got.size());
  for (std::size_t i = 0; i < a.got.size(); ++i) {
    REQUIRE(a.got[i].cycle == b.got[i].cycle);
    REQUIRE(a.got[i].answer.id == b.got[i].answer.id);
  }
}

TEST_CASE("the clock of the engine changes the cycles, and not the time") {
  Bench slow({.clock_mhz = 250});
  Bench fast({.clock_mhz = 1000});
  Bench odd({.clock_mhz = 600});
  const std::uint64_t quarter = slow.latency(0);
  const std::uint64_t one = fast.latency(0);
  CHECK(4 * quarter >= one);
  CHECK(4 * (quarter - 1) <= one);
  for (int i = 0; i < 6000; ++i) odd.cycle();
  CHECK(odd.memory->dram()->cycles == doctest::Approx(10'000).epsilon(0.001));
}

}  // namespace
}  // namespace ti::sim
