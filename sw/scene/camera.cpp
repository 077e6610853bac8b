// SPDX-License-Identifier: Apache-2.0
#include "scene/camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/error.hpp"
#include "base/limits.hpp"

namespace ti {

namespace {

/// The even bits of a Morton code, packed.
std::uint32_t even_bits(std::uint32_t code) {
  code &= 0x55555555U;
  code = (code | code >> 1) & 0x33333333U;
  code = (code | code >> 2) & 0x0F0F0F0FU;
  code = (code | code >> 4) & 0x00FF00FFU;
  return (code | code >> 8) & 0x0000FFFFU;
}

std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 8) & 0x00FF00FFU;
  x = (x | x << 4) & 0x0F0F0F0FU;
  x = (x | x << 2) & 0x33333333U;
  return (x | x << 1) & 0x55555555U;
}

/// Unit vector to the right of `forward`.
glm::dvec3 right_of(const glm::dvec3& forward, const glm::dvec3& up) {
  const glm::dvec3 right = glm::cross(forward, up);
  if (glm::length(right) > 1e-6 * glm::length(up)) return glm::normalize(right);
  // `up` is zero or along the view: take the coordinate axis that is the least along it.
  const glm::dvec3 a = glm::abs(forward);
  const glm::dvec3 axis = a.x <= a.y && a.x <= a.z ? glm::dvec3(1, 0, 0)
                          : a.y <= a.z             ? glm::dvec3(0, 1, 0)
                                                   : glm::dvec3(0, 0, 1);
  return glm::normalize(glm::cross(forward, axis));
}

}  // namespace

CameraRays::CameraRays(const Camera& camera, int width, int height)
    : eye_(camera.eye), size_(width, height), radius_(0.5 * camera.aperture) {
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    throw Error(fmt::format("a picture of {}x{} is not possible; choose 1 to {} a side", width,
                            height, kMaxSide));
  }
  const glm::dvec3 view = glm::dvec3(camera.target) - eye_;
  const double distance = glm::length(view);
  if (!(distance > 0.0) || !std::isfinite(distance)) {
    throw Error("the camera has no direction; choose a finite target that is not the eye");
  }
  if (!(camera.fov_y_deg > 0.0F && camera.fov_y_deg < 180.0F)) {
    throw Error(fmt::format("the camera's field of view is {} degrees; choose one inside 0 to 180",
                            camera.fov_y_deg));
  }
  forward_ = view / distance;
  right_ = right_of(forward_, camera.up);
  up_ = glm::cross(right_, forward_);
  focus_ = camera.focus_distance > 0.0F ? camera.focus_distance : distance;
  constexpr double kHalfRadian = 3.14159265358979323846 / 360.0;
  half_.y = std::tan(static_cast<double>(camera.fov_y_deg) * kHalfRadian);
  half_.x = half_.y * width / height;
}

Ray CameraRays::at(const glm::dvec2& place, const glm::dvec2& lens) const {
  const double x = (2.0 * place.x / size_.x - 1.0) * half_.x;
  const double y = (1.0 - 2.0 * place.y / size_.y) * half_.y;
  glm::dvec3 direction = forward_ + x * right_ + y * up_;
  Ray ray;
  ray.o = glm::vec3(eye_);
  if (radius_ > 0.0) {
    const glm::dvec3 shift = radius_ * (lens.x * right_ + lens.y * up_);
    ray.o = glm::vec3(eye_ + shift);
    direction = focus_ * direction - shift;
  }
  ray.d = glm::vec3(glm::normalize(direction));
  return ray;
}

std::optional<glm::dvec2> CameraRays::place_of(const glm::dvec3& point) const {
  const glm::dvec3 way = point - eye_;
  const double depth = glm::dot(way, forward_);
  if (!(depth > 0.0)) return {};
  const double x = glm::dot(way, right_) / (depth * half_.x);
  const double y = glm::dot(way, up_) / (depth * half_.y);
  return glm::dvec2(0.5 * (1.0 + x) * size_.x, 0.5 * (1.0 - y) * size_.y);
}

std::vector<std::uint32_t> morton_order(int width, int height) {
  const auto w = static_cast<std::uint32_t>(width);
  const auto h = static_cast<std::uint32_t>(height);
  std::vector<std::uint32_t> codes;
  codes.reserve(static_cast<std::size_t>(w) * h);
  for (std::uint32_t y = 0; y < h; ++y) {
    for (std::uint32_t x = 0; x < w; ++x) codes.push_back(spread(x) | spread(y) << 1);
  }
  std::sort(codes.begin(), codes.end());
  for (std::uint32_t& code : codes) code = even_bits(code >> 1) * w + even_bits(code);
  return codes;
}

}  // namespace ti
