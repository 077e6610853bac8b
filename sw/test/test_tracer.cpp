// SPDX-License-Identifier: Apache-2.0
// The short stack keeps the newest entries; a tracer is made for what it is built for only, and its
// answers do not depend on the stack or on threads.
#include <doctest/doctest.h>
#include <oneapi/tbb/global_control.h>

#include <deque>
#include <random>
#include <string>
#include <vector>

#include "accel/build.hpp"
#include "model/fp.hpp"
#include "model/tracer.hpp"
#include "model/trv.hpp"
#include "scene/rays.hpp"
#include "support.hpp"
#include "tree_walk.hpp"
#include "truth/truth.hpp"

namespace {

using namespace ti;

TEST_CASE("the short stack keeps the newest entries and remembers that it dropped one") {
  std::mt19937 random(3);
  for (const std::size_t depth : {1U, 2U, 3U, 4U, 63U, 64U}) {
    CAPTURE(depth);
    model::ShortStack<Fp<8, 23>> stack(depth);
    std::deque<std::uint32_t> right;
    bool dropped = false;
    for (std::uint32_t i = 0; i < 5000; ++i) {
      REQUIRE(stack.empty() == right.empty());
      REQUIRE(stack.dropped() == dropped);
      if (right.empty() || random() % 8 < (i / 500 % 2 == 0 ? 5U : 3U)) {
        stack.push({i, Fp<8, 23>::from_double(0), Fp<8, 23>::from_double(i)});
        right.push_back(i);
        if (right.size() > depth) {
          right.pop_front();
          dropped = true;
        }
      } else {
        const auto top = stack.pop();
        REQUIRE(top.node == right.back());
        REQUIRE(top.tmax.to_double() == right.back());
        right.pop_back();
      }
      if (i % 97 == 0) {
        stack.forget_dropped();
        dropped = false;
      }
    }
  }
}

TEST_CASE("the model refuses a stack that it has no room for") {
  BuildStats stats;
  const Image image = build_image(soup(10, 0.5F, 1), {}, stats);
  for (const int depth : {-1, 65, 1 << 20}) {
    test::check_error([&] { (void)Tracer::create(image, {.stack_depth = depth}); },
                      {std::to_string(depth) + " entries:", "0 to 64"});
  }
}

TEST_CASE("the model takes every format in every mode, and exact arithmetic explains its hits") {
  const Mesh mesh = soup(500, 0.2F, 4);
  const auto rays = inside_rays(mesh, 2000, 2);
  for (const auto& [e, m] : {std::pair{8, 23}, std::pair{6, 12}, std::pair{5, 10}}) {
    for (const bool toward_zero : {false, true}) {
      for (const bool flush : {false, true}) {
        BuildOptions options;
        options.format = {e, m, {.toward_zero = toward_zero, .flush = flush}};
        CAPTURE(name_of(options.format));
        BuildStats stats;
        const Image image = build_image(mesh, options, stats);
        CHECK(image.format() == options.format);
        const auto tracer = Tracer::create(image, {});
        Work work;
        std::vector<Hit> hits;
        for (const HitBits& bits : tracer->trace(rays, work))
          hits.push_back(hit_of(image.format(), bits));
        const TruthReport report = Truth(mesh, options.format).compare(rays, hits);
        CHECK(report.unexplained == 0);
        CHECK(report.agree > rays.size() / 2);
      }
    }
  }
}

TEST_CASE(
    "hits are the same for every depth of the stack, work and hits for every number of threads") {
  const Mesh mesh = soup(3000, 0.1F, 4);
  BuildStats stats;
  const Image image = build_image(mesh, {}, stats);
  const auto rays = inside_rays(mesh, 5000, 2);
  std::vector<HitBits> first;
  for (const int depth : {0, 1, 2, 4, 64}) {
    const auto tracer = Tracer::create(image, {.stack_depth = depth});
    Work work;
    std::vector<HitBits> hits = tracer->trace(rays, work);
    {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
      Work again;
      CHECK(tracer->trace(rays, again) == hits);
      CHECK(again == work);
    }
    CHECK((work.restarts > 0) == (depth < 64));
    for (HitBits& hit : hits) hit.steps = 0;  // restarts visit nodes again
    if (first.empty()) first = hits;
    CHECK(hits == first);
  }
}

TEST_CASE("without early exit each test takes three passes, and hits and steps are the same") {
  const Mesh mesh = soup(3000, 0.1F, 4);
  BuildStats stats;
  const Image image = build_image(mesh, {}, stats);
  const auto rays = inside_rays(mesh, 5000, 2);
  Work early;
  Work whole;
  CHECK(Tracer::create(image, {.early_exit = false})->trace(rays, whole) ==
        Tracer::create(image, {})->trace(rays, early));
  CHECK(early.c_tests < early.b_tests);
  CHECK(early.b_tests < early.a_tests);
  CHECK(whole.a_tests == early.a_tests);
  CHECK(whole.b_tests == whole.a_tests);
  CHECK(whole.c_tests == whole.a_tests);
  CHECK(whole.steps == early.steps);
}

}  // namespace
