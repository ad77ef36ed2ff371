#include "pyramid.hpp"

#include "integers.hpp"

namespace rvdnav {
namespace {

// The 5x5 binomial (1 4 6 4 1) (1 4 6 4 1)^T / 256, rounded after each direction; the border repeats.
void smooth_binomial5(const uint16_t* in, int32_t width, int32_t height, uint16_t* row, uint16_t* out) {
  for (int32_t y = 0; y < height; ++y) {
    const auto line = [&](int32_t dy) { return in + static_cast<ptrdiff_t>(clamp(y + dy, 0, height - 1)) * width; };
    const uint16_t *a = line(-2), *b = line(-1), *c = line(0), *d = line(1), *e = line(2);
    for (int32_t x = 0; x < width; ++x) {
      const uint32_t sum = a[x] + e[x] + 4U * (uint32_t{b[x]} + d[x]) + 6U * c[x];
      row[x + 2] = static_cast<uint16_t>((sum + 8) >> 4);
    }
    row[0] = row[1] = row[2];
    row[width + 2] = row[width + 3] = row[width + 1];
    uint16_t* to = out + static_cast<ptrdiff_t>(y) * width;
    for (int32_t x = 0; x < width; ++x) {
      const uint32_t sum = row[x] + row[x + 4] + 4U * (uint32_t{row[x + 1]} + row[x + 3]) + 6U * row[x + 2];
      to[x] = static_cast<uint16_t>((sum + 8) >> 4);
    }
  }
}

// (1 4 1; 4 -20 4; 1 4 1) / 8: the isotropic Laplacian times 3/4; 0 at the border.
void laplacian(const uint16_t* in, int32_t width, int32_t height, int16_t* out) {
  for (int32_t y = 0; y < height; ++y) {
    int16_t* to = out + static_cast<ptrdiff_t>(y) * width;
    to[0] = to[width - 1] = 0;
    const uint16_t* b = in + static_cast<ptrdiff_t>(y) * width;
    const uint16_t *a = b - width, *c = b + width;
    const bool border = y == 0 || y == height - 1;
    for (int32_t x = 1; x < width - 1; ++x) {
      if (border) {
        to[x] = 0;
        continue;
      }
      const int32_t corners = a[x - 1] + a[x + 1] + c[x - 1] + c[x + 1];
      const int32_t sides = a[x] + c[x] + b[x - 1] + b[x + 1];
      // Twice smoothed, no image reaches 16 bits; the clamp makes it sure.
      to[x] = static_cast<int16_t>(clamp(floor_shift(corners + 4 * sides - 20 * b[x] + 4, 3), -32767, 32767));
    }
  }
}

}  // namespace

void filter_level(const PyramidLevel& level, uint16_t* row, uint16_t* plane) {
  smooth_binomial5(level.grey, level.width, level.height, row, level.smoothed);
  smooth_binomial5(level.smoothed, level.width, level.height, row, plane);
  laplacian(plane, level.width, level.height, level.laplacian);
}

void halve(const PyramidLevel& fine, const PyramidLevel& coarse) {
  for (int32_t y = 0; y < coarse.height; ++y) {
    const uint16_t* from = fine.smoothed + static_cast<ptrdiff_t>(2 * y) * fine.width;
    uint16_t* to = coarse.grey + static_cast<ptrdiff_t>(y) * coarse.width;
    for (int32_t x = 0; x < coarse.width; ++x) to[x] = from[2 * x];
  }
}

}  // namespace rvdnav
