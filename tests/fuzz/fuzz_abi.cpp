// libFuzzer over the C ABI: structures with numbers from the input go through initialisation, a frame with and without
// windows, and the stages that take geometry.  Whatever is accepted must run; the sanitizers watch.
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "rvdnav/rvdnav.h"

namespace {

// Bytes of the input, zeros when it is used up.
class Input {
 public:
  Input(const uint8_t* data, size_t size) : data_(data), size_(size) {}

  template <typename T>
  T take() {
    T value = {};
    const size_t n = size_ < sizeof(T) ? size_ : sizeof(T);
    if (n > 0) std::memcpy(&value, data_, n);
    data_ += n;
    size_ -= n;
    return value;
  }
  bool empty() const { return size_ == 0; }

 private:
  const uint8_t* data_;
  size_t size_;
};

struct Free {
  void operator()(void* p) const { std::free(p); }
};
using Memory = std::unique_ptr<void, Free>;

Memory aligned(size_t size) { return Memory(std::aligned_alloc(64, (size + 64) / 64 * 64)); }

[[noreturn]] void broken() { std::abort(); }

rvdnav_config base_config() {
  rvdnav_config config = {};
  config.struct_size = sizeof(config);
  if (rvdnav_config_default(&config) != RVDNAV_OK) broken();
  config.max_edgels = 1024;  // less memory to poison
  return config;
}

rvdnav_rig base_rig() {
  rvdnav_rig rig = {};
  rig.struct_size = sizeof(rig);
  rig.width = 40;
  rig.height = 32;
  rig.camera_count = RVDNAV_CAMERAS;
  rig.focal_rect = 40.0;
  rig.baseline = 0.1;
  for (rvdnav_camera& c : rig.camera) c = {40.0, 40.0, 19.5, 15.5, -0.1, 0.02, 1e-4, 1e-4, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  return rig;
}

rvdnav_target base_target() {
  rvdnav_target target = {};
  target.struct_size = sizeof(target);
  target.thickness = 0.01;
  constexpr double kSide[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 2; ++k) {
      target.outer[i][k + 1] = 0.2 * kSide[i][k];
      target.inner[i][k + 1] = 0.15 * kSide[i][k];
    }
  }
  return target;
}

// Overwrites up to `most` aligned words of a structure, never its first one, struct_size; pointers have words of their
// own at the end, which `usable` leaves out.
template <typename T>
void disturb(Input& input, size_t usable, uint32_t most, T* out) {
  auto* bytes = reinterpret_cast<uint8_t*>(out);
  for (uint32_t n = input.take<uint8_t>() % (most + 1); n > 0; --n) {
    const uint8_t kind = input.take<uint8_t>();
    const size_t word = 1 + input.take<uint8_t>() % (usable / 4 - 1);
    if (kind % 4 == 0) {
      const auto value = input.take<int32_t>();
      std::memcpy(bytes + 4 * word, &value, sizeof value);
    } else if (kind % 4 == 1) {
      const int32_t value = input.take<int8_t>();
      std::memcpy(bytes + 4 * word, &value, sizeof value);
    } else if (4 * (word & ~size_t{1}) + 8 <= usable && word > 1) {
      double value = input.take<double>();
      if (kind % 4 == 3) value = input.take<int16_t>() / 256.0;
      std::memcpy(bytes + 4 * (word & ~size_t{1}), &value, sizeof value);
    }
  }
}

// Rectangles, one on another, and noise.
std::vector<uint8_t> picture(Input& input, int32_t width, int32_t height) {
  std::vector<uint8_t> pixels(static_cast<size_t>(width) * static_cast<size_t>(height), input.take<uint8_t>());
  for (uint32_t n = input.take<uint8_t>() % 16; n > 0; --n) {
    const int32_t x = input.take<uint8_t>() % width, y = input.take<uint8_t>() % height;
    const int32_t w = input.take<uint8_t>(), h = input.take<uint8_t>();
    const uint8_t grey = input.take<uint8_t>();
    for (int32_t v = y; v < height && v < y + h; ++v)
      for (int32_t u = x; u < width && u < x + w; ++u) pixels[static_cast<size_t>(v * width + u)] = grey;
  }
  const uint32_t noise = input.take<uint8_t>() % 32;
  uint32_t state = input.take<uint32_t>();
  for (uint8_t& p : pixels) {
    state = state * 1664525U + 1013904223U;
    if (noise > 0) p = static_cast<uint8_t>(p + (state >> 16) % noise);
  }
  return pixels;
}

void run_frame(Input& input, rvdnav_context* context, const rvdnav_rig& rig) {
  std::vector<uint8_t> pixels[2];
  rvdnav_image images[2];
  for (int32_t camera = 0; camera < rig.camera_count; ++camera) {
    pixels[camera] = picture(input, rig.width, rig.height);
    images[camera] = {pixels[camera].data(), rig.width, rig.height, rig.width};
  }
  const bool stereo = rig.camera_count == RVDNAV_CAMERAS;
  constexpr int32_t kWindows = 2;  // each takes a while
  rvdnav_window windows[kWindows];
  for (int32_t i = 0; i < kWindows; ++i) {
    windows[i] = {i, 0, -12.0, i % 2 == 0 ? 0.0 : 1.57, 3.0, 0.1, -10.0, 10.0};
    disturb(input, sizeof(windows[i]), 2, &windows[i]);
  }
  for (const uint32_t count : {0U, static_cast<uint32_t>(kWindows)}) {
    rvdnav_view_result views[2] = {};
    bool good = true;
    for (int32_t camera = 0; camera < rig.camera_count; ++camera) {
      views[camera].struct_size = sizeof(views[camera]);
      const rvdnav_status status = rvdnav_view(context, camera, &images[camera], windows, count, &views[camera]);
      if (status != RVDNAV_OK && count == 0) broken();
      good = good && status == RVDNAV_OK;
    }
    rvdnav_frame_result frame = {};
    frame.struct_size = sizeof(frame);
    if (!good) continue;
    if (rvdnav_join(context, &images[0], stereo ? &images[1] : nullptr, &views[0], stereo ? &views[1] : nullptr,
                    count == 0 ? 1 : 0, &frame) != RVDNAV_OK)
      broken();
  }

  rvdnav_model_edge edge = {-12.0, -10.0, -11.0, 10.0, 4.0, 0.0, 0, 0};
  disturb(input, sizeof(edge), 3, &edge);
  rvdnav_edge_sample samples[16];
  uint32_t count = 0;
  rvdnav_measure_edges(context, 0, &images[0], &edge, 1, 3.5, 1.0, 0.0, samples, 16, &count);
  if (!stereo) return;
  rvdnav_match match = {};
  match.x = edge.x0;
  match.y = edge.y0;
  match.bar = -1;
  rvdnav_correlate(context, &images[0], &images[1], &match, 1);
  const double left[2] = {edge.x0, edge.y0}, right[2] = {edge.x1, edge.y1};
  double p_W[3];
  rvdnav_triangulate(context, left, right, 1, p_W);
  if (input.take<uint8_t>() % 32 != 0) return;
  size_t size = 0;
  if (rvdnav_surface_size(context, &size) != RVDNAV_OK) broken();
  const Memory memory = aligned(size);
  std::vector<rvdnav_surface_point> points(256);
  uint32_t crossings = 0;
  rvdnav_surface(context, &images[0], &images[1], memory.get(), size, points.data(), 256, &count, &crossings);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Input input(data, size);
  rvdnav_config config = base_config();
  disturb(input, offsetof(rvdnav_config, clock), 4, &config);
  rvdnav_rig rig = base_rig();
  disturb(input, sizeof(rig), 4, &rig);
  rvdnav_target target = base_target();
  disturb(input, sizeof(target), 3, &target);

  size_t needed = 0;
  if (rvdnav_context_size(&config, &rig, &needed) != RVDNAV_OK) return 0;
  constexpr size_t kMostMemory = 64 << 20;
  constexpr int32_t kMostPixels = 8192;  // a frame takes a millisecond
  if (needed > kMostMemory || rig.width * rig.height > kMostPixels) return 0;
  const Memory memory = aligned(needed);
  rvdnav_context* context = nullptr;
  if (rvdnav_context_init(memory.get(), needed, &config, &rig, nullptr, &context) != RVDNAV_OK) return 0;
  rvdnav_context_set_target(context, &target);
  run_frame(input, context, rig);
  return 0;
}
