// The row kernels for the build's own instruction set.
#include "angle.hpp"
#include "hough.hpp"
#include "hough_trig.hpp"
#include "integers.hpp"
#include "kernels/kernel_sets.hpp"
#include "tangent.hpp"

namespace rvdnav {
namespace scalar {
#include "kernels/edgel_kernels.inl"
#include "kernels/row_kernels.inl"
}  // namespace scalar

const Kernels kScalarKernels = {RVDNAV_ISA_SCALAR,      scalar::smooth_row,    scalar::gradient_row,
                                scalar::ridge_row,      scalar::deletable_row, scalar::touching_row,
                                scalar::light_row,      scalar::high_cells,    scalar::gradient_levels,
                                scalar::rectify_pixels, scalar::vote};

}  // namespace rvdnav
