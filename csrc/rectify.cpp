#include "rectify.hpp"

#include "pixel_batches.hpp"

namespace rvdnav {
namespace {

// levels(pixels, count, out): the directions of a batch.
template <typename Levels>
uint32_t rectify(const uint32_t* bits, int32_t w, int32_t h, const LensMap& map, const Kernels& kernels, Levels levels,
                 rvdnav_edgel* out, uint32_t capacity, uint32_t* total) {
  uint32_t count = 0;
  *total = 0;
  for_each_pixel_batch(bits, w, h, [&](const uint32_t* pixels, int32_t n) {
    uint8_t level[kPixelBatch] = {};
    levels(pixels, n, level);
    rvdnav_edgel edgels[kPixelBatch];
    const bool room = capacity - count >= static_cast<uint32_t>(kPixelBatch);
    const auto found =
        static_cast<uint32_t>(kernels.rectify_pixels(map, pixels, level, n, room ? out + count : edgels));
    *total += found;
    if (room) {
      count += found;
    } else {
      for (uint32_t i = 0; i < found && count < capacity; ++i) out[count++] = edgels[i];
    }
  });
  return count;
}

}  // namespace

uint32_t rectify_edges(const uint32_t* bits, const uint8_t* direction, int32_t w, int32_t h, const LensMap& map,
                       const Kernels& kernels, rvdnav_edgel* out, uint32_t capacity, uint32_t* total) {
  const auto given = [&](const uint32_t* pixels, int32_t n, uint8_t* level) {
    for (int32_t i = 0; i < n; ++i)
      level[i] = direction[static_cast<ptrdiff_t>(pixels[i] >> 16) * w + static_cast<ptrdiff_t>(pixels[i] & 0xffff)];
  };
  return rectify(bits, w, h, map, kernels, given, out, capacity, total);
}

uint32_t rectify_gradients(const uint32_t* bits, const uint8_t* smoothed, int32_t w, int32_t h, const LensMap& map,
                           const Kernels& kernels, rvdnav_edgel* out, uint32_t capacity, uint32_t* total) {
  const auto measured = [&](const uint32_t* pixels, int32_t n, uint8_t* level) {
    kernels.gradient_levels(smoothed, w, pixels, n, level);
  };
  return rectify(bits, w, h, map, kernels, measured, out, capacity, total);
}

}  // namespace rvdnav
