// SPDX-License-Identifier: Apache-2.0
#include "host/host_engine.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "host/uio_link.hpp"

namespace ti::host {

HostEngine::HostEngine(std::unique_ptr<Link> link, const Image& image,
                       std::function<void(std::uint64_t, std::uint64_t)> progress)
    : link_(std::move(link)),
      device_(*link_),
      format_(image.format()),
      progress_(std::move(progress)) {
  device_.load(image);
}

void HostEngine::submit(std::span<const Ray> rays) {
  queue_.insert(queue_.end(), rays.begin(), rays.end());
}

std::size_t HostEngine::cancel() {
  const std::size_t n = queue_.size();
  queue_.clear();
  return n;
}

void HostEngine::poll(std::vector<Answer>& answers, std::size_t least) {
  constexpr std::size_t kMost = 65'536;  // rays of a packet: enough that draining it costs little
  const auto begin = std::chrono::steady_clock::now();
  const std::size_t enough = answers.size() + std::max<std::size_t>(least, 1);
  while (answers.size() < enough && !queue_.empty()) {
    const bool any = queue_.front().any;
    const auto most = static_cast<std::ptrdiff_t>(std::min(queue_.size(), kMost));
    const auto end = std::find_if(queue_.begin(), queue_.begin() + most,
                                  [any](const Ray& ray) { return ray.any != any; });
    const std::vector<Ray> rays(queue_.begin(), end);
    queue_.erase(queue_.begin(), end);
    for (const HitBits& hit : device_.trace(rays))
      answers.push_back({counts_.rays++, hit, hit.prim >= 0, cycle()});
    if (progress_) progress_(counts_.rays, cycle());
  }
  counts_.seconds +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::unique_ptr<Engine> make_board_engine(const std::filesystem::path& board, const Image& image) {
  return std::make_unique<HostEngine>(std::make_unique<UioLink>(load_board(board)), image, nullptr);
}

}  // namespace ti::host
