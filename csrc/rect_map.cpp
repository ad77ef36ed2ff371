#include "rect_map.hpp"

#include "integers.hpp"
#include "lens.hpp"

namespace rvdnav {
namespace {

constexpr double kFar = 16384.0;  // pixels; beyond every image, and differences in Q12 times a cell fit 32 bits

int32_t node_value(double position) {
  if (!(position > -kFar)) position = -kFar;  // a NaN, too
  if (position > kFar) position = kFar;
  return round_half_away(position * (1 << kRectFraction));
}

}  // namespace

void build_rect_map(const rvdnav_rig& rig, int32_t camera, RectMap* map) {
  map->columns = rect_map_columns(rig.width);
  map->rows = rect_map_columns(rig.height);
  for (int32_t j = 0; j < map->rows; ++j) {
    for (int32_t i = 0; i < map->columns; ++i) {
      double u = 0.0, v = 0.0;
      rect_to_raw(rig, camera, i * kRectStep - 0.5 * (rig.width - 1), j * kRectStep - 0.5 * (rig.height - 1), &u, &v);
      int32_t* node = map->nodes + 2 * (static_cast<ptrdiff_t>(j) * map->columns + i);
      node[0] = node_value(u);
      node[1] = node_value(v);
    }
  }
}

void rect_row_to_raw(const RectMap& map, int32_t j, int32_t width, int32_t* u, int32_t* v) {
  const int32_t cell = j / kRectStep, fraction = j % kRectStep;
  const int32_t* above = map.nodes + 2 * static_cast<ptrdiff_t>(cell) * map.columns;
  const int32_t* below = above + 2 * static_cast<ptrdiff_t>(map.columns);
  const auto between = [&](int32_t k) { return above[k] + (below[k] - above[k]) / kRectStep * fraction; };
  for (int32_t i = 0; i < width; i += kRectStep) {
    const int32_t k = 2 * (i / kRectStep);
    const int32_t u0 = between(k), v0 = between(k + 1);
    const int32_t du = (between(k + 2) - u0) / kRectStep, dv = (between(k + 3) - v0) / kRectStep;
    for (int32_t n = 0; n < kRectStep && i + n < width; ++n) {
      u[i + n] = u0 + du * n;
      v[i + n] = v0 + dv * n;
    }
  }
}

}  // namespace rvdnav
