// The integer stages with memory of their own, for the programs beside OpenCV.
#pragma once

#include <vector>

#include "edge.hpp"
#include "hough.hpp"
#include "lens_map.hpp"
#include "peaks.hpp"
#include "rectify.hpp"
#include "smooth.hpp"
#include "thin.hpp"

namespace rvdnav {

// A lens and a squint like the example's, for images of any size.
inline rvdnav_rig typical_rig(int32_t width, int32_t height) {
  rvdnav_rig rig = {};
  rig.struct_size = sizeof rig;
  rig.width = width;
  rig.height = height;
  rig.camera_count = 1;
  rig.focal_rect = 0.95 * width;
  const double c = 0.9999, s = 0.014141782;  // 0.8 degrees about y
  rig.camera[0] = {0.95 * width,   0.951 * width, 0.507 * width,
                   0.492 * height, -0.2034,       0.0617,
                   0.00052,        -0.00041,      {c, 0, s, 0, 1, 0, -s, 0, c}};
  return rig;
}

// A pinhole that looks straight ahead: rectified pixels are raw ones from the middle of the image.
inline rvdnav_rig pinhole_rig(int32_t width, int32_t height) {
  rvdnav_rig rig = typical_rig(width, height);
  rig.focal_rect = width;
  rig.camera[0] = {1.0 * width, 1.0 * width, (width - 1) / 2.0,          (height - 1) / 2.0, 0, 0,
                   0,           0,           {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  return rig;
}

class Stages {
 public:
  static constexpr int32_t kRhoBins = 1024;

  Stages(const rvdnav_rig& rig, const Kernels& kernels)
      : width_(rig.width),
        height_(rig.height),
        kernels_(kernels),
        nodes_(map_length(rig.width, rig.height)),
        smooth_row_(size(rig.width) + 2),
        magnitude_(3 * edge_scratch_row(size(rig.width))),
        code_(magnitude_.size()),
        deletable_(size(edge_row_words(rig.width))),
        empty_(deletable_.size()),
        stale_(size(rig.height)),
        kept_(size(edge_row_words(rig.width)) * size(rig.height)),
        smoothed(size(rig.width) * size(rig.height)),
        bits(kept_.size()),
        edgels(65536),
        accumulator(size(kThetaBins * kRhoBins)),
        peaks(512) {
    mapped_ = build_lens_map(rig, 0, nodes_.data(), &map_);
  }

  bool mapped() const { return mapped_; }
  const LensMap& map() const { return map_; }

  void run_smooth(const uint8_t* image) {
    smooth({image, width_, height_, width_}, kernels_, smooth_row_.data(), smoothed.data());
  }
  void run_edges() {
    detect_edges(smoothed.data(), width_, height_, make_threshold_curve(6, 26, 160), kernels_,
                 {magnitude_.data(), code_.data()}, bits.data());
  }
  void run_thin() {
    filter_edges(bits.data(), width_, height_, 6, kernels_, kept_.data());
    thin(bits.data(), width_, height_, kernels_, {deletable_.data(), empty_.data(), stale_.data()});
  }
  void run_rectify() {
    edgels.resize(65536);
    uint32_t total = 0;
    edgels.resize(
        rectify_gradients(bits.data(), smoothed.data(), width_, height_, map_, kernels_, edgels.data(), 65536, &total));
  }
  void run_vote() {
    hough_vote(edgels.data(), static_cast<uint32_t>(edgels.size()), kRhoBins, 3, kernels_, accumulator.data());
  }
  void run_peaks() {
    peaks.resize(512);
    uint32_t total = 0;
    peaks.resize(hough_peaks(accumulator.data(), kRhoBins, 18, kernels_, peaks.data(), 512, &total));
  }
  bool edge(int32_t x, int32_t y) const {
    return (bits[size(y) * size(edge_row_words(width_)) + size(x / 32)] >> (x % 32) & 1) != 0;
  }

 private:
  static size_t size(int32_t n) { return static_cast<size_t>(n); }

  int32_t width_, height_;
  const Kernels& kernels_;
  bool mapped_ = false;
  LensMap map_ = {};
  std::vector<int16_t> nodes_;
  std::vector<uint16_t> smooth_row_;
  std::vector<int16_t> magnitude_;
  std::vector<uint8_t> code_;
  std::vector<uint32_t> deletable_, empty_;
  std::vector<uint8_t> stale_;
  std::vector<uint32_t> kept_;

 public:
  std::vector<uint8_t> smoothed;
  std::vector<uint32_t> bits;
  std::vector<rvdnav_edgel> edgels;
  std::vector<uint16_t> accumulator;
  std::vector<rvdnav_peak> peaks;
};

}  // namespace rvdnav
