// A number that tells an image from every other one.
#pragma once

#include "types.hpp"

namespace rvdnav {

// Of every bit and of the size; the same on all builds, for bytes of the order that these processors have.
uint64_t image_digest(const GreyView& image);

}  // namespace rvdnav
