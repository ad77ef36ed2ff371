// Finds the thinned edges of a bright square and prints how many pixels they have.
#include <rvdnav/rvdnav.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

namespace {

constexpr int kWidth = 320, kHeight = 240;

void check(rvdnav_status status) {
  if (status == RVDNAV_OK) return;
  std::fprintf(stderr, "rvdnav: %s\n", rvdnav_status_text(status));
  std::exit(1);
}

}  // namespace

int main() {
  rvdnav_config config = {};
  config.struct_size = sizeof(config);
  check(rvdnav_config_default(&config));
  rvdnav_rig rig = {};
  rig.struct_size = sizeof(rig);
  rig.width = kWidth;
  rig.height = kHeight;
  rig.camera_count = 1;
  rig.focal_rect = 300.0;
  rig.camera[0] = {300.0, 300.0, 159.5, 119.5, 0.0, 0.0, 0.0, 0.0, {1, 0, 0, 0, 1, 0, 0, 0, 1}};

  // The core works in memory that it is given, here with room to begin at a multiple of 64 bytes.
  size_t size = 0;
  check(rvdnav_context_size(&config, &rig, &size));
  size_t room = size + 64;
  std::vector<unsigned char> block(room);
  void* memory = block.data();
  std::align(64, size, memory, room);
  rvdnav_context* context = nullptr;
  check(rvdnav_context_init(memory, size, &config, &rig, nullptr, &context));

  std::vector<uint8_t> grey(kWidth * kHeight, 20), smoothed(grey.size()), direction(grey.size());
  for (int y = 70; y < 170; ++y) {
    for (int x = 110; x < 210; ++x) grey[y * kWidth + x] = 180;
  }
  const rvdnav_image image = {grey.data(), kWidth, kHeight, kWidth};
  std::vector<uint32_t> bits(rvdnav_edge_row_words(kWidth) * kHeight);
  check(rvdnav_smooth(context, 0, &image, smoothed.data()));
  check(rvdnav_detect_edges(context, 0, smoothed.data(), bits.data(), direction.data()));
  check(rvdnav_filter_edges(context, 0, bits.data()));
  check(rvdnav_thin(context, 0, bits.data()));

  int count = 0;
  for (uint32_t word : bits) {
    for (; word != 0; word &= word - 1) ++count;
  }
  std::printf("%d edge pixels around a square of 100 x 100\n", count);
  return count >= 380 && count <= 410 ? 0 : 1;
}
