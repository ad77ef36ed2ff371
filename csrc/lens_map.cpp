#include "lens_map.hpp"

#include "integers.hpp"
#include "lens.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kCellQ5 = kMapStep * 32;

double larger(double a, double b) { return a > b ? a : b; }
double size_of(double v) { return v < 0 ? -v : v; }

}  // namespace

bool build_lens_map(const rvdnav_rig& rig, int camera, int16_t* nodes, LensMap* map) {
  map->nodes = nodes;
  map->columns = map_columns(rig.width);
  map->rows = map_columns(rig.height);
  map->middle_x = (rig.width - 1) * 16;
  map->middle_y = (rig.height - 1) * 16;

  // First the largest shift, which decides how fine the nodes can be, then the nodes.
  double largest = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    for (int32_t j = 0; j < map->rows; ++j) {
      for (int32_t i = 0; i < map->columns; ++i) {
        const double u = i * kMapStep, v = j * kMapStep;
        double x = 0.0, y = 0.0;
        if (!raw_to_rect(rig, camera, u, v, &x, &y)) return false;
        if (larger(size_of(x), size_of(y)) > kMapMaxRect) return false;
        const double dx = x - (u - map->middle_x / 32.0), dy = y - (v - map->middle_y / 32.0);
        if (pass == 0) {
          largest = larger(largest, larger(size_of(dx), size_of(dy)));
        } else {
          int16_t* node = nodes + 2 * (static_cast<ptrdiff_t>(j) * map->columns + i);
          node[0] = static_cast<int16_t>(round_half_away(dx * (1 << map->shift)));
          node[1] = static_cast<int16_t>(round_half_away(dy * (1 << map->shift)));
        }
      }
    }
    if (pass == 0) {
      map->shift = 12;
      while (map->shift > 5 && largest * (1 << map->shift) > 32767.0) --map->shift;
      if (largest * (1 << map->shift) > 32767.0) return false;
    }
  }
  return true;
}

void raw_to_rect_q5(const LensMap& map, int32_t u_q5, int32_t v_q5, int32_t* x_q5, int32_t* y_q5) {
  const auto cell = [](int32_t position, int32_t count) {
    const int32_t i = position < 0 ? 0 : position / kCellQ5;
    return i > count - 2 ? count - 2 : i;
  };
  const int32_t i = cell(u_q5, map.columns), j = cell(v_q5, map.rows);
  const int32_t fu = u_q5 - i * kCellQ5, fv = v_q5 - j * kCellQ5;  // Q8 of a cell
  const int16_t* above = map.nodes + 2 * (static_cast<ptrdiff_t>(j) * map.columns + i);
  const int16_t* below = above + 2 * static_cast<ptrdiff_t>(map.columns);
  const auto blend = [&](int32_t k) {
    const int32_t top = above[k] * 256 + (above[k + 2] - above[k]) * fu;  // Q8 of a node's unit
    const int32_t bottom = below[k] * 256 + (below[k + 2] - below[k]) * fu;
    const int32_t value = top + floor_shift(floor_shift(bottom - top, 4) * fv, 4);
    const int32_t to_q5 = map.shift + 8 - 5;
    return floor_shift(value + (1 << (to_q5 - 1)), to_q5);
  };
  *x_q5 = u_q5 - map.middle_x + blend(0);
  *y_q5 = v_q5 - map.middle_y + blend(1);
}

}  // namespace rvdnav
