#include "resample.hpp"

#include "integers.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kPhases = 256;

// Catmull-Rom weights of the four pixels around a fraction, Q14; each set sums to exactly 1.
struct CubicTable {
  int16_t weight[kPhases][4];
};

constexpr CubicTable make_cubic_table() {
  CubicTable table = {};
  for (int32_t phase = 0; phase < kPhases; ++phase) {
    const double t = phase / static_cast<double>(kPhases);
    const double exact[4] = {0.5 * t * (-1.0 + t * (2.0 - t)), 1.0 + 0.5 * t * t * (-5.0 + 3.0 * t),
                             0.5 * t * (1.0 + t * (4.0 - 3.0 * t)), 0.5 * t * t * (t - 1.0)};
    int32_t sum = 0;
    for (int32_t k = 0; k < 4; ++k) {
      table.weight[phase][k] = static_cast<int16_t>(round_half_away(exact[k] * 16384.0));
      sum += table.weight[phase][k];
    }
    const int32_t nearest = phase < kPhases / 2 ? 1 : 2;
    table.weight[phase][nearest] = static_cast<int16_t>(table.weight[phase][nearest] + 16384 - sum);
  }
  return table;
}

constexpr CubicTable kCubic = make_cubic_table();

uint16_t sample_q8(const GreyView& raw, int32_t u_q12, int32_t v_q12) {
  // To the nearest of the phases.
  const int32_t u = clamp((u_q12 + 8) >> 4, 0, (raw.width - 1) << 8);
  const int32_t v = clamp((v_q12 + 8) >> 4, 0, (raw.height - 1) << 8);
  const int16_t* across = kCubic.weight[u & 255];
  const int16_t* down = kCubic.weight[v & 255];
  const int32_t x = u >> 8, y = v >> 8;
  const int32_t columns[4] = {clamp(x - 1, 0, raw.width - 1), x, clamp(x + 1, 0, raw.width - 1),
                              clamp(x + 2, 0, raw.width - 1)};
  int32_t sum = 0;
  for (int32_t k = 0; k < 4; ++k) {
    const uint8_t* row = raw.row(clamp(y + k - 1, 0, raw.height - 1));
    const int32_t grey_q14 = across[0] * row[columns[0]] + across[1] * row[columns[1]] + across[2] * row[columns[2]] +
                             across[3] * row[columns[3]];
    sum += down[k] * floor_shift(grey_q14 + 128, 8);  // Q14 times Q6
  }
  return static_cast<uint16_t>(clamp(floor_shift(sum + (1 << 11), 12), 0, 0xffff));
}

}  // namespace

void resample(const GreyView& raw, const RectMap& map, int32_t* u, int32_t* v, uint16_t* out, RowSpan* spans) {
  const int32_t last_u = (raw.width - 1) << kRectFraction, last_v = (raw.height - 1) << kRectFraction;
  const auto inside = [&](int32_t i) { return u[i] >= 0 && u[i] <= last_u && v[i] >= 0 && v[i] <= last_v; };
  for (int32_t j = 0; j < raw.height; ++j) {
    rect_row_to_raw(map, j, raw.width, u, v);
    uint16_t* row = out + static_cast<ptrdiff_t>(j) * raw.width;
    for (int32_t i = 0; i < raw.width; ++i) row[i] = sample_q8(raw, u[i], v[i]);
    // Outwards from the middle: beyond the fold of a lens raw positions come back into the image.
    int32_t begin = raw.width / 2, end = begin;
    while (begin > 0 && inside(begin - 1)) --begin;
    while (end < raw.width && inside(end)) ++end;
    spans[j] = {static_cast<int16_t>(begin), static_cast<int16_t>(end)};
  }
}

}  // namespace rvdnav
