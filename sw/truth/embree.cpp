// SPDX-License-Identifier: Apache-2.0
#include "truth/embree.hpp"

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "base/error.hpp"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace ti {

namespace {

/// What Embree gives out, given back at the end.
struct Handles {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  Handles() = default;
  ~Handles() {
    if (scene != nullptr) {
      rtcReleaseScene(scene);
    }
    if (device != nullptr) {
      rtcReleaseDevice(device);
    }
  }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
};

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

RTCRayHit query_of(const Ray& ray) {
  RTCRayHit query{};
  query.ray.org_x = ray.o.x;
  query.ray.org_y = ray.o.y;
  query.ray.org_z = ray.o.z;
  query.ray.tnear = std::max(ray.tmin, 0.0F);
  query.ray.dir_x = ray.d.x;
  query.ray.dir_y = ray.d.y;
  query.ray.dir_z = ray.d.z;
  query.ray.tfar = ray.tmax;
  query.ray.mask = ~0U;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.primID = RTC_INVALID_GEOMETRY_ID;
  return query;
}

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

struct EmbreeScene::Impl : Handles {
  std::vector<std::int32_t> prims;
};

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
  RTCRayHit query = query_of(ray);
  if (query.ray.tnear > query.ray.tfar) {
    return hit;
  }
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

struct EmbreeBoxes::Impl : Handles {
  std::vector<Box> boxes;
};

namespace {

/// Float32 bounds around a box, with room for what the hierarchy rounds.
void bounds_of_box(const RTCBoundsFunctionArguments* arguments) {
  const auto& boxes = *static_cast<const std::vector<Box>*>(arguments->geometryUserPtr);
  const Box& box = boxes[arguments->primID];
  const auto down = [](double x) { return static_cast<float>(x - 1e-6 * std::abs(x)); };
  const auto up = [](double x) { return static_cast<float>(x + 1e-6 * std::abs(x)); };
  RTCBounds& out = *arguments->bounds_o;
  out.lower_x = down(box.lo[0]);
  out.lower_y = down(box.lo[1]);
  out.lower_z = down(box.lo[2]);
  out.upper_x = up(box.hi[0]);
  out.upper_y = up(box.hi[1]);
  out.upper_z = up(box.hi[2]);
}

/// Slabs (Kay and Kajiya 1986).
bool meets(const Box& box, const RTCRay& ray) {
  const double o[] = {ray.org_x, ray.org_y, ray.org_z};
  const double d[] = {ray.dir_x, ray.dir_y, ray.dir_z};
  double near = ray.tnear;
  double far = ray.tfar;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0.0) {
      if (o[axis] < box.lo[axis] || o[axis] > box.hi[axis]) return false;
      continue;
    }
    const double a = (box.lo[axis] - o[axis]) / d[axis];
    const double b = (box.hi[axis] - o[axis]) / d[axis];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far;
}

void occluded_by_box(const RTCOccludedFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  const auto& boxes = *static_cast<const std::vector<Box>*>(arguments->geometryUserPtr);
  RTCRay& ray = *reinterpret_cast<RTCRay*>(arguments->ray);  // of one: N is 1
  if (meets(boxes[arguments->primID], ray)) ray.tfar = -std::numeric_limits<float>::infinity();
}

}  // namespace

EmbreeBoxes::EmbreeBoxes(std::vector<Box> boxes) : impl_(std::make_unique<Impl>()) {
  impl_->boxes = std::move(boxes);
  const KeepFloatingPoint keep;
  RTCDevice& device = impl_->device;
  RTCScene& scene = impl_->scene;
  device = rtcNewDevice(nullptr);
  check(device);
  scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(impl_->boxes.size()));
  rtcSetGeometryUserData(geometry, &impl_->boxes);
  rtcSetGeometryBoundsFunction(geometry, bounds_of_box, nullptr);
  rtcSetGeometryOccludedFunction(geometry, occluded_by_box);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  check(device);
}

EmbreeBoxes::~EmbreeBoxes() = default;

bool EmbreeBoxes::met_by(const Ray& ray) const {
  if (!EmbreeScene::takes(ray)) return true;
  RTCRay query = query_of(ray).ray;
  if (query.tnear > query.tfar) return false;
  occluded(impl_->scene, query);
  return query.tfar < 0.0F;
}

}  // namespace ti
