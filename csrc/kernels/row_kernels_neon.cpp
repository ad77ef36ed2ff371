// The row kernels for NEON, which every 64-bit Arm processor has.
#include "kernels/kernel_sets.hpp"

#if RVDNAV_BUILD_NEON

namespace rvdnav {
namespace neon {
#include "kernels/row_kernels.inl"
}  // namespace neon

const Kernels kNeonKernels = {RVDNAV_ISA_NEON, neon::smooth_row, neon::gradient_row, neon::ridge_row};

}  // namespace rvdnav
#endif
