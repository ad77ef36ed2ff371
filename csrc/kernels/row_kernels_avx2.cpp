// The row kernels for AVX2; the build gives this file alone the flag that allows it.
#include "kernels/kernel_sets.hpp"

#if RVDNAV_BUILD_AVX2
#ifndef __AVX2__
#error "compile this file for AVX2"
#endif

namespace rvdnav {
namespace avx2 {
#include "kernels/row_kernels.inl"
}  // namespace avx2

const Kernels kAvx2Kernels = {RVDNAV_ISA_AVX2, avx2::smooth_row, avx2::gradient_row, avx2::ridge_row};

}  // namespace rvdnav
#endif
