// The row kernels in lanes; include inside a namespace of the instruction set's own, after its primitives:
//
//   Bytes, Shorts, UShorts, Words  of uint8_t, int16_t, uint16_t and uint32_t, as the compiler's vector types
//   Pair                     Shorts lo and hi of one vector of bytes, in an order of the instruction set's own
//   difference, total        Pair of a - b and a + b of bytes
//   widen(bytes)             Pair of the bytes' values
//   narrow(pair)             the pair's values, 0..255, as bytes
//   store_pair, widen_at     the same in the order of the image, to and from memory
//   high_product(a, b)       a * b / 65536, unsigned
//   capped_sum(a, b)         of UShorts, 65535 at most
//   Sums, add_up, total_of   sums of many bytes, in lanes and at last
//   any(v), mask_bits(lo, hi)  of comparisons: whether one holds; a bit for each lane
//
// Rows narrower than a few vectors go to the plain loops in namespace plain.

constexpr int32_t kBytes = static_cast<int32_t>(sizeof(Bytes));
constexpr int32_t kShorts = static_cast<int32_t>(sizeof(Shorts) / sizeof(int16_t));
constexpr int32_t kWords = static_cast<int32_t>(sizeof(Words) / sizeof(uint32_t));

template <typename Vector, typename Element>
static inline Vector load(const Element* p) {
  Vector v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

template <typename Vector, typename Element>
static inline void store(Element* p, const Vector& v) {
  __builtin_memcpy(p, &v, sizeof v);
}

static inline Shorts constant(int32_t value) { return Shorts{} + static_cast<int16_t>(value); }
static inline UShorts unsigned_of(Shorts v) { return reinterpret_cast<UShorts>(v); }
static inline Shorts larger_of(Shorts a, Shorts b) { return a > b ? a : b; }
static inline Shorts smaller_of(Shorts a, Shorts b) { return a < b ? a : b; }
static inline Shorts size_of(Shorts v) { return larger_of(v, -v); }

struct Responses {
  Shorts g0, g45, g90, g135, magnitude;
};

static inline Responses responses(Shorts falling, Shorts rising, Shorts across, Shorts down) {
  Responses r;
  r.g0 = size_of(falling - rising + across + across);
  r.g90 = size_of(falling + rising + down + down);
  r.g45 = size_of(falling + falling + (down + across));
  r.g135 = size_of(rising + rising + (down - across));
  r.magnitude = larger_of(larger_of(r.g0, r.g90), larger_of(r.g45, r.g135));
  return r;
}

// The codes of strong pixels by the sum of the nine around each.
static inline Shorts code_of(const Responses& r, Shorts strong, Shorts sum, const ThresholdCurve& threshold) {
  const Shorts mean = high_product(unsigned_of(sum), 7282);  // sum / 9
  const Shorts normal = smaller_of(mean, constant(threshold.knee));
  const UShorts brightness = unsigned_of(mean + normal + normal + normal) << 6;  // at most 65280
  const Shorts whole = high_product(brightness, static_cast<uint16_t>(threshold.weber));
  const Shorts exact = brightness * static_cast<uint16_t>(threshold.weber) == 0;  // a comparison that holds is -1
  const Shorts straight = r.g0 >= r.g90 ? constant(1) : constant(3);
  const Shorts diagonal = r.g45 >= r.g135 ? constant(2) : constant(4);
  const Shorts code = larger_of(r.g0, r.g90) == r.magnitude ? straight : diagonal;
  return code & strong & (r.magnitude - exact > whole);
}

static inline void gradient_block(const uint8_t* above, const uint8_t* centre, const uint8_t* below,
                                  const ThresholdCurve& threshold, int16_t* magnitude, uint8_t* code) {
  const Bytes a0 = load<Bytes>(above - 1), a1 = load<Bytes>(above), a2 = load<Bytes>(above + 1);
  const Bytes b0 = load<Bytes>(centre - 1), b2 = load<Bytes>(centre + 1);
  const Bytes c0 = load<Bytes>(below - 1), c1 = load<Bytes>(below), c2 = load<Bytes>(below + 1);
  const Pair falling = difference(c2, a0), rising = difference(c0, a2);
  const Pair across = difference(b2, b0), down = difference(c1, a1);
  const Responses lo = responses(falling.lo, rising.lo, across.lo, down.lo);
  const Responses hi = responses(falling.hi, rising.hi, across.hi, down.hi);
  store_pair(magnitude, {lo.magnitude, hi.magnitude});
  const Shorts strong_lo = lo.magnitude >= threshold.least, strong_hi = hi.magnitude >= threshold.least;
  if (!any(strong_lo | strong_hi)) {
    store(code, Bytes{});
    return;
  }
  const Pair corners = total(c2, a0), others = total(c0, a2), sides = total(b2, b0), ends = total(c1, a1);
  const Pair middle = widen(load<Bytes>(centre));
  const Shorts sum_lo = corners.lo + others.lo + sides.lo + ends.lo + middle.lo;
  const Shorts sum_hi = corners.hi + others.hi + sides.hi + ends.hi + middle.hi;
  store(code, narrow({code_of(lo, strong_lo, sum_lo, threshold), code_of(hi, strong_hi, sum_hi, threshold)}));
}

static void gradient_row(const uint8_t* __restrict above, const uint8_t* __restrict centre,
                         const uint8_t* __restrict below, int32_t width, const ThresholdCurve& threshold,
                         int16_t* __restrict magnitude, uint8_t* __restrict code) {
  const int32_t last = width - 1 - kBytes;  // block that still has a pixel on its right
  if (last < 1) return plain::gradient_row(above, centre, below, width, threshold, magnitude, code);
  const auto block = [&](int32_t x) {
    gradient_block(above + x, centre + x, below + x, threshold, magnitude + x, code + x);
  };
  for (int32_t x = 1; x < last; x += kBytes) block(x);
  block(last);
  magnitude[0] = magnitude[width - 1] = 0;
  code[0] = code[width - 1] = 0;
}

static inline Shorts ridge_half(const int16_t* above, const int16_t* centre, const int16_t* below, Shorts code) {
  const auto at = [](const int16_t* p) { return load<Shorts>(p); };
  const Shorts straight = code == 1, diagonal = code == 2, upright = code == 3;
  const Shorts before = straight ? at(centre - 1) : (diagonal ? at(above - 1) : (upright ? at(above) : at(above + 1)));
  const Shorts after = straight ? at(centre + 1) : (diagonal ? at(below + 1) : (upright ? at(below) : at(below - 1)));
  const Shorts m = at(centre);
  // One strict comparison: a plateau two pixels wide gives one edge pixel.
  return (m > before) & (m >= after) & (code != 0);
}

static void ridge_row(const int16_t* __restrict above, const int16_t* __restrict centre,
                      const int16_t* __restrict below, const uint8_t* __restrict code, int32_t width,
                      uint32_t* __restrict bits) {
  for (int32_t x = 0; x < (width + 31) / 32 * 32; x += kBytes) {
    Mask mask = 0;
    if (any(load<Bytes>(code + x))) {
      const auto half = [&](int32_t i) { return ridge_half(above + i, centre + i, below + i, widen_at(code + i)); };
      mask = mask_bits(half(x), half(x + kShorts));
    }
    store(reinterpret_cast<unsigned char*>(bits) + x / 8, mask);
  }
}

// The words of a row from k - 1 and from k + 1 on; beyond the row's ends they are 0.
static inline Words words_before(const uint32_t* row, int32_t k) {
  if (k > 0) return load<Words>(row + k - 1);
  return one_lane_on(load<Words>(row));
}

static inline Words words_after(const uint32_t* row, int32_t k, int32_t words) {
  if (k + kWords < words) return load<Words>(row + k + 1);
  return one_lane_back(load<Words>(row + k));
}

static bool deletable_row(const uint32_t* above, const uint32_t* centre, const uint32_t* below, int32_t words,
                          Borders borders, uint32_t* deletable) {
  const int32_t last = words - kWords;
  if (last < 0) return plain::deletable_row(above, centre, below, words, borders, deletable);
  Words any_of_row = {};
  const auto block = [&](int32_t k) {
    Words found = {};
    const Words pixels = load<Words>(centre + k);
    if (any(pixels)) {
      const auto west = [&](const uint32_t* p) { return load<Words>(p + k) << 1 | words_before(p, k) >> 31; };
      const auto east = [&](const uint32_t* p) { return load<Words>(p + k) >> 1 | words_after(p, k, words) << 31; };
      found = plain::deletable_pixels<Words>(pixels,
                                             {{east(centre), east(below), load<Words>(below + k), west(below),
                                               west(centre), west(above), load<Words>(above + k), east(above)}},
                                             borders);
    }
    store(deletable + k, found);
    any_of_row |= found;
  };
  for (int32_t k = 0; k < last; k += kWords) block(k);
  block(last);
  return any(any_of_row);
}

static bool touching_row(const uint32_t* pixels, const uint32_t* kept_above, int32_t words, uint32_t* kept) {
  const int32_t last = words - kWords;
  if (last < 0) return plain::touching_row(pixels, kept_above, words, kept);
  Words left = {};
  const auto block = [&](int32_t k) {
    const Words above = load<Words>(kept_above + k), here = load<Words>(pixels + k);
    const Words near =
        above | above << 1 | above >> 1 | words_before(kept_above, k) >> 31 | words_after(kept_above, k, words) << 31;
    Words reached = here & (near | load<Words>(kept + k));
    for (Words before = {}; any(before ^ reached);) {
      before = reached;
      reached |= (before << 1 | before >> 1) & here;
    }
    store(kept + k, reached);
    left |= here & ~reached;
  };
  for (int32_t k = 0; k < last; k += kWords) block(k);
  block(last);
  return any(left);
}

static void light_row(const uint8_t* row, int32_t width, uint8_t level, uint64_t* sum, uint32_t* bright) {
  const int32_t whole = width / kBytes * kBytes;
  Sums levels = {}, marks = {};
  for (int32_t x = 0; x < whole; x += kBytes) {
    const Bytes v = load<Bytes>(row + x);
    levels = add_up(levels, v);
    marks = add_up(marks, reinterpret_cast<Bytes>(v >= level) & static_cast<uint8_t>(1));
  }
  *sum += total_of(levels);
  *bright += static_cast<uint32_t>(total_of(marks));
  plain::light_row(row + whole, width - whole, level, sum, bright);
}

// Sixteen bits of the answer of high_cells, or as many as a vector has lanes.
static inline Shorts high_lanes(const uint16_t* cells, UShorts least) {
  const auto at = [&](int32_t i) { return load<UShorts>(cells + i); };
  const auto doubled = [&](int32_t i) {
    return capped_sum(capped_sum(at(i - 1), at(i + 1)), capped_sum(at(i), at(i)));
  };
  const UShorts votes = doubled(0);
  if (!any(votes >= least)) return Shorts{};
  return (votes >= least) & (votes >= doubled(-1)) & (votes >= doubled(1));
}

static uint32_t high_cells(const uint16_t* cells, uint16_t least) {
  uint32_t high = 0;
  for (int32_t i = 0; i < 32; i += kBytes) {
    const UShorts bound = UShorts{} + least;
    const Shorts lo = high_lanes(cells + i, bound), hi = high_lanes(cells + i + kShorts, bound);
    high |= static_cast<uint32_t>(mask_bits(lo, hi)) << i;
  }
  return high;
}
