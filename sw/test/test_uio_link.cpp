// SPDX-License-Identifier: Apache-2.0
// Through the devices of a board the driver gets each ray its hit, and each failure of them is one
// sentence.
#include <doctest/doctest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "accel/build.hpp"
#include "board_stand_in.hpp"
#include "host/device.hpp"
#include "host/uio_link.hpp"
#include "scene/rays.hpp"
#include "support.hpp"
#include "tree_walk.hpp"

namespace ti {
namespace {

using host::load_board;
using host::UioLink;
using test::BoardStandIn;
using Fault = BoardStandIn::Fault;

struct Scene {
  Mesh mesh = soup(40, 0.5F, 1);
  BuildStats stats;
  Image image = build_image(mesh, {}, stats);
  std::vector<Ray> rays = random_rays(mesh, 101, 3);
};

/// Loads and traces the scene on a board; its hits.
std::vector<HitBits> traced(const BoardStandIn& board, const Scene& scene,
                            std::span<const Ray> rays) {
  UioLink link(load_board(board.file()));
  host::Device device(link);
  device.load(scene.image);
  return device.trace(rays);
}

TEST_CASE("board: every ray gets its hit, packet after packet, on any number of streams") {
  const Scene scene;
  const auto model = Tracer::create(scene.image, {});
  for (const int streams : {1, 3}) {
    CAPTURE(streams);
    const test::TempDir folder;
    const BoardStandIn board(folder / "board", {.streams = streams});
    UioLink link(load_board(board.file()));
    host::Device device(link);
    device.load(scene.image);
    for (const std::size_t count : {1U, 2U, 101U}) {
      std::vector<Ray> rays(scene.rays.begin(),
                            scene.rays.begin() + static_cast<std::ptrdiff_t>(count));
      for (Ray& ray : rays) ray.any = count == 2;
      Work work;
      CHECK(device.trace(rays) == model->trace(rays, work));
    }
  }
}

TEST_CASE("board: a scene takes the place of another") {
  const Scene scene;
  const test::TempDir folder;
  const BoardStandIn board(folder / "board", {});
  const Mesh mesh = soup(20, 0.4F, 2);
  BuildStats stats;
  const Image other = build_image(mesh, {}, stats);
  UioLink link(load_board(board.file()));
  host::Device device(link);
  for (const Image* image : {&scene.image, &other, &scene.image}) {
    device.load(*image);
    Work work;
    CHECK(device.trace(scene.rays) == Tracer::create(*image, {})->trace(scene.rays, work));
  }
}

TEST_CASE("board: what goes wrong on it is one sentence") {
  const Scene scene;
  const std::uint64_t scene_bytes = scene.image.bytes().size();
  struct Case {
    BoardStandIn::Options options;
    std::vector<std::string> words;
  };
  const std::vector<Case> cases{
      {{.fault = Fault::RaysUnmapped}, {"uio1: the DMA of the rays stops", "MM2S_DMASR"}},
      {{.fault = Fault::HitsRefused}, {"the DMA of the hits stops", "S2MM_DMASR is 00000021"}},
      {{.fault = Fault::Silent, .seconds = 2.0}, {"uio1: the hits do not come"}},
      {{.fault = Fault::Deaf, .seconds = 0.05}, {"uio1: its reset does not end"}},
      {{.fault = Fault::Version}, {"registers of version 2"}},
      {{.buffer_bytes = 1024}, {"udmabuf0: the buffer has 1024 bytes", "the scene"}},
      {{.buffer_bytes = scene_bytes + 4096}, {"udmabuf0: the buffer", "scene, rays and hits"}},
      {{.length_bits = 8}, {"a transfer of 3232 bytes is longer than the 255"}}};
  for (const auto& [options, words] : cases) {
    const test::TempDir folder;
    const BoardStandIn board(folder / "board", options);
    test::check_error([&] { (void)traced(board, scene, scene.rays); }, words);
  }
}

TEST_CASE("board: it goes on after an error") {
  const Scene scene;
  const test::TempDir folder;
  const BoardStandIn board(folder / "board", {.length_bits = 10});
  UioLink link(load_board(board.file()));
  host::Device device(link);
  device.load(scene.image);
  test::check_error([&] { (void)device.trace(scene.rays); }, {"longer than the 1023"});
  const std::span<const Ray> few(scene.rays.data(), 20);
  Work work;
  CHECK(device.trace(few) == Tracer::create(scene.image, {})->trace(few, work));
}

TEST_CASE("board: a board without a DMA for each stream is refused") {
  const Scene scene;
  const test::TempDir folder;
  const BoardStandIn stand_in(folder / "board", {.streams = 3});
  host::Board board = load_board(stand_in.file());
  board.dma.pop_back();
  UioLink link(board);
  host::Device device(link);
  device.load(scene.image);
  test::check_error([&] { (void)device.trace(scene.rays); }, {"3 streams", "2 DMAs"});
}

TEST_CASE("board: a board file that says nonsense, or names what is not there, is refused") {
  const std::map<std::string, std::vector<std::string>> files{
      {"[]", {"no JSON object"}},
      {"{\"registers\": \"a\", \"dma\": [\"b\"]}", {"buffer", "missing"}},
      {"{\"register\": \"a\"}", {"no key register"}},
      {"{\"dma\": \"a\"}", {"dma is \"a\""}},
      {"{\"registers\": \"a\", \"dma\": [\"b\"], \"buffer\": \"c\", \"length_bits\": 99}",
       {"length_bits 99"}},
      {"{\"registers\": \"/dev/uio77\", \"dma\": [\"b\"], \"buffer\": \"c\"}",
       {"/dev/uio77: there is no such device of uio", "uio77/maps/map0/size"}}};
  const test::TempDir folder;
  for (const auto& [text, words] : files) {
    const std::filesystem::path file = folder.file("board.json", text);
    test::check_error([&] { UioLink link(load_board(file)); }, words);
  }
}

/// A socket in the place of a UIO device's descriptor, which a file in its place has not: each word
/// that arms the interrupt is answered by one.
class Interrupts {
 public:
  explicit Interrupts(const std::filesystem::path& device) {
    REQUIRE(socketpair(AF_UNIX, SOCK_STREAM, 0, ends_.data()) == 0);
    std::vector<int> descriptors;
    for (const auto& link : std::filesystem::directory_iterator("/proc/self/fd")) {
      std::error_code gone;
      if (std::filesystem::read_symlink(link.path(), gone) == device)
        descriptors.push_back(std::stoi(link.path().filename()));
    }
    REQUIRE(!descriptors.empty());
    for (const int descriptor : descriptors) dup2(ends_[0], descriptor);
    kernel_ = std::thread([this] {
      for (std::uint32_t word = 0; read(ends_[1], &word, sizeof word) == sizeof word;) {
        ++armed_;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (write(ends_[1], &word, sizeof word) != sizeof word) return;
      }
    });
  }
  ~Interrupts() {
    if (kernel_.joinable()) (void)armed();
    for (const int end : ends_) close(end);
  }
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;

