// SPDX-License-Identifier: Apache-2.0
#include "engine/fault_campaign.hpp"

#include <fmt/core.h>

#include <cstdlib>
#include <mutex>
#include <optional>
#include <set>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "engine/lock_step.hpp"

namespace ti {
namespace {

constexpr std::size_t kExamples = 8;

/// The image that the bytes are, or none where a reader with these checks refuses them.
std::optional<Image> read(const std::vector<std::uint8_t>& bytes, ImageCheck check) {
  try {
    return Image(bytes, "damaged", check);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Whether two images are read by the same machine; `load_image_of` refuses others.
bool is_for_the_machine_of(const Image& a, const Image& b) {
  return a.format() == b.format() && a.header().layout == b.header().layout &&
         a.header().test == b.header().test;
}

/// What a step log says of a node: its number.
std::uint32_t node_of(const std::string& line) {
  constexpr std::size_t kWord = 5;  // "node "
  return static_cast<std::uint32_t>(std::strtoul(line.c_str() + kWord, nullptr, 10));
}

/// One image of a campaign, from its fault to what came of it.
class Trial {
 public:
  Trial(const Image& whole, const Tracer& whole_model, const FaultSettings& settings,
        std::uint64_t number)
      : number_(number),
        kind_(static_cast<ImageFault>(number % kImageFaults)),
        rays_(settings.rays(number)) {
    ++count_.images;
    const auto bytes = damaged(whole, kind_, settings.seed + number);
    const std::optional<Image> image = read(bytes, ImageCheck::Places);
    if (!image || !is_for_the_machine_of(*image, whole)) {
      ++count_.refused;
      return;
    }
    const bool sound = read(bytes, ImageCheck::All).has_value();
    count_.sound += sound ? 1 : 0;
    const auto model = Tracer::create(*image, settings.model);
    ModelRun run;
    for (const Ray& ray : rays_) run.hits.push_back(trace(*model, *image, ray, sound, run.work));
    Work ignored;
    for (std::size_t i = 0; i < rays_.size(); ++i)
      count_.changed += whole_model.trace(rays_[i], ignored) == run.hits[i] ? 0 : 1;
    if (settings.engine) compare_with(*settings.engine(*image), run);
  }

  /// Adds what came of it to a campaign.
  void add_to(FaultCampaign& campaign) const {
    campaign.counts[static_cast<std::size_t>(kind_)] += count_;
    for (const std::string& example : examples_)
      if (campaign.examples.size() < kExamples) campaign.examples.push_back(example);
  }

 private:
  HitBits trace(const Tracer& model, const Image& image, const Ray& ray, bool sound, Work& work) {
    if (!unsound_) unsound_ = sound ? std::set<std::uint32_t>{} : unsound_leaves(image);
    bool met = false;
    const Tracer::Log log = [&](const std::string& line) {
      met = met || unsound_->contains(node_of(line));
    };
    const HitBits hit = model.trace(ray, work, unsound_->empty() ? nullptr : &log);
    ++count_.rays;
    count_.memory_errors += hit.status == Status::MemoryError ? 1 : 0;
    count_.watchdogs += hit.status == Status::Watchdog ? 1 : 0;
    if (met && hit.status == Status::Ok) {
      ++count_.silent;
      say("a ray through an unsound leaf says that all is well");
    }
    if (sound && hit.status == Status::MemoryError) {
      ++count_.false_alarm;
      say("a ray says that memory failed, and the image is sound");
    }
    return hit;
  }

  void compare_with(Engine& engine, const ModelRun& run) {
    engine.submit(rays_);
    std::vector<Answer> answers;
    while (answers.size() < rays_.size()) {
      const std::size_t before = answers.size();
      engine.poll(answers, rays_.size() - before);
      if (answers.size() == before) break;
    }
    const Counts counts = engine.counts();
    const LockStep same = compare(run, answers, 0, nullptr, false);
    count_.mismatches += same.mismatches;
    count_.lost += rays_.size() - std::min(answers.size(), rays_.size()) + counts.duplicated;
    for (const std::string& example : same.examples) say(example);
    if (answers.size() != rays_.size()) say("rays are lost");
  }

  void say(const std::string& what) {
    examples_.push_back(fmt::format("image {} ({}): {}", number_,
                                    kImageFaultNames[static_cast<std::size_t>(kind_)], what));
  }

  std::uint64_t number_;
  ImageFault kind_;
  std::vector<Ray> rays_;
  std::optional<std::set<std::uint32_t>> unsound_;
  FaultCount count_;
  std::vector<std::string> examples_;
};

}  // namespace

FaultCount& FaultCount::operator+=(const FaultCount& other) {
  images += other.images;
  refused += other.refused;
  sound += other.sound;
  rays += other.rays;
  changed += other.changed;
  memory_errors += other.memory_errors;
  watchdogs += other.watchdogs;
  silent += other.silent;
  false_alarm += other.false_alarm;
  mismatches += other.mismatches;
  lost += other.lost;
  return *this;
}

bool FaultCount::good() const {
  return silent == 0 && false_alarm == 0 && mismatches == 0 && lost == 0;
}

FaultCount FaultCampaign::sum() const {
  FaultCount sum;
  for (const FaultCount& count : counts) sum += count;
  return sum;
}

FaultCampaign run_faults(const Image& image, const FaultSettings& settings) {
  FaultCampaign campaign;
  const auto model = Tracer::create(image, settings.model);
  std::mutex guard;
  std::uint64_t done = 0;
  const auto some = [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (settings.stop != nullptr && *settings.stop) return;
      const Trial trial(image, *model, settings, settings.first + i);
      const std::lock_guard lock(guard);
      trial.add_to(campaign);
      if (settings.progress) settings.progress(++done);
    }
  };
  if (settings.engine)
    some(0, settings.images);
  else
    parallel_pieces(settings.images, 64, some);
  return campaign;
}

}  // namespace ti
