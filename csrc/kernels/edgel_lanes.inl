// What is done to single edge pixels, eight at a time by AVX2; include inside the namespace of the set, after
// the plain loops in namespace plain, which take the rest.

static inline __m256i constant32(int32_t value) { return _mm256_set1_epi32(value); }
static inline __m256i load256(const void* p) { return _mm256_loadu_si256(static_cast<const __m256i*>(p)); }

// kArcTangent.level of 0..128, by a polynomial that stays 0.024 away from where it would round to another level.
static inline __m256i arc_tangents(__m256i ratio) {
  const auto all = [](float value) { return _mm256_set1_ps(value); };
  const __m256 x = _mm256_mul_ps(_mm256_cvtepi32_ps(ratio), all(1.0F / kRatioSteps)), square = _mm256_mul_ps(x, x);
  const __m256 inner = _mm256_add_ps(_mm256_mul_ps(square, all(3.14937F)), all(-11.63158F));
  const __m256 slope = _mm256_add_ps(_mm256_mul_ps(square, inner), all(40.53325F));
  return _mm256_cvttps_epi32(_mm256_add_ps(_mm256_mul_ps(x, slope), all(0.5F)));
}

// binary_angle of eight vectors with components below 2^16 in size: ratios are exact in single precision.
static inline __m256i binary_angles(__m256i x, __m256i y) {
  const __m256i ax = _mm256_abs_epi32(x), ay = _mm256_abs_epi32(y);
  const __m256i small = _mm256_min_epi32(ax, ay), large = _mm256_max_epi32(_mm256_max_epi32(ax, ay), constant32(1));
  const __m256i dividend = _mm256_add_epi32(_mm256_slli_epi32(small, 7), _mm256_srli_epi32(large, 1));
  const __m256i ratio = _mm256_cvttps_epi32(_mm256_div_ps(_mm256_cvtepi32_ps(dividend), _mm256_cvtepi32_ps(large)));
  const __m256i acute = arc_tangents(ratio);
  const __m256i zero = _mm256_setzero_si256();
  const auto choose = [](__m256i mask, __m256i yes, __m256i no) { return _mm256_blendv_epi8(no, yes, mask); };
  __m256i level = choose(_mm256_cmpgt_epi32(ay, ax), _mm256_sub_epi32(constant32(64), acute), acute);
  level = choose(_mm256_cmpgt_epi32(zero, x), _mm256_sub_epi32(constant32(128), level), level);
  level = choose(_mm256_cmpgt_epi32(zero, y), _mm256_sub_epi32(constant32(256), level), level);
  return _mm256_and_si256(level, constant32(255));
}

// The lowest bytes of eight words.
static inline void store_lowest(uint8_t* out, __m256i words) {
  const __m256i shorts8 = _mm256_packus_epi32(words, words);
  const __m256i bytes8 = _mm256_packus_epi16(shorts8, shorts8);
  const __m128i both = _mm_unpacklo_epi32(_mm256_castsi256_si128(bytes8), _mm256_extracti128_si256(bytes8, 1));
  _mm_storel_epi64(reinterpret_cast<__m128i*>(out), both);
}

