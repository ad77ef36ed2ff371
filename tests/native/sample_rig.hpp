// A stereo rig with a marked lens and cameras that squint, for the tests.
#pragma once

#include <cmath>

#include "rvdnav/rvdnav.h"

inline rvdnav_rig sample_rig() {
  rvdnav_rig rig = {};
  rig.struct_size = sizeof rig;
  rig.width = 704;
  rig.height = 576;
  rig.camera_count = 2;
  rig.focal_rect = 670.0;
  rig.baseline = 0.12;
  rig.camera[0] = {668.0, 669.0, 356.8, 283.4, -0.2034, 0.0617, 0.00052, -0.00041, {}};
  rig.camera[1] = {672.0, 672.5, 347.3, 291.9, -0.1987, 0.0583, -0.00038, 0.00055, {}};
  for (int i = 0; i < 2; ++i) {
    // A turn about x and then one about y.
    const double a = i == 0 ? -0.003 : 0.004, b = i == 0 ? 0.014 : -0.0126;
    const double R[9] = {
        std::cos(b),  std::sin(a) * std::sin(b), std::cos(a) * std::sin(b), 0.0, std::cos(a), -std::sin(a),
        -std::sin(b), std::sin(a) * std::cos(b), std::cos(a) * std::cos(b)};
    for (int k = 0; k < 9; ++k) rig.camera[i].R_rect_cam[k] = R[k];
  }
  return rig;
}
