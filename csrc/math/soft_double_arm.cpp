// The compiler's own functions for sums and conversions of doubles on an Arm without a floating-point unit, in place of
// those in libgcc, whose difference may be wrong in its last bit where the numbers' exponents are 33 apart (seen in GCC
// 12). libgcc has them in one object file, so they are all here: a program gets the ones or the others.
#include "math/soft_double.hpp"

#if defined(__arm__) && defined(__SOFTFP__)

namespace soft = rvdnav::soft;

// Without floating point a double is passed as its bits are.
extern "C" {

uint64_t __aeabi_dadd(uint64_t a, uint64_t b) { return soft::add(a, b); }
uint64_t __aeabi_dsub(uint64_t a, uint64_t b) { return soft::add(a, b ^ soft::kSign); }
uint64_t __aeabi_drsub(uint64_t a, uint64_t b) { return soft::add(a ^ soft::kSign, b); }
uint64_t __aeabi_i2d(int32_t value) { return soft::from_signed(value); }
uint64_t __aeabi_ui2d(uint32_t value) { return soft::from_magnitude(0, value); }
uint64_t __aeabi_l2d(int64_t value) { return soft::from_signed(value); }
uint64_t __aeabi_ul2d(uint64_t value) { return soft::from_magnitude(0, value); }
uint64_t __aeabi_f2d(uint32_t bits) { return soft::from_float(bits); }

// Their names on other processors.
uint64_t __adddf3(uint64_t a, uint64_t b) __attribute__((alias("__aeabi_dadd")));
uint64_t __subdf3(uint64_t a, uint64_t b) __attribute__((alias("__aeabi_dsub")));
uint64_t __floatsidf(int32_t value) __attribute__((alias("__aeabi_i2d")));
uint64_t __floatunsidf(uint32_t value) __attribute__((alias("__aeabi_ui2d")));
uint64_t __floatdidf(int64_t value) __attribute__((alias("__aeabi_l2d")));
uint64_t __floatundidf(uint64_t value) __attribute__((alias("__aeabi_ul2d")));
uint64_t __extendsfdf2(uint32_t bits) __attribute__((alias("__aeabi_f2d")));

}  // extern "C"

#endif