static void gradient_levels(const uint8_t* smoothed, int32_t width, const uint32_t* pixels, int32_t count,
                            uint8_t* levels) {
  const __m256i ones = _mm256_set1_epi16(1);
  const __m256i slope = constant32(0x000100ff), weight = constant32(0x00010201);  // -1 0 1 and 1 2 1
  for (int32_t i = 0; i < count; i += 8) {
    // Pixels x - 1 to x + 2 of a row, the last one without a weight.
    const auto row = [&](int32_t offset) {
      int32_t four[8];
      for (int k = 0; k < 8; ++k) {
        const auto x = static_cast<ptrdiff_t>(pixels[i + k] & 0xffff), y = static_cast<ptrdiff_t>(pixels[i + k] >> 16);
        __builtin_memcpy(four + k, smoothed + y * width + x + offset - 1, sizeof four[k]);
      }
      return _mm256_setr_epi32(four[0], four[1], four[2], four[3], four[4], four[5], four[6], four[7]);
    };
    const __m256i a = row(-width), b = row(0), c = row(width);
    const __m256i across = _mm256_maddubs_epi16(b, slope);
    const __m256i gx =
        _mm256_add_epi16(_mm256_add_epi16(_mm256_maddubs_epi16(a, slope), _mm256_maddubs_epi16(c, slope)),
                         _mm256_add_epi16(across, across));
    const __m256i gy = _mm256_sub_epi16(_mm256_maddubs_epi16(c, weight), _mm256_maddubs_epi16(a, weight));
    store_lowest(levels + i, binary_angles(_mm256_madd_epi16(gx, ones), _mm256_madd_epi16(gy, ones)));
  }
}

// raw_to_rect_q5 of four points u, v in pairs of words, on a map without gaps.
class RectLanes {
 public:
  explicit RectLanes(const LensMap& map)
      : nodes_(map.nodes),
        last_cell_(_mm256_set1_epi64x(pair(map.columns - 2, map.rows - 2))),
        steps_(_mm256_set1_epi64x(pair(1, map.columns))),
        middle_(_mm256_set1_epi64x(pair(map.middle_x, map.middle_y))),
        half_(constant32(1 << (map.shift + 8 - 5 - 1))),
        to_q5_(_mm_cvtsi32_si128(map.shift + 8 - 5)),
        row_(_mm256_set1_epi64x(map.columns)) {}

  __m256i rectified(__m256i uv) const {
    const __m256i cell =
        _mm256_min_epi32(_mm256_max_epi32(_mm256_srai_epi32(uv, 8), _mm256_setzero_si256()), last_cell_);
    const __m256i fraction = _mm256_sub_epi32(uv, _mm256_slli_epi32(cell, 8));  // Q8 of a cell
    const __m256i fu = _mm256_shuffle_epi32(fraction, 0xa0), fv = _mm256_shuffle_epi32(fraction, 0xf5);
    // 256 - fu for the left node, fu for the right one.
    const __m256i weights = _mm256_blend_epi16(_mm256_sub_epi32(constant32(256), fu), _mm256_slli_epi32(fu, 16), 0xaa);
    const __m256i parts = _mm256_mullo_epi32(cell, steps_);
    const __m256i sum = _mm256_add_epi64(parts, _mm256_srli_epi64(parts, 32));
    const __m256i node = _mm256_and_si256(sum, _mm256_set1_epi64x(0xffffffff));
    const __m256i top = _mm256_madd_epi16(two_nodes(node), weights);
    const __m256i bottom = _mm256_madd_epi16(two_nodes(_mm256_add_epi64(node, row_)), weights);
    const __m256i slope = _mm256_srai_epi32(_mm256_sub_epi32(bottom, top), 4);
    const __m256i value = _mm256_add_epi32(top, _mm256_srai_epi32(_mm256_mullo_epi32(slope, fv), 4));
    const __m256i shift = _mm256_sra_epi32(_mm256_add_epi32(value, half_), to_q5_);
    return _mm256_add_epi32(_mm256_sub_epi32(uv, middle_), shift);
  }

 private:
  static int64_t pair(int32_t low, int32_t high) {
    return static_cast<int64_t>(static_cast<uint64_t>(static_cast<uint32_t>(high)) << 32 | static_cast<uint32_t>(low));
  }

  // x of both nodes, then y of both.
  __m256i two_nodes(__m256i node) const {
    const __m256i order = _mm256_set1_epi64x(0x0706030205040100);
    const __m256i upper = _mm256_set1_epi64x(0x0808080808080808);
    const __m256i both = _mm256_unpacklo_epi64(order, _mm256_add_epi8(order, upper));
    alignas(32) int64_t place[4], two[4];
    _mm256_store_si256(reinterpret_cast<__m256i*>(place), node);
    for (int k = 0; k < 4; ++k) __builtin_memcpy(two + k, nodes_ + 2 * place[k], sizeof two[k]);
    return _mm256_shuffle_epi8(_mm256_setr_epi64x(two[0], two[1], two[2], two[3]), both);
  }

