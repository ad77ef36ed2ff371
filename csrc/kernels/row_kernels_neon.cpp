// The row kernels for NEON, which every 64-bit Arm processor has.
#include "kernels/kernel_sets.hpp"

#if RVDNAV_BUILD_NEON

#include <arm_neon.h>

#include "angle.hpp"
#include "hough.hpp"
#include "hough_trig.hpp"
#include "integers.hpp"
#include "tangent.hpp"

namespace rvdnav {
namespace neon {
namespace plain {
#include "kernels/edgel_kernels.inl"
#include "kernels/row_kernels.inl"
}  // namespace plain

using Bytes = uint8_t __attribute__((vector_size(16)));
using Shorts = int16_t __attribute__((vector_size(16)));
using UShorts = uint16_t __attribute__((vector_size(16)));
using Words = uint32_t __attribute__((vector_size(16)));
using Mask = uint16_t;

// The first and the last eight.
struct Pair {
  Shorts lo, hi;
};

static inline uint8x16_t raw(Bytes v) { return reinterpret_cast<uint8x16_t>(v); }
static inline uint16x8_t raw(UShorts v) { return reinterpret_cast<uint16x8_t>(v); }
static inline uint16x8_t raw(Shorts v) { return reinterpret_cast<uint16x8_t>(v); }
static inline Shorts shorts(uint16x8_t v) { return reinterpret_cast<Shorts>(v); }

static inline Pair widen(Bytes a) { return {shorts(vmovl_u8(vget_low_u8(raw(a)))), shorts(vmovl_high_u8(raw(a)))}; }
static inline Pair difference(Bytes a, Bytes b) {
  return {shorts(vsubl_u8(vget_low_u8(raw(a)), vget_low_u8(raw(b)))), shorts(vsubl_high_u8(raw(a), raw(b)))};
}
static inline Pair total(Bytes a, Bytes b) {
  return {shorts(vaddl_u8(vget_low_u8(raw(a)), vget_low_u8(raw(b)))), shorts(vaddl_high_u8(raw(a), raw(b)))};
}

static inline Bytes narrow(Pair v) {
  return reinterpret_cast<Bytes>(vuzp1q_u8(vreinterpretq_u8_u16(raw(v.lo)), vreinterpretq_u8_u16(raw(v.hi))));
}

static inline void store_pair(int16_t* p, Pair v) {
  vst1q_s16(p, vreinterpretq_s16_u16(raw(v.lo)));
  vst1q_s16(p + 8, vreinterpretq_s16_u16(raw(v.hi)));
}

static inline Shorts widen_at(const uint8_t* p) { return shorts(vmovl_u8(vld1_u8(p))); }

static inline Shorts high_product(UShorts a, uint16_t b) {
  const uint32x4_t lo = vmull_n_u16(vget_low_u16(raw(a)), b), hi = vmull_high_n_u16(raw(a), b);
  return shorts(vuzp2q_u16(vreinterpretq_u16_u32(lo), vreinterpretq_u16_u32(hi)));
}

static inline UShorts capped_sum(UShorts a, UShorts b) { return reinterpret_cast<UShorts>(vqaddq_u16(raw(a), raw(b))); }

using Sums = uint64x2_t;
static inline Sums add_up(Sums sums, Bytes v) { return vpadalq_u32(sums, vpaddlq_u16(vpaddlq_u8(raw(v)))); }
static inline uint64_t total_of(Sums sums) { return vaddvq_u64(sums); }

// Every word moved to the next or to the previous lane; a 0 comes in.
static inline Words one_lane_on(Words v) {
  return reinterpret_cast<Words>(vextq_u32(vdupq_n_u32(0), reinterpret_cast<uint32x4_t>(v), 3));
}
static inline Words one_lane_back(Words v) {
  return reinterpret_cast<Words>(vextq_u32(reinterpret_cast<uint32x4_t>(v), vdupq_n_u32(0), 1));
}

template <typename Vector>
static inline bool any(Vector v) {
  return vmaxvq_u32(reinterpret_cast<uint32x4_t>(v)) != 0;
}

static inline Mask mask_bits(Shorts lo, Shorts hi) {
  const uint8x16_t weight = {1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128};
  const uint8x16_t bits = vandq_u8(raw(narrow({lo, hi})), weight);
  return static_cast<Mask>(vaddv_u8(vget_low_u8(bits)) | vaddv_u8(vget_high_u8(bits)) << 8);
}

#include "kernels/lane_kernels.inl"
}  // namespace neon

const Kernels kNeonKernels = {RVDNAV_ISA_NEON,
                              neon::plain::smooth_row,
                              neon::gradient_row,
                              neon::ridge_row,
                              neon::deletable_row,
                              neon::touching_row,
                              neon::light_row,
                              neon::high_cells,
                              neon::plain::gradient_levels,
                              neon::plain::rectify_pixels,
                              neon::plain::vote};

}  // namespace rvdnav
#endif
