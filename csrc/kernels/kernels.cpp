#include "kernels/kernels.hpp"

#include "kernels/kernel_sets.hpp"

namespace rvdnav {

const Kernels* select_kernels(int32_t isa) {
  if (isa == RVDNAV_ISA_SCALAR) return &kScalarKernels;
#if RVDNAV_BUILD_X86
  __builtin_cpu_init();
  const bool has_avx2 = __builtin_cpu_supports("avx2");
  if (has_avx2 && (isa == RVDNAV_ISA_AVX2 || isa == RVDNAV_ISA_AUTO)) return &kAvx2Kernels;
  if (isa == RVDNAV_ISA_SSE2 || isa == RVDNAV_ISA_AUTO) return &kSse2Kernels;
#endif
#if RVDNAV_BUILD_NEON
  if (isa == RVDNAV_ISA_NEON || isa == RVDNAV_ISA_AUTO) return &kNeonKernels;
#endif
  return isa == RVDNAV_ISA_AUTO ? &kScalarKernels : nullptr;
}

}  // namespace rvdnav
