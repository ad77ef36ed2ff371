// Contexts from disturbed settings, rigs and targets; and the functions that need neither.
#include "parts.hpp"

namespace {

constexpr size_t kMostMemory = 64 << 20;
constexpr int32_t kMostPixels = 8192;  // a frame takes a millisecond

rvdnav_config base_config() {
  rvdnav_config config = {};
  config.struct_size = sizeof(config);
  require(rvdnav_config_default(&config) == RVDNAV_OK);
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

// Up to 31 characters, or the name of one.
std::vector<char> name_from(Input& input, const char* known) {
  std::vector<char> name(known, known + std::strlen(known));
  for (uint32_t n = input.below(32); n > 0; --n) name.push_back(input.take<char>());
  name.push_back('\0');
  return name;
}

}  // namespace

bool prepare(Input& input, Prepared* prepared) {
  rvdnav_config& config = prepared->config = base_config();
  disturb(input, 4, sizeof(uint32_t), offsetof(rvdnav_config, clock), &config);
  if (input.one_in(8)) config.clock = rvdnav_host_clock;
  prepared->rig = base_rig();
  disturb_sized(input, 4, &prepared->rig);
  rvdnav_target target = base_target();
  disturb_sized(input, 3, &target);

  size_t needed = 0;
  if (rvdnav_context_size(&config, &prepared->rig, &needed) != RVDNAV_OK) return false;
  if (needed > kMostMemory || prepared->rig.width * prepared->rig.height > kMostPixels) return false;
  prepared->memory = aligned(needed);
  void* memory = prepared->memory.get();
  if (input.one_in(64)) {
    require(rvdnav_context_init(memory, needed - 1, &config, &prepared->rig, nullptr, &prepared->context) < 0);
    require(rvdnav_context_init(static_cast<char*>(memory) + 8, needed, &config, &prepared->rig, nullptr,
                                &prepared->context) < 0);
  }
  if (rvdnav_context_init(memory, needed, &config, &prepared->rig, nullptr, &prepared->context) != RVDNAV_OK) {
    return false;
  }
  rvdnav_context_set_target(prepared->context, &target);
  prepared->config.struct_size = sizeof(rvdnav_config);
  require(rvdnav_context_config(prepared->context, &prepared->config) == RVDNAV_OK);
  require(rvdnav_context_isa(prepared->context) > RVDNAV_ISA_AUTO);
  return true;
}

void fuzz_library(Input& input) {
  rvdnav_abi_version();
  require(rvdnav_status_text(input.take<int32_t>()) != nullptr);
  rvdnav_struct_size(name_from(input, input.one_in(2) ? "rvdnav_rig" : "").data());
  double low = 0.0, high = 0.0;
  rvdnav_config_range(name_from(input, input.one_in(2) ? "range_min" : "").data(), &low, &high);
  rvdnav_config config = {};
  config.struct_size = input.take<uint32_t>();
  rvdnav_config_default(&config);
  rvdnav_edge_row_words(input.take<int32_t>());
  int32_t isa = 0;
  rvdnav_host_isa(&isa);
}
