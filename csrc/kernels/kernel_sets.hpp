// Which sets of row kernels this build holds.
#pragma once

#include "kernels/kernels.hpp"
#include "rvdnav/rvdnav.h"

#if defined(__x86_64__)
#define RVDNAV_BUILD_X86 1
#else
#define RVDNAV_BUILD_X86 0
#endif
#if defined(__aarch64__)
#define RVDNAV_BUILD_NEON 1
#else
#define RVDNAV_BUILD_NEON 0
#endif

namespace rvdnav {

extern const Kernels kScalarKernels;
#if RVDNAV_BUILD_X86
extern const Kernels kSse2Kernels;
extern const Kernels kAvx2Kernels;
#endif
#if RVDNAV_BUILD_NEON
extern const Kernels kNeonKernels;
#endif

}  // namespace rvdnav
