// Elementary functions from + - * / and the square root alone, which IEEE 754 defines to the last bit: every build and
// processor gives the same result, where a C library's functions differ with its version and with fused multiply-add.
#pragma once

#if defined(__FAST_MATH__)
#error "rvdnav needs IEEE arithmetic: build it without -ffast-math"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0
#error "rvdnav needs doubles that are rounded after every operation: on 32-bit x86 build it with -msse2 -mfpmath=sse"
#endif

namespace rvdnav {
namespace math {

// Arguments in radians, up to 2^20 in size; NaN beyond.  Within 1 ulp.
double sin(double x);
double cos(double x);

// Within 2 ulp.
double atan(double x);

// The angle of the finite vector (x, y) from +x towards +y, in [-pi, pi], zeros signed as in C.  Within 2 ulp.
double atan2(double y, double x);

// Within 1 ulp.
double exp(double x);
double log(double x);

// 1 - erf(x).  Within 4 ulp; what is below 1e-307, to as many digits as the number has.
double erfc(double x);

}  // namespace math
}  // namespace rvdnav
