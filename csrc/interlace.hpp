// What tells images of two fields, whose rows were exposed alternately at two times, from others.
#pragma once

#include "rvdnav/rvdnav.h"
#include "types.hpp"

namespace rvdnav {

// Tiles with edges and those of them whose odd rows are displaced along the rows against the even ones, all alike; and
// pairs of rows that are nearly equal.  struct_size is left as it is.
void find_fields(const GreyView& image, rvdnav_fields* fields);

}  // namespace rvdnav
