// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <deque>

#include "engine/engine.hpp"
#include "truth/truth.hpp"

namespace ti {
namespace {

/// An engine that answers each block of rays at once, in order.
class BlockEngine : public Engine {
 public:
  void submit(std::span<const Ray> rays) override {
    queue_.insert(queue_.end(), rays.begin(), rays.end());
  }

  void poll(std::vector<Answer>& answers, std::size_t least) override {
    constexpr std::size_t kBlock = 16384;
    const auto begin = std::chrono::steady_clock::now();
    std::size_t came = 0;
    while (!queue_.empty() && came < std::max<std::size_t>(least, 1)) {
      const std::size_t n = std::min(kBlock, queue_.size());
      const std::vector<Ray> block(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(n));
      queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(n));
      for (const HitBits& hit : trace(block, counts_.work))
        answers.push_back({counts_.rays++, hit, hit.prim >= 0});
      came += n;
    }
    counts_.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  std::size_t cancel() override {
    const std::size_t n = queue_.size();
    queue_.clear();
    return n;
  }

  [[nodiscard]] Counts counts() override { return counts_; }

 private:
  virtual std::vector<HitBits> trace(std::span<const Ray> rays, Work& work) = 0;

  std::deque<Ray> queue_;
  Counts counts_;
};

class ModelEngine final : public BlockEngine {
 public:
  ModelEngine(const Tracer& model, Format format) : model_(model), format_(format) {}
  [[nodiscard]] Format format() const override { return format_; }

 private:
  std::vector<HitBits> trace(std::span<const Ray> rays, Work& work) override {
    return model_.trace(rays, work);
  }

  const Tracer& model_;
  Format format_;
};

class EmbreeEngine final : public BlockEngine {
 public:
  explicit EmbreeEngine(const Truth& truth) : truth_(truth) {}
  [[nodiscard]] Format format() const override { return {}; }

 private:
  std::vector<HitBits> trace(std::span<const Ray> rays, Work& /*work*/) override {
    std::vector<HitBits> bits;
    bits.reserve(rays.size());
    for (const Hit& hit : truth_.trace(rays)) {
      const auto of = [](float value) { return round_to_bits(Format{}, value); };
      bits.push_back({of(hit.t), of(hit.u), of(hit.v), hit.prim, hit.status, hit.steps});
    }
    return bits;
  }

  const Truth& truth_;
};

}  // namespace

std::unique_ptr<Engine> make_model_engine(const Tracer& model, Format format) {
  return std::make_unique<ModelEngine>(model, format);
}

std::unique_ptr<Engine> make_embree_engine(const Truth& truth) {
  return std::make_unique<EmbreeEngine>(truth);
}

}  // namespace ti
