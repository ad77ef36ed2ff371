// The row kernels in plain loops; include inside a namespace of the instruction set's own, which may use some of them.

[[maybe_unused]] static void smooth_row(const uint8_t* __restrict above, const uint8_t* __restrict centre,
                                        const uint8_t* __restrict below, int32_t width, uint16_t* __restrict scratch,
                                        uint8_t* __restrict out) {
  uint16_t* const column = scratch + 1;
  for (int32_t x = 0; x < width; ++x) {
    column[x] = static_cast<uint16_t>(above[x] + 2 * centre[x] + below[x]);
  }
  scratch[0] = column[0];
  column[width] = column[width - 1];
  for (int32_t x = 0; x < width; ++x) {
    out[x] = static_cast<uint8_t>((scratch[x] + 2 * scratch[x + 1] + scratch[x + 2] + 8) >> 4);
  }
}

static inline int32_t size_of(int32_t value) { return value < 0 ? -value : value; }

[[maybe_unused]] static void gradient_row(const uint8_t* __restrict above, const uint8_t* __restrict centre,
                                          const uint8_t* __restrict below, int32_t width,
                                          const ThresholdCurve& threshold, int16_t* __restrict magnitude,
                                          uint8_t* __restrict code) {
  for (int32_t x = 1; x < width - 1; ++x) {
    const int32_t falling = below[x + 1] - above[x - 1];  // towards +x +y
    const int32_t rising = below[x - 1] - above[x + 1];   // towards -x +y
    const int32_t across = centre[x + 1] - centre[x - 1];
    const int32_t down = below[x] - above[x];
    const int32_t g0 = size_of(falling - rising + 2 * across);
    const int32_t g45 = size_of(2 * falling + across + down);
    const int32_t g90 = size_of(falling + rising + 2 * down);
    const int32_t g135 = size_of(2 * rising - across + down);
    const int32_t straight = g0 >= g90 ? g0 : g90;
    const int32_t diagonal = g45 >= g135 ? g45 : g135;
    const int32_t m = straight >= diagonal ? straight : diagonal;
    magnitude[x] = static_cast<int16_t>(m);
    code[x] = 0;
    if (m < threshold.least) continue;
    const int32_t sum = above[x - 1] + above[x] + above[x + 1] + centre[x - 1] + centre[x] + centre[x + 1] +
                        below[x - 1] + below[x] + below[x + 1];
    if (m < threshold.value[sum / 9]) continue;
    code[x] = static_cast<uint8_t>(straight >= diagonal ? (g0 >= g90 ? 1 : 3) : (g45 >= g135 ? 2 : 4));
  }
  magnitude[0] = magnitude[width - 1] = 0;
  code[0] = code[width - 1] = 0;
}

[[maybe_unused]] static void ridge_row(const int16_t* __restrict above, const int16_t* __restrict centre,
                                       const int16_t* __restrict below, const uint8_t* __restrict code, int32_t width,
                                       uint32_t* __restrict bits) {
  for (int32_t base = 0; base < width; base += 32) {
    const int32_t end = base + 32 < width ? base + 32 : width;
    uint32_t word = 0;
    for (int32_t x = base; x < end; ++x) {
      if (code[x] == 0) continue;
      const int16_t* before = above;
      const int16_t* after = below;
      int32_t step = 1;  // to the pixel after
      if (code[x] == 1) before = after = centre;
      if (code[x] == 3) step = 0;
      if (code[x] == 4) step = -1;
      // One strict comparison: a plateau two pixels wide gives one edge pixel.
      if (centre[x] > before[x - step] && centre[x] >= after[x + step]) word |= uint32_t{1} << (x - base);
    }
    bits[base / 32] = word;
  }
}

// The neighbours of pixels in a row of words: n[0] the eastern ones, then on by 45 degrees towards +y.
template <typename Bits>
struct Neighbours {
  Bits n[8];
};

// The pixels that are simple, no ends, and on one of the borders.  Simple, with 8-connected edges on a 4-connected
// background: the background runs past the four sides exactly once (Hilditch's crossing number).
template <typename Bits>
static inline Bits deletable_pixels(Bits pixels, const Neighbours<Bits>& around, Borders borders) {
  const Bits* n = around.n;
  Bits one_run = {}, more_runs = {}, one_edge = {}, more_edges = {};
  for (int k = 0; k < 8; k += 2) {
    const Bits run = ~n[k] & (n[k + 1] | n[(k + 2) & 7]);
    more_runs |= one_run & run;
    one_run |= run;
  }
  for (int k = 0; k < 8; ++k) {
    more_edges |= one_edge & n[k];
    one_edge |= n[k];
  }
  const Bits inner = borders == Borders::kNorthWest ? n[6] & n[4] : n[2] & n[0];
  return pixels & one_run & ~more_runs & more_edges & ~inner;
}

[[maybe_unused]] static bool deletable_row(const uint32_t* above, const uint32_t* centre, const uint32_t* below,
                                           int32_t words, Borders borders, uint32_t* deletable) {
  uint32_t any = 0;
  for (int32_t k = 0; k < words; ++k) {
    deletable[k] = 0;
    if (centre[k] == 0) continue;
    const auto west = [&](const uint32_t* p) { return p[k] << 1 | (k > 0 ? p[k - 1] >> 31 : 0); };
    const auto east = [&](const uint32_t* p) { return p[k] >> 1 | (k + 1 < words ? p[k + 1] << 31 : 0); };
    deletable[k] = deletable_pixels<uint32_t>(
        centre[k],
        {{east(centre), east(below), below[k], west(below), west(centre), west(above), above[k], east(above)}},
        borders);
    any |= deletable[k];
  }
  return any != 0;
}

[[maybe_unused]] static bool touching_row(const uint32_t* pixels, const uint32_t* kept_above, int32_t words,
                                          uint32_t* kept) {
  uint32_t left = 0;
  for (int32_t k = 0; k < words; ++k) {
    const uint32_t west = k > 0 ? kept_above[k - 1] >> 31 : 0, east = k + 1 < words ? kept_above[k + 1] << 31 : 0;
    const uint32_t near = kept_above[k] | kept_above[k] << 1 | kept_above[k] >> 1 | west | east;
    kept[k] = (kept[k] | near) & pixels[k];
    for (uint32_t before = 0; before != kept[k];) {
      before = kept[k];
      kept[k] |= (before << 1 | before >> 1) & pixels[k];
    }
    left |= pixels[k] & ~kept[k];
  }
  return left != 0;
}

[[maybe_unused]] static void light_row(const uint8_t* row, int32_t width, uint8_t level, uint64_t* sum,
                                       uint32_t* bright) {
  uint32_t row_sum = 0, row_bright = 0;
  for (int32_t x = 0; x < width; ++x) {
    row_sum += row[x];
    row_bright += row[x] >= level ? 1U : 0U;
  }
  *sum += row_sum;
  *bright += row_bright;
}

[[maybe_unused]] static uint32_t high_cells(const uint16_t* cells, uint16_t least) {
  const auto doubled = [&](int32_t i) {
    const int32_t votes = cells[i - 1] + 2 * cells[i] + cells[i + 1];
    return votes < UINT16_MAX ? votes : UINT16_MAX;
  };
  uint32_t high = 0;
  for (int32_t i = 0; i < 32; ++i) {
    const int32_t votes = doubled(i);
    if (votes < least || votes < doubled(i - 1) || votes < doubled(i + 1)) continue;
    high |= uint32_t{1} << i;
  }
  return high;
}