  const int16_t* nodes_;
  __m256i last_cell_, steps_, middle_, half_;
  __m128i to_q5_;
  __m256i row_;
};

static int32_t rectify_pixels(const LensMap& map, const uint32_t* pixels, const uint8_t* levels, int32_t count,
                              rvdnav_edgel* out) {
  if (!map.complete) return plain::rectify_pixels(map, pixels, levels, count, out);
  const RectLanes lanes(map);
  struct Four {
    __m256i place, tangent;
  };
  const auto four = [&](int32_t i) -> Four {
    const __m128i pixel = _mm_loadu_si128(reinterpret_cast<const __m128i*>(pixels + i));
    const __m256i uv = _mm256_slli_epi32(_mm256_cvtepu16_epi32(pixel), 5);
    const auto step_of = [&](int k) {
      int32_t step = 0;
      __builtin_memcpy(&step, kTangent.step + levels[i + k], sizeof step);
      return step;
    };
    const __m256i step = _mm256_cvtepi16_epi32(_mm_setr_epi32(step_of(0), step_of(1), step_of(2), step_of(3)));
    const __m256i ahead = lanes.rectified(_mm256_add_epi32(uv, step));
    const __m256i behind = lanes.rectified(_mm256_sub_epi32(uv, step));
    return {lanes.rectified(uv), _mm256_sub_epi32(ahead, behind)};
  };
  for (int32_t i = 0; i < count; i += 8) {
    const Four first = four(i), second = four(i + 4);
    const __m256i size = _mm256_or_si256(_mm256_abs_epi32(first.tangent), _mm256_abs_epi32(second.tangent));
    if (_mm256_testz_si256(size, constant32(~0xffff)) == 0) {  // a lens beyond what binary_angles can do
      plain::rectify_pixels(map, pixels + i, levels + i, 8, out + i);
      continue;
    }
    const auto halves = [&](int control) {
      const __m256 a = _mm256_castsi256_ps(first.tangent), b = _mm256_castsi256_ps(second.tangent);
      const __m256 mixed = control == 0 ? _mm256_shuffle_ps(a, b, 0x88) : _mm256_shuffle_ps(a, b, 0xdd);
      return _mm256_permute4x64_epi64(_mm256_castps_si256(mixed), 0xd8);
    };
    const __m256i tx = halves(0), ty = halves(1);
    // The gradient is a quarter turn behind the tangent.
    const __m256i level = binary_angles(ty, _mm256_sub_epi32(_mm256_setzero_si256(), tx));
    alignas(32) int32_t place[16], direction[8];
    _mm256_store_si256(reinterpret_cast<__m256i*>(place), first.place);
    _mm256_store_si256(reinterpret_cast<__m256i*>(place + 8), second.place);
    _mm256_store_si256(reinterpret_cast<__m256i*>(direction), level);
    for (int32_t k = 0; k < 8; ++k)
      out[i + k] = {place[2 * k], place[2 * k + 1], static_cast<uint8_t>(direction[k]), {}};
  }
  return count;
}

// The votes of edgels that share their first row, in up to eight rows from `row` on.
class VoteLanes {
 public:
  VoteLanes(int32_t rho_bins, int32_t row, uint16_t* acc) : rho_bins_(rho_bins), row_(row), acc_(acc) {
    const __m256i rows = _mm256_add_epi32(constant32(row), reinterpret_cast<__m256i>(kLane));
    const __m256i wrapped = _mm256_cmpgt_epi32(rows, constant32(kThetaBins - 1));
    const __m256i own = _mm256_sub_epi32(rows, _mm256_and_si256(wrapped, constant32(kThetaBins)));
    start_ = _mm256_mullo_epi32(own, constant32(rho_bins));
    cosine_ = load256(kHoughRows.c + row);
    sine_ = load256(kHoughRows.s + row);
  }

