// SPDX-License-Identifier: Apache-2.0
#include "engine/engine.hpp"

namespace ti {
namespace {

class ModelEngine final : public Engine {
 public:
  explicit ModelEngine(const Tracer& model) : model_(model) {}

  [[nodiscard]] EngineResult trace(std::span<const Ray> rays) override {
    EngineResult result;
    result.hits = model_.trace(rays, result.work);
    return result;
  }

 private:
  const Tracer& model_;
};

}  // namespace

std::unique_ptr<Engine> make_model_engine(const Tracer& model) {
  return std::make_unique<ModelEngine>(model);
}

}  // namespace ti
