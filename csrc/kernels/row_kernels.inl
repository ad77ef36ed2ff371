// The row kernels; include inside a namespace of the instruction set's own.  The loops are plain, without branches and
// in 8 and 16 bit lanes, so that the compiler turns them into vector code.

static void smooth_row(const uint8_t* __restrict above, const uint8_t* __restrict centre,
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

static inline int16_t magnitude_of(int16_t value) { return static_cast<int16_t>(value < 0 ? -value : value); }

static void gradient_row(const uint8_t* __restrict above, const uint8_t* __restrict centre,
                         const uint8_t* __restrict below, int32_t width, int16_t* __restrict magnitude,
                         uint8_t* __restrict sector) {
  for (int32_t x = 1; x < width - 1; ++x) {
    const int16_t a0 = above[x - 1], a1 = above[x], a2 = above[x + 1];
    const int16_t b0 = centre[x - 1], b2 = centre[x + 1];
    const int16_t c0 = below[x - 1], c1 = below[x], c2 = below[x + 1];
    const int16_t falling = static_cast<int16_t>(c2 - a0);  // towards +x +y
    const int16_t rising = static_cast<int16_t>(c0 - a2);   // towards -x +y
    const int16_t across = static_cast<int16_t>(b2 - b0);
    const int16_t down = static_cast<int16_t>(c1 - a1);
    const int16_t g0 = magnitude_of(static_cast<int16_t>(falling - rising + 2 * across));
    const int16_t g45 = magnitude_of(static_cast<int16_t>(2 * falling + across + down));
    const int16_t g90 = magnitude_of(static_cast<int16_t>(falling + rising + 2 * down));
    const int16_t g135 = magnitude_of(static_cast<int16_t>(2 * rising - across + down));
    const int16_t straight = g0 >= g90 ? g0 : g90;
    const int16_t diagonal = g45 >= g135 ? g45 : g135;
    const int16_t straight_sector = g0 >= g90 ? 0 : 2;
    const int16_t diagonal_sector = g45 >= g135 ? 1 : 3;
    magnitude[x] = straight >= diagonal ? straight : diagonal;
    sector[x] = static_cast<uint8_t>(straight >= diagonal ? straight_sector : diagonal_sector);
  }
  magnitude[0] = 0;
  magnitude[width - 1] = 0;
}

static void ridge_row(const int16_t* __restrict above, const int16_t* __restrict centre,
                      const int16_t* __restrict below, const uint8_t* __restrict sector, int32_t width, int16_t minimum,
                      uint8_t* __restrict candidate) {
  for (int32_t x = 2; x < width - 2; ++x) {
    // All loads come first and depend on nothing, or the loop stays scalar.
    const int16_t s = sector[x], m = centre[x];
    const int16_t east = centre[x + 1], south_east = below[x + 1], south = below[x], south_west = below[x - 1];
    const int16_t west = centre[x - 1], north_west = above[x - 1], north = above[x], north_east = above[x + 1];
    const int16_t before_straight = s == 0 ? west : north, before_diagonal = s == 1 ? north_west : north_east;
    const int16_t after_straight = s == 0 ? east : south, after_diagonal = s == 1 ? south_east : south_west;
    const int16_t before = (s & 1) == 0 ? before_straight : before_diagonal;
    const int16_t after = (s & 1) == 0 ? after_straight : after_diagonal;
    // One strict comparison: a plateau two pixels wide gives one edge pixel.
    const int16_t above_before = m > before ? 255 : 0;
    const int16_t not_below_after = m >= after ? 255 : 0;
    const int16_t strong = m >= minimum ? 255 : 0;
    candidate[x] = static_cast<uint8_t>(above_before & not_below_after & strong);
  }
  for (int32_t x = 0; x < 2; ++x) {
    candidate[x] = 0;
    candidate[width - 1 - x] = 0;
  }
}
