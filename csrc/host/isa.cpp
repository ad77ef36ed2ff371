// The instruction set that the user asks for by an environment variable.
#include <cstdlib>
#include <cstring>

#include "rvdnav/rvdnav.h"

rvdnav_status rvdnav_host_isa(int32_t* isa) {
  if (isa == nullptr) return RVDNAV_ERROR_NULL;
  const char* name = std::getenv("RVDNAV_FORCE_ISA");
  if (name == nullptr || *name == '\0') {
    *isa = RVDNAV_ISA_AUTO;
  } else if (std::strcmp(name, "scalar") == 0) {
    *isa = RVDNAV_ISA_SCALAR;
  } else if (std::strcmp(name, "sse2") == 0) {
    *isa = RVDNAV_ISA_SSE2;
  } else if (std::strcmp(name, "avx2") == 0) {
    *isa = RVDNAV_ISA_AVX2;
  } else if (std::strcmp(name, "neon") == 0) {
    *isa = RVDNAV_ISA_NEON;
  } else {
    return RVDNAV_ERROR_ISA;
  }
  return RVDNAV_OK;
}
