// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <zstd.h>

#include <bit>
#include <cstring>
#include <memory>
#include <vector>

#include "base/error.hpp"
#include "import/import.hpp"

namespace ti {

static_assert(std::endian::native == std::endian::little,
              "binary PLY is read as it lies in memory");

namespace {

constexpr std::size_t kVertexBytes = 12;
constexpr std::size_t kFaceBytes = 13;
constexpr std::size_t kMaterialBytes = 2;
constexpr std::size_t kMaxUnpacked = std::size_t{8} << 30;

}  // namespace

std::optional<Mesh> read_plain_ply(std::string_view bytes, const PlyHeader& header,
                                   const std::string& file) {
  const std::string_view body = bytes.substr(header.body);
  const std::size_t stride = kFaceBytes + (header.has_material ? kMaterialBytes : 0);
  const std::size_t need = header.vertices * kVertexBytes + header.faces * stride;
  if (body.size() < need) {
    throw Error(
        fmt::format("{}: the file is cut: {} vertices and {} faces need {} bytes after the "
                    "header, and there are {}; copy or export it again",
                    file, header.vertices, header.faces, need, body.size()));
  }
  Mesh mesh;
  mesh.vertices.resize(header.vertices);
  if (header.vertices > 0) {
    std::memcpy(mesh.vertices.data(), body.data(), header.vertices * kVertexBytes);
  }
  mesh.triangles.resize(header.faces);
  mesh.material.resize(header.has_material ? header.faces : 0);
  const char* at = body.data() + header.vertices * kVertexBytes;
  for (std::size_t i = 0; i < header.faces; ++i, at += stride) {
    const int corners = static_cast<unsigned char>(*at);
    if (corners != 3) {
      if (!header.has_material) return {};
      throw Error(fmt::format("{}: face {} has {} corners; split the faces into triangles", file, i,
                              corners));
    }
    auto& triangle = mesh.triangles[i];
    std::memcpy(triangle.data(), at + 1, kVertexBytes);
    for (const std::uint32_t index : triangle) {
      if (index >= header.vertices) {
        throw Error(
            fmt::format("{}: face {} has index {}, and there are {} vertices; export the mesh "
                        "again",
                        file, i, static_cast<std::int32_t>(index), header.vertices));
      }
    }
    if (header.has_material) std::memcpy(&mesh.material[i], at + kFaceBytes, kMaterialBytes);
  }
  if (body.size() > need) {
    throw Error(fmt::format("{}: {} bytes follow the last face; copy or export the file again",
                            file, body.size() - need));
  }
  return mesh;
}

std::string unpack_zstd(std::string_view packed, const std::string& file) {
  const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(),
                                                                        ZSTD_freeDCtx);
  std::vector<char> chunk(ZSTD_DStreamOutSize());
  std::string bytes;
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  std::size_t left = 1;  // 0 at the end of a frame
  bool full = false;     // the output filled up, so that there may be more without more input
  while (in.pos < in.size || full) {
    ZSTD_outBuffer out{chunk.data(), chunk.size(), 0};
    left = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(left) != 0U) {
      throw Error(
          fmt::format("{}: the Zstandard data are corrupt near byte {} ({}); copy the file "
                      "again",
                      file, in.pos, ZSTD_getErrorName(left)));
    }
    bytes.append(chunk.data(), out.pos);
    if (bytes.size() > kMaxUnpacked) {
      throw Error(fmt::format("{}: it unpacks to more than {} GiB; use a smaller scene", file,
                              kMaxUnpacked >> 30));
    }
    full = out.pos == out.size && left != 0;
  }
  if (left != 0) {
    throw Error(file + ": the Zstandard data are cut; copy the file again");
  }
  return bytes;
}

}  // namespace ti
