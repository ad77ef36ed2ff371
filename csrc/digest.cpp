#include "digest.hpp"

#include <string.h>

namespace rvdnav {
namespace {

constexpr int32_t kLanes = 4;  // so that no multiplication waits for the one before
constexpr int32_t kWord = 8, kBlock = kLanes * kWord;
constexpr uint64_t kFactor = 0x9e3779b97f4a7c15ULL;  // odd: every step can be undone, so no difference gets lost

uint64_t mixed(uint64_t state, uint64_t word) {
  const uint64_t sum = (state ^ word) * kFactor;
  return sum << 29 | sum >> 35;  // what a product has in its high bits comes into the next one's low ones
}

}  // namespace

uint64_t image_digest(const GreyView& image) {
  uint64_t lane[kLanes] = {1, 2, 3, 4};
  for (int32_t y = 0; y < image.height; ++y) {
    const uint8_t* row = image.row(y);
    int32_t x = 0;
    for (; x + kBlock <= image.width; x += kBlock) {
      uint64_t word[kLanes];
      memcpy(word, row + x, kBlock);
      for (int32_t k = 0; k < kLanes; ++k) lane[k] = mixed(lane[k], word[k]);
    }
    if (x == image.width) continue;
    uint64_t word[kLanes] = {};
    memcpy(word, row + x, static_cast<size_t>(image.width - x));
    for (int32_t k = 0; k < kLanes; ++k) lane[k] = mixed(lane[k], word[k]);
  }
  uint64_t digest = static_cast<uint64_t>(image.width) << 32 | static_cast<uint32_t>(image.height);
  for (const uint64_t state : lane) digest = mixed(digest, state);
  return mixed(digest, digest >> 32);
}

}  // namespace rvdnav
