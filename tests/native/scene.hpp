// A drawn bracket in front of a stereo rig without distortion, as everyone outside the library would set it up.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "rvdnav/rvdnav.h"

namespace scene {

constexpr int kWidth = 704;
constexpr int kHeight = 576;
constexpr double kFocal = 670.0;
constexpr double kBaseline = 0.12;

inline rvdnav_rig rig(int32_t cameras = 2) {
  rvdnav_rig r = {};
  r.struct_size = sizeof(r);
  r.width = kWidth;
  r.height = kHeight;
  r.camera_count = cameras;
  r.focal_rect = kFocal;
  r.baseline = cameras == 2 ? kBaseline : 0.0;
  for (rvdnav_camera& c : r.camera) {
    c.fx = c.fy = kFocal;
    c.cx = 0.5 * (kWidth - 1);
    c.cy = 0.5 * (kHeight - 1);
    c.R_rect_cam[0] = c.R_rect_cam[4] = c.R_rect_cam[8] = 1.0;
  }
  return r;
}

// Long base 180 mm, short base 90 mm, height 140 mm, bars 14 mm wide and 6 mm thick.
inline rvdnav_target target() {
  constexpr double kOuter[4][3] = {{0, -0.090, 0}, {0, 0.090, 0}, {0, 0.045, 0.140}, {0, -0.045, 0.140}};
  constexpr double kInner[4][3] = {
      {0, -0.070794559, 0.014}, {0, 0.070794559, 0.014}, {0, 0.034794559, 0.126}, {0, -0.034794559, 0.126}};
  rvdnav_target t = {};
  t.struct_size = sizeof(t);
  t.thickness = 0.006;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k) {
      t.outer[i][k] = kOuter[i][k];
      t.inner[i][k] = kInner[i][k];
    }
  }
  return t;
}

inline rvdnav_config config(int32_t isa = RVDNAV_ISA_AUTO) {
  rvdnav_config c = {};
  c.struct_size = sizeof(c);
  if (rvdnav_config_default(&c) != RVDNAV_OK) std::abort();
  c.isa = isa;
  return c;
}

// A context in memory of its own.
struct Owner {
  explicit Owner(const rvdnav_config& config, const rvdnav_rig& rig, const rvdnav_target* target) {
    status = rvdnav_context_size(&config, &rig, &size);
    if (status != RVDNAV_OK) return;
    memory.reset(std::aligned_alloc(64, (size + kGuard + 63) / 64 * 64));
    auto* end = static_cast<uint8_t*>(memory.get()) + size;
    for (size_t i = 0; i < kGuard; ++i) end[i] = kPattern;
    status = rvdnav_context_init(memory.get(), size, &config, &rig, target, &context);
  }

  // Nothing was written behind the size asked for.
  bool guard_intact() const {
    const auto* end = static_cast<const uint8_t*>(memory.get()) + size;
    for (size_t i = 0; i < kGuard; ++i) {
      if (end[i] != kPattern) return false;
    }
    return true;
  }

  static constexpr size_t kGuard = 4096;
  static constexpr uint8_t kPattern = 0xa5;
  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  std::unique_ptr<void, Free> memory;
  size_t size = 0;
  rvdnav_status status = RVDNAV_OK;
  rvdnav_context* context = nullptr;
};

// Where the bracket stands: turned about y_W by angle, at (range, y, z) in W.
struct Placement {
  double range, y, z, angle;
};

inline bool inside(const double corners[4][3], double y, double z) {
  for (int i = 0; i < 4; ++i) {
    const double* a = corners[i];
    const double* b = corners[(i + 1) % 4];
    if ((b[1] - a[1]) * (z - a[2]) - (b[2] - a[2]) * (y - a[1]) < 0.0) return false;
  }
  return true;
}

// Four samples a pixel of the bracket's front face, grey 170 on 40.
inline std::vector<uint8_t> draw(int camera, const Placement& at) {
  const rvdnav_target t = target();
  const double c = std::cos(at.angle);
  const double s = std::sin(at.angle);
  std::vector<uint8_t> pixels(static_cast<size_t>(kWidth) * kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      int hits = 0;
      for (int sample = 0; sample < 4; ++sample) {
        const double x = (u - 0.5 * (kWidth - 1) + (sample % 2 == 0 ? -0.25 : 0.25)) / kFocal;
        const double y = (v - 0.5 * (kHeight - 1) + (sample / 2 == 0 ? -0.25 : 0.25)) / kFocal;
        // In W the ray is (1, y, -x) from (0, 0, z0); x_C = (c, 0, -s), z_C = (s, 0, c).
        const double z0 = (camera == 0 ? kBaseline : 0.0) - at.z;
        const double depth = (c * at.range + s * z0) / (c + s * x);
        const double px = depth - at.range;
        const double pz = z0 - depth * x;
        const double yc = depth * y - at.y;
        const double zc = s * px + c * pz;
        hits += inside(t.outer, yc, zc) && !inside(t.inner, yc, zc);
      }
      pixels[static_cast<size_t>(v) * kWidth + static_cast<size_t>(u)] = static_cast<uint8_t>(40 + hits * 130 / 4);
    }
  }
  return pixels;
}

inline rvdnav_image image(const std::vector<uint8_t>& pixels) { return {pixels.data(), kWidth, kHeight, kWidth}; }

}  // namespace scene
