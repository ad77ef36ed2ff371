// libFuzzer over the C ABI: numbers and images from the input go through every function of it, part by part.  Whatever
// is accepted must run; the sanitizers watch.
#include "parts.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using Part = void (*)(Input&);
  constexpr Part kParts[] = {fuzz_frame,       fuzz_image_stages, fuzz_line_stages, fuzz_geometry,
                             fuzz_surface,     fuzz_images,       fuzz_edge_lines,  fuzz_pose,
                             fuzz_calibration, fuzz_library,      fuzz_measurement};
  Input input(data, size);
  kParts[input.below(sizeof kParts / sizeof *kParts)](input);
  return 0;
}
