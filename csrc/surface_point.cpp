#include "surface_point.hpp"

#include <cmath>

#include "correlation.hpp"
#include "integers.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kHalfColumns = 3, kHalfRows = 1;  // of the window that the Laplacians are compared in
constexpr double kSamplingSigma = 0.08;  // pixels of disparity: interpolation, lens grid, edges that are not sharp
constexpr double kRowSigma = 0.03;       // pixels across the rows: lens grid, rectification

struct Agreement {
  double mean_square;  // of the left Laplacian
  double unexplained;  // fraction of it that a scaled right one leaves over
};

// Compares the Laplacians around both crossings, the right one interpolated in Q8 so that they lie on each other.
Agreement compare(const LevelView& left, const LevelView& right, int32_t y, int32_t left_x_q8, int32_t right_x_q8) {
  const int32_t x = (left_x_q8 + 128) >> 8;
  const int32_t from_q8 = 256 * x - (left_x_q8 - right_x_q8);
  const int32_t x_right = from_q8 >> 8, fraction = from_q8 & 255;
  int64_t square_left = 0, square_right = 0, cross = 0;
  for (int32_t dy = -kHalfRows; dy <= kHalfRows; ++dy) {
    const int16_t* a = left.image.laplacian + static_cast<ptrdiff_t>(y + dy) * left.image.width + x;
    const int16_t* b = right.image.laplacian + static_cast<ptrdiff_t>(y + dy) * right.image.width + x_right;
    for (int32_t dx = -kHalfColumns; dx <= kHalfColumns; ++dx) {
      const int32_t p = a[dx];
      const int32_t q = floor_shift(b[dx] * (256 - fraction) + b[dx + 1] * fraction + 128, 8);
      square_left += int64_t{p} * p;
      square_right += int64_t{q} * q;
      cross += int64_t{p} * q;
    }
  }
  const double r = correlation_q15(cross, square_left, square_right) / 32768.0;
  constexpr double kCount = (2 * kHalfColumns + 1) * (2 * kHalfRows + 1);
  return {static_cast<double>(square_left) / kCount, 1.0 - r * std::abs(r)};
}

}  // namespace

bool make_surface_point(const LevelView& left, const LevelView& right, int32_t y, const CrossingMatch& match,
                        const Crossing& left_crossing, const SurfaceGeometry& geometry, rvdnav_surface_point* point) {
  const Crossing& l = left_crossing;
  const Crossing& r = right.rows.crossings[match.right];
  const PyramidLevel& image = left.image;
  point->x_q8 = l.x_q8 - 128 * (image.width - 1);
  point->y_q8 = 256 * y - 128 * (image.height - 1);
  point->disparity_q8 = l.x_q8 - r.x_q8;
  point->score_q15 = match.score_q15;
  const int32_t grey_q8 = image.smoothed[static_cast<ptrdiff_t>(y) * image.width + ((l.x_q8 + 128) >> 8)];
  point->grey = (grey_q8 + 128) >> 8 > 255 ? 255 : (grey_q8 + 128) >> 8;
  point->reserved = 0;

  // What the views' Laplacians differ by moves the crossing by that much over its slope.
  const Agreement agreement = compare(left, right, y, l.x_q8, r.x_q8);
  const double noise = agreement.mean_square * agreement.unexplained / (static_cast<double>(l.slope) * l.slope);
  const double slant = kRowSigma * l.gy / l.gx;
  point->sigma_disparity = std::sqrt(noise + kSamplingSigma * kSamplingSigma + slant * slant);

  const double x = point->x_q8 / 256.0, v = point->y_q8 / 256.0, d = point->disparity_q8 / 256.0;
  Eigen::Vector3d p;
  if (!(d > 0.0) || !triangulate(geometry.left, geometry.right, {x, v}, {x - d, v}, &p)) return false;
  for (int32_t k = 0; k < 3; ++k) point->p_W[k] = p[k];
  // With another disparity the point moves along the left camera's ray by dp/dd = -(p - c) / d.
  const double ray = geometry.rig.focal * geometry.rig.baseline / d *
                     std::sqrt(1.0 + (x * x + v * v) / (geometry.rig.focal * geometry.rig.focal));
  point->sigma = ray / d * point->sigma_disparity;
  return true;
}

}  // namespace rvdnav
