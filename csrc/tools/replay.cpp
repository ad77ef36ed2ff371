// Hashes the output of every integer stage on raw frames, to compare builds and processors bit by bit.
//
// replay RIG [ISA] LEFT.pgm RIGHT.pgm [LEFT.pgm RIGHT.pgm ...]
//
// RIG is a text file of numbers: width height focal_rect baseline, then for each of the two cameras fx fy cx cy k1 k2
// p1 p2 and the nine elements of R_rect_cam, row by row.  ISA is scalar, sse2, avx2 or neon, default the best there is.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "rvdnav/rvdnav.h"

namespace {

constexpr int kThetaRows = 180;
constexpr size_t kAlignment = 64;  // of the memory that the library is given

[[noreturn]] void fail(const char* what, const char* detail) {
  std::fprintf(stderr, "replay: %s: %s\n", what, detail);
  std::exit(2);
}

void check(rvdnav_status status, const char* what) {
  if (status != RVDNAV_OK) fail(what, rvdnav_status_text(status));
}

// FNV-1a, 64 bits.
class Hash {
 public:
  void add(const void* data, size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (size_t i = 0; i < size; ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3ULL;
  }
  unsigned long long value() const { return value_; }

 private:
  unsigned long long value_ = 0xcbf29ce484222325ULL;
};

template <typename T>
void print(int frame, int camera, const char* stage, const std::vector<T>& data) {
  Hash hash;
  hash.add(data.data(), data.size() * sizeof(T));
  std::printf("%d %d %-12s %016llx\n", frame, camera, stage, hash.value());
}

double read_number(std::FILE* file, const char* path) {
  double value = 0.0;
  if (std::fscanf(file, "%lf", &value) != 1) fail(path, "not a rig file");
  return value;
}

rvdnav_rig read_rig(const char* path) {
  std::FILE* file = std::fopen(path, "r");
  if (file == nullptr) fail(path, "cannot be read");
  rvdnav_rig rig = {};
  rig.struct_size = sizeof(rig);
  rig.camera_count = RVDNAV_CAMERAS;
  rig.width = static_cast<int32_t>(read_number(file, path));
  rig.height = static_cast<int32_t>(read_number(file, path));
  rig.focal_rect = read_number(file, path);
  rig.baseline = read_number(file, path);
  for (rvdnav_camera& c : rig.camera) {
    for (double* value : {&c.fx, &c.fy, &c.cx, &c.cy, &c.k1, &c.k2, &c.p1, &c.p2}) *value = read_number(file, path);
    for (double& value : c.R_rect_cam) value = read_number(file, path);
  }
  std::fclose(file);
  return rig;
}

std::vector<uint8_t> read_pgm(const char* path, const rvdnav_rig& rig) {
  std::FILE* file = std::fopen(path, "rb");
  if (file == nullptr) fail(path, "cannot be read");
  int width = 0;
  int height = 0;
  if (std::fscanf(file, "P5 %d %d 255", &width, &height) != 2 || std::fgetc(file) == EOF)
    fail(path, "not an 8-bit PGM");
  if (width != rig.width || height != rig.height) fail(path, "is not of the rig's size");
  std::vector<uint8_t> pixels(static_cast<size_t>(width) * static_cast<size_t>(height));
  if (std::fread(pixels.data(), 1, pixels.size(), file) != pixels.size()) fail(path, "is truncated");
  std::fclose(file);
  return pixels;
}

// The context and memory for the outputs of one view.
class Replay {
 public:
  Replay(const rvdnav_rig& rig, int32_t isa) : rig_(rig) {
    config_.struct_size = sizeof(config_);
    check(rvdnav_config_default(&config_), "config");
    config_.isa = isa;
    size_t size = 0;
    check(rvdnav_context_size(&config_, &rig, &size), "context");
    memory_.resize(size + kAlignment);
    void* block = memory_.data();
    size_t space = memory_.size();
    std::align(kAlignment, size, block, space);
    check(rvdnav_context_init(block, size, &config_, &rig, nullptr, &context_), "context");
    check(rvdnav_context_config(context_, &config_), "context");
  }