  /// How often it was armed; none comes any more.
  int armed() {
    shutdown(ends_[0], SHUT_WR);
    kernel_.join();
    return armed_;
  }

 private:
  std::array<int, 2> ends_{};
  int armed_ = 0;  // of the thread, until it ends
  std::thread kernel_;
};

TEST_CASE("board: hits are waited for by the interrupt of their DMA, armed for each packet") {
  const Scene scene;
  const test::TempDir folder;
  const BoardStandIn stand_in(folder / "board", {});
  host::Board board = load_board(stand_in.file());
  board.interrupts = true;
  UioLink link(board);
  Interrupts interrupts(folder / "board" / "uio1");
  host::Device device(link);
  device.load(scene.image);
  constexpr int kPackets = 3;
  for (int packet = 0; packet < kPackets; ++packet) {
    Work work;
    CHECK(device.trace(scene.rays) == Tracer::create(scene.image, {})->trace(scene.rays, work));
  }
  CHECK(interrupts.armed() >= kPackets);
}

TEST_CASE("board: a device that does not open, and an offset beyond it, are sentences") {
  const test::TempDir folder;
  test::check_error([&] { host::MappedDevice none(folder / "uio0", 64); }, {"cannot be opened"});
  host::MappedDevice device(folder.file("uio1", std::string(64, '\0')), 64);
  for (const std::uint64_t offset : {64U, 2U})
    test::check_error([&] { (void)device.read(offset); }, {"it has 64 bytes"});
  device.write(60, std::span<const std::uint8_t>(std::array<std::uint8_t, 3>{1, 2, 3}));
  CHECK(device.read(60) == 0x00030201);
}

TEST_CASE("board: an interrupt is armed by a word written, and awaited by one read") {
  std::array<int, 2> ends{};
  REQUIRE(socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) == 0);
  using std::chrono::milliseconds;
  std::uint32_t word = 0;
  CHECK(host::arm_interrupt(ends[0]));
  REQUIRE(read(ends[1], &word, sizeof word) == sizeof word);
  CHECK(word == 1);
  CHECK_FALSE(host::await_interrupt(ends[0], milliseconds(1)));
  REQUIRE(write(ends[1], &word, sizeof word) == sizeof word);
  CHECK(host::await_interrupt(ends[0], milliseconds(1000)));
  CHECK_FALSE(host::arm_interrupt(-1));
  for (const int end : ends) close(end);
}

}  // namespace
}  // namespace ti
