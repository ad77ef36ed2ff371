#include "rectify.hpp"

#include "angle.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kTangentReach = 4;  // pixels to both sides

// Offsets along the tangent of a gradient's direction, Q5.
struct TangentTable {
  int16_t dx[256], dy[256];
};

constexpr TangentTable make_tangent_table() {
  TangentTable table = {};
  for (int32_t level = 0; level < 256; ++level) {
    const CosSin gradient = cos_sin_degrees(level * (360.0 / 256.0));
    table.dx[level] = static_cast<int16_t>(round_half_away(-gradient.s * (kTangentReach * 32)));
    table.dy[level] = static_cast<int16_t>(round_half_away(gradient.c * (kTangentReach * 32)));
  }
  return table;
}

constexpr TangentTable kTangent = make_tangent_table();

bool rectify_edgel(const LensMap& map, int32_t x, int32_t y, uint8_t direction, rvdnav_edgel* edgel) {
  const int32_t u = 32 * x, v = 32 * y;
  const int32_t du = kTangent.dx[direction], dv = kTangent.dy[direction];
  int32_t rx = 0, ry = 0, ahead_x = 0, ahead_y = 0, behind_x = 0, behind_y = 0;
  if (!raw_to_rect_q5(map, u, v, &rx, &ry) || !raw_to_rect_q5(map, u + du, v + dv, &ahead_x, &ahead_y) ||
      !raw_to_rect_q5(map, u - du, v - dv, &behind_x, &behind_y))
    return false;
  const int32_t tx = ahead_x - behind_x, ty = ahead_y - behind_y;
  // The gradient is a quarter turn behind the tangent.
  *edgel = {rx, ry, binary_angle(ty, -tx), {}};
  return true;
}

}  // namespace

uint32_t rectify_edges(const uint32_t* bits, const uint8_t* direction, int32_t w, int32_t h, const LensMap& map,
                       rvdnav_edgel* out, uint32_t capacity, uint32_t* total) {
  const int32_t words = edge_row_words(w);
  uint32_t count = 0, seen = 0;
  for (int32_t y = 0; y < h; ++y) {
    for (int32_t k = 0; k < words; ++k) {
      for (uint32_t rest = bits[static_cast<ptrdiff_t>(y) * words + k]; rest != 0; rest &= rest - 1) {
        const int32_t x = 32 * k + __builtin_ctz(rest);
        rvdnav_edgel edgel;
        if (!rectify_edgel(map, x, y, direction[static_cast<ptrdiff_t>(y) * w + x], &edgel)) continue;
        ++seen;
        if (count < capacity) out[count++] = edgel;
      }
    }
  }
  *total = seen;
  return count;
}

}  // namespace rvdnav