  void view(int frame, int camera, const std::vector<uint8_t>& pixels) {
    const rvdnav_image image = {pixels.data(), rig_.width, rig_.height, rig_.width};
    std::vector<uint8_t> smoothed(pixels.size());
    check(rvdnav_smooth(context_, camera, &image, smoothed.data()), "smooth");
    print(frame, camera, "smooth", smoothed);

    std::vector<uint32_t> bits(rvdnav_edge_row_words(rig_.width) * static_cast<size_t>(rig_.height));
    std::vector<uint8_t> direction(pixels.size());
    check(rvdnav_detect_edges(context_, camera, smoothed.data(), bits.data(), direction.data()), "detect_edges");
    print(frame, camera, "edges", bits);
    print(frame, camera, "direction", direction);

    check(rvdnav_filter_edges(context_, camera, bits.data()), "filter_edges");
    print(frame, camera, "filter", bits);
    check(rvdnav_thin(context_, camera, bits.data()), "thin");
    print(frame, camera, "thin", bits);

    uint32_t count = 0;
    std::vector<rvdnav_edgel> edgels(static_cast<size_t>(config_.max_edgels));
    check(rvdnav_rectify_edges(context_, camera, bits.data(), direction.data(), edgels.data(),
                               static_cast<uint32_t>(edgels.size()), &count),
          "rectify_edges");
    edgels.resize(count);
    print(frame, camera, "edgels", edgels);

    std::vector<uint16_t> accumulator(static_cast<size_t>(kThetaRows) * static_cast<size_t>(config_.hough_rho_bins));
    check(rvdnav_hough_vote(context_, edgels.data(), count, accumulator.data()), "hough_vote");
    print(frame, camera, "accumulator", accumulator);

    std::vector<rvdnav_peak> peaks(1U << 14);
    check(rvdnav_hough_peaks(context_, accumulator.data(), peaks.data(), static_cast<uint32_t>(peaks.size()), &count),
          "hough_peaks");
    peaks.resize(count);
    print(frame, camera, "peaks", peaks);
  }

  // The integers of the surface alone: its points in space are doubles.
  void surface(int frame, const std::vector<uint8_t>& left, const std::vector<uint8_t>& right) {
    const rvdnav_image l = {left.data(), rig_.width, rig_.height, rig_.width};
    const rvdnav_image r = {right.data(), rig_.width, rig_.height, rig_.width};
    size_t size = 0;
    check(rvdnav_surface_size(context_, &size), "surface_size");
    std::vector<unsigned char> memory(size + kAlignment);
    const size_t offset = (kAlignment - reinterpret_cast<uintptr_t>(memory.data()) % kAlignment) % kAlignment;
    std::vector<rvdnav_surface_point> points(left.size() / 8);
    uint32_t count = 0, crossings = 0;
    check(rvdnav_surface(context_, &l, &r, memory.data() + offset, size, points.data(),
                         static_cast<uint32_t>(points.size()), &count, &crossings),
          "surface");
    std::vector<int32_t> integers;
    for (uint32_t i = 0; i < count; ++i) {
      const rvdnav_surface_point& p = points[i];
      integers.insert(integers.end(), {p.x_q8, p.y_q8, p.disparity_q8, p.score_q15, p.grey});
    }
    print(frame, 0, "surface", integers);
  }

 private:
  rvdnav_rig rig_;
  rvdnav_config config_ = {};
  std::vector<unsigned char> memory_;
  rvdnav_context* context_ = nullptr;
};

int32_t isa_by_name(const char* name) {
  if (std::strcmp(name, "scalar") == 0) return RVDNAV_ISA_SCALAR;
  if (std::strcmp(name, "sse2") == 0) return RVDNAV_ISA_SSE2;
  if (std::strcmp(name, "avx2") == 0) return RVDNAV_ISA_AVX2;
  if (std::strcmp(name, "neon") == 0) return RVDNAV_ISA_NEON;
  return RVDNAV_ISA_AUTO;
}

}  // namespace

int main(int argc, char** argv) {
  int next = 1;
  if (argc < 4) fail("usage", "replay RIG [scalar|sse2|avx2|neon] LEFT.pgm RIGHT.pgm ...");
  const rvdnav_rig rig = read_rig(argv[next++]);
  const int32_t isa = isa_by_name(argv[next]);
  if (isa != RVDNAV_ISA_AUTO) ++next;
  if (next == argc || (argc - next) % 2 != 0) fail("usage", "images come in pairs");
  Replay replay(rig, isa);
  for (int frame = 0; next < argc; ++frame, next += 2) {
    const std::vector<uint8_t> views[2] = {read_pgm(argv[next], rig), read_pgm(argv[next + 1], rig)};
    for (int camera = 0; camera < 2; ++camera) replay.view(frame, camera, views[camera]);
    replay.surface(frame, views[0], views[1]);
  }
  return 0;
}
