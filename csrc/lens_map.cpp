#include "lens_map.hpp"

#include <cmath>

#include "integers.hpp"
#include "lens.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kCellQ5 = kMapStep * 32;
constexpr int32_t kFinestShift = 12, kCoarsestShift = 3;
constexpr double kMaxNode = 32767.0;

double larger(double a, double b) { return a > b ? a : b; }
double size_of(double v) { return v < 0 ? -v : v; }

struct Point {
  double x, y;
};

// Where the line through the node before the border's pixel and that pixel goes on: to a position beyond both.
class BeyondBorder {
 public:
  BeyondBorder(int32_t position, int32_t size)
      : border(size - 1),
        before((border - 1) / kMapStep * kMapStep),
        ratio_(static_cast<double>(position - before) / (border - before)) {}

  Point extend(const Point& a, const Point& b) const {
    return {a.x + (b.x - a.x) * ratio_, a.y + (b.y - a.y) * ratio_};
  }

  const int32_t border, before;

 private:
  const double ratio_;
};

// The rectified point of a raw pixel.  Beyond the last row or column, where a lens may fold without any fault, the line
// through the node before and the border's pixel goes on.  False where there is none.
bool point_of_column(const rvdnav_rig& rig, int32_t camera, int32_t u, int32_t v, Point* p) {
  if (raw_to_rect(rig, camera, u, v, &p->x, &p->y)) return true;
  if (v < rig.height) return false;
  const BeyondBorder line(v, rig.height);
  Point a, b;
  if (!raw_to_rect(rig, camera, u, line.before, &a.x, &a.y)) return false;
  if (!raw_to_rect(rig, camera, u, line.border, &b.x, &b.y)) return false;
  *p = line.extend(a, b);
  return true;
}

bool node_point(const rvdnav_rig& rig, int32_t camera, int32_t u, int32_t v, Point* p) {
  if (u < rig.width) return point_of_column(rig, camera, u, v, p);
  if (raw_to_rect(rig, camera, u, v, &p->x, &p->y)) return true;
  const BeyondBorder line(u, rig.width);
  Point a, b;
  if (!point_of_column(rig, camera, line.before, v, &a)) return false;
  if (!point_of_column(rig, camera, line.border, v, &b)) return false;
  *p = line.extend(a, b);
  return true;
}

// Calls visit(i, j, rectified point or null) for every node.
template <typename Visit>
void for_each_node(const rvdnav_rig& rig, int32_t camera, Visit visit) {
  for (int32_t j = 0; j < map_columns(rig.height); ++j) {
    for (int32_t i = 0; i < map_columns(rig.width); ++i) {
      Point p;
      visit(i, j, node_point(rig, camera, i * kMapStep, j * kMapStep, &p) ? &p : nullptr);
    }
  }
}

}  // namespace

double rectified_reach(const rvdnav_rig& rig, int32_t camera) {
  double square = 0.0;
  for_each_node(rig, camera, [&](int32_t, int32_t, const Point* p) {
    if (p != nullptr) square = larger(square, p->x * p->x + p->y * p->y);
  });
  return std::sqrt(square);
}

bool build_lens_map(const rvdnav_rig& rig, int32_t camera, int16_t* nodes, LensMap* map) {
  map->nodes = nodes;
  map->columns = map_columns(rig.width);
  map->rows = map_columns(rig.height);
  map->middle_x = (rig.width - 1) * 16;
  map->middle_y = (rig.height - 1) * 16;

  // First the largest shift, which decides how fine the nodes can be, then the nodes.
  const auto shift_of = [map](int32_t i, int32_t j, const Point& p) {
    return Point{p.x - (i * kMapStep - map->middle_x / 32.0), p.y - (j * kMapStep - map->middle_y / 32.0)};
  };
  double largest = 0.0;
  bool any = false;
  map->complete = true;
  for_each_node(rig, camera, [&](int32_t i, int32_t j, const Point* p) {
    map->complete = map->complete && p != nullptr;
    if (p == nullptr) return;
    any = true;
    const Point d = shift_of(i, j, *p);
    largest = larger(largest, larger(size_of(d.x), size_of(d.y)));
  });
  map->shift = kFinestShift;
  while (map->shift > kCoarsestShift && largest * (1 << map->shift) > kMaxNode) --map->shift;
  // Written so that a NaN fails.
  if (!any || !(rectified_reach(rig, camera) <= kMaxRect) || !(largest * (1 << map->shift) <= kMaxNode)) return false;
  for_each_node(rig, camera, [&](int32_t i, int32_t j, const Point* p) {
    int16_t* node = nodes + 2 * (static_cast<ptrdiff_t>(j) * map->columns + i);
    node[0] = node[1] = kNoRay;
    if (p == nullptr) return;
    const Point d = shift_of(i, j, *p);
    node[0] = static_cast<int16_t>(round_half_away(d.x * (1 << map->shift)));
    node[1] = static_cast<int16_t>(round_half_away(d.y * (1 << map->shift)));
  });
  return true;
}

bool raw_to_rect_q5(const LensMap& map, int32_t u_q5, int32_t v_q5, int32_t* x_q5, int32_t* y_q5) {
  const auto cell = [](int32_t position, int32_t count) {
    const int32_t i = position < 0 ? 0 : position / kCellQ5;
    return i > count - 2 ? count - 2 : i;
  };
  const int32_t i = cell(u_q5, map.columns), j = cell(v_q5, map.rows);
  const int32_t fu = u_q5 - i * kCellQ5, fv = v_q5 - j * kCellQ5;  // Q8 of a cell
  const int16_t* above = map.nodes + 2 * (static_cast<ptrdiff_t>(j) * map.columns + i);
  const int16_t* below = above + 2 * static_cast<ptrdiff_t>(map.columns);
  if (above[0] == kNoRay || above[2] == kNoRay || below[0] == kNoRay || below[2] == kNoRay) return false;
  const auto blend = [&](int32_t k) {
    const int32_t top = above[k] * 256 + (above[k + 2] - above[k]) * fu;  // Q8 of a node's unit
    const int32_t bottom = below[k] * 256 + (below[k + 2] - below[k]) * fu;
    const int32_t value = top + floor_shift(floor_shift(bottom - top, 4) * fv, 4);
    const int32_t to_q5 = map.shift + 8 - 5;
    return floor_shift(value + (1 << (to_q5 - 1)), to_q5);
  };
  *x_q5 = u_q5 - map.middle_x + blend(0);
  *y_q5 = v_q5 - map.middle_y + blend(1);
  return true;
}

}  // namespace rvdnav
