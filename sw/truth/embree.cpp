// SPDX-License-Identifier: Apache-2.0
#include "truth/embree.hpp"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "base/error.hpp"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace ti {

struct EmbreeScene::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<std::int32_t> prims;

  ~Impl() {
    if (scene != nullptr) {
      rtcReleaseScene(scene);
    }
    if (device != nullptr) {
      rtcReleaseDevice(device);
    }
  }
};

namespace {

void check(RTCDevice device) {
  if (const RTCError code = rtcGetDeviceError(device); code != RTC_ERROR_NONE) {
    throw Error("Embree failed with error code " + std::to_string(static_cast<int>(code)) +
                " while the truth scene was built; check the installed Embree library.");
  }
}

/// Keeps the caller's handling of subnormals: Embree may flush them in the thread that builds (FTZ
/// and DAZ of x86, FZ of ARM). The control bits are part of the C library's floating-point
/// environment.
class KeepFloatingPoint {
 public:
  KeepFloatingPoint() { std::fegetenv(&environment_); }
  ~KeepFloatingPoint() { std::fesetenv(&environment_); }
  KeepFloatingPoint(const KeepFloatingPoint&) = delete;
  KeepFloatingPoint& operator=(const KeepFloatingPoint&) = delete;

 private:
  std::fenv_t environment_{};
};

void intersect(RTCScene scene, RTCRayHit& query) {
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
  rtcIntersect1(scene, &query, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
}

void occluded(RTCScene scene, RTCRay& ray) {
#if RTC_VERSION_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  rtcOccluded1(scene, &ray, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
#endif
}

}  // namespace

EmbreeScene::EmbreeScene(std::span<const glm::vec3> vertices,
                         std::span<const std::array<std::uint32_t, 3>> triangles,
                         std::vector<std::int32_t> prims, const std::string& device)
    : impl_(std::make_unique<Impl>()) {
  impl_->prims = std::move(prims);
  const KeepFloatingPoint keep;
  impl_->device = rtcNewDevice(device.c_str());
  check(impl_->device);
  impl_->scene = rtcNewScene(impl_->device);
  rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(impl_->scene, RTC_BUILD_QUALITY_MEDIUM);
  if (!triangles.empty()) {
    const RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* points = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           sizeof(glm::vec3), vertices.size());
    void* corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            sizeof(triangles[0]), triangles.size());
    check(impl_->device);
    std::memcpy(points, vertices.data(), vertices.size_bytes());
    std::memcpy(corners, triangles.data(), triangles.size_bytes());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(impl_->scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(impl_->scene);
  check(impl_->device);
}

EmbreeScene::~EmbreeScene() = default;

std::vector<std::string> EmbreeScene::devices() {
  const KeepFloatingPoint keep;
  std::vector<std::string> found;
  for (const char* device : {"isa=sse2", "isa=sse4.2", "isa=avx", "isa=avx2", "isa=avx512"}) {
    const RTCDevice made = rtcNewDevice(device);
    if (rtcGetDeviceError(made) == RTC_ERROR_NONE && made != nullptr) {
      found.emplace_back(device);
    }
    if (made != nullptr) {
      rtcReleaseDevice(made);
    }
  }
  return found;
}

bool EmbreeScene::takes(const Ray& ray) {
  constexpr float kLargest = 1.844e18F;
  for (int k = 0; k < 3; ++k) {
    if (!(std::abs(ray.o[k]) <= kLargest && std::abs(ray.d[k]) <= kLargest)) {
      return false;
    }
  }
  return !std::isnan(ray.tmin) && !std::isnan(ray.tmax);
}

Hit EmbreeScene::trace(const Ray& ray) const {
  Hit hit;
  const float tnear = std::max(ray.tmin, 0.0F);
  if (tnear > ray.tmax) {
    return hit;
  }
  RTCRayHit query{};
  query.ray.org_x = ray.o.x;
  query.ray.org_y = ray.o.y;
  query.ray.org_z = ray.o.z;
  query.ray.tnear = tnear;
  query.ray.dir_x = ray.d.x;
  query.ray.dir_y = ray.d.y;
  query.ray.dir_z = ray.d.z;
  query.ray.tfar = ray.tmax;
  query.ray.mask = ~0U;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.primID = RTC_INVALID_GEOMETRY_ID;
  if (ray.any) {
    occluded(impl_->scene, query.ray);
    if (query.ray.tfar < 0.0F) {
      hit.t = 0.0F;
      hit.prim = 0;
    }
    return hit;
  }
  intersect(impl_->scene, query);
  if (query.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
    hit.t = query.ray.tfar;
    hit.u = query.hit.u;
    hit.v = query.hit.v;
    hit.prim = impl_->prims[query.hit.primID];
  }
  return hit;
}

}  // namespace ti