  template <int32_t kRows>
  void vote(const rvdnav_edgel& e) const {
    const __m256i rho = _mm256_add_epi32(_mm256_mullo_epi32(constant32(e.x_q5), cosine_),
                                         _mm256_mullo_epi32(constant32(e.y_q5), sine_));
    const __m256i rounded = _mm256_srai_epi32(_mm256_add_epi32(rho, constant32(1 << 18)), 19);
    const __m256i cell = _mm256_add_epi32(rounded, constant32(rho_bins_ / 2));
    const __m256i inside = _mm256_cmpeq_epi32(_mm256_min_epu32(cell, constant32(rho_bins_ - 1)), cell);
    const bool near =
        static_cast<uint32_t>(e.x_q5) + kFar < 2 * kFar && static_cast<uint32_t>(e.y_q5) + kFar < 2 * kFar;
    if (!near || _mm256_movemask_epi8(inside) != -1) return plain::vote_some(e, rho_bins_, row_, kRows, acc_);
    alignas(32) uint32_t place[8];
    _mm256_store_si256(reinterpret_cast<__m256i*>(place), _mm256_add_epi32(cell, start_));
#pragma GCC unroll 8
    for (int32_t n = 0; n < kRows; ++n) ++acc_[place[n]];
  }

  void vote(const rvdnav_edgel& e, int32_t rows) const {
    if (rows >= 8) return vote<8>(e);
    if (rows == 7) return vote<7>(e);  // the usual spread
    plain::vote_some(e, rho_bins_, row_, rows, acc_);
  }

 private:
  static constexpr uint32_t kFar = 1 << 16;  // Q5; nearer, products of Q5 and Q14 and their sum fit 32 bits
  int32_t rho_bins_, row_;
  uint16_t* acc_;
  __m256i start_, cosine_, sine_;
};

// Edgels go by their first row, some at a time: so that their votes fall where the cache holds the accumulator.
static void vote(const rvdnav_edgel* edgels, uint32_t count, int32_t rho_bins, int32_t spread, uint16_t* acc) {
  constexpr uint32_t kAtOnce = 2048;
  uint8_t first_row[256];
  for (int32_t level = 0; level < 256; ++level) {
    const int32_t first = theta_row(static_cast<uint8_t>(level)) - spread;
    first_row[level] = static_cast<uint8_t>(first < 0 ? first + kThetaBins : first);
  }
  for (uint32_t begin = 0; begin < count; begin += kAtOnce) {
    const uint32_t n = count - begin < kAtOnce ? count - begin : kAtOnce;
    uint16_t order[kAtOnce], next[kThetaBins + 1] = {};  // next[r + 1] counts row r, then says where it goes on
    for (uint32_t i = 0; i < n; ++i) ++next[first_row[edgels[begin + i].direction] + 1];
    for (int32_t row = 0; row < kThetaBins; ++row) next[row + 1] = static_cast<uint16_t>(next[row + 1] + next[row]);
    for (uint32_t i = 0; i < n; ++i) order[next[first_row[edgels[begin + i].direction]]++] = static_cast<uint16_t>(i);
    for (int32_t row = 0; row < kThetaBins; ++row) {  // next[r] is now where row r ends
      const uint32_t from = row > 0 ? next[row - 1] : 0, to = next[row];
      for (int32_t k = 0; from < to && k <= 2 * spread; k += 8) {
        const VoteLanes lanes(rho_bins, row + k, acc);
        for (uint32_t i = from; i < to; ++i) lanes.vote(edgels[begin + order[i]], 2 * spread + 1 - k);
      }
    }
  }
}
