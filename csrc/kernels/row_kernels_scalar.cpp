// The row kernels for the build's own instruction set.
#include "kernels/kernel_sets.hpp"

namespace rvdnav {
namespace scalar {
#include "kernels/row_kernels.inl"
}  // namespace scalar

const Kernels kScalarKernels = {RVDNAV_ISA_SCALAR, scalar::smooth_row, scalar::gradient_row, scalar::ridge_row,
                                scalar::deletable_row};

}  // namespace rvdnav
