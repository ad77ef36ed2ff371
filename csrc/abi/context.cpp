// Making a context.
#include <new>

#include "abi/abi.hpp"

using namespace rvdnav;

rvdnav_status rvdnav_config_default(rvdnav_config* config) {
  if (config == nullptr) return RVDNAV_ERROR_NULL;
  if (config->struct_size != sizeof(*config)) return RVDNAV_ERROR_STRUCT_SIZE;
  rvdnav_config c = {};
  c.struct_size = sizeof(c);
  c.isa = RVDNAV_ISA_AUTO;
  c.edge_floor = 6;
  c.edge_weber_q8 = 26;
  c.edge_knee = 160;
  c.edge_min_run = 6;
  c.hough_rho_bins = 0;
  c.hough_spread = 3;
  c.peak_min_votes = 18;
  c.segment_min_length = 16;
  c.segment_max_gap = 6;
  c.max_edgels = 0;
  c.max_peaks = 512;
  c.max_segments = 512;
  c.max_bars = 256;
  c.max_hypotheses = 20000;
  c.match_half_window = 5;
  c.match_row_tolerance = 1;
  c.match_min_score_q8 = 179;
  c.match_uniqueness_q8 = 243;
  c.match_max_gradient_q8 = 256;
  c.match_consistency_q8 = 256;
  c.range_min = 0.25;
  c.range_max = 1.7;
  c.blur_sigma = 0.7;
  *config = c;
  return RVDNAV_OK;
}

rvdnav_status rvdnav_context_size(const rvdnav_config* config, const rvdnav_rig* rig, size_t* size) {
  if (config == nullptr || rig == nullptr || size == nullptr) return RVDNAV_ERROR_NULL;
  RVDNAV_TRY(validate(*config));
  RVDNAV_TRY(validate(*rig));
  Arena count;
  Context unused = {};
  lay_out(*config, *rig, count, &unused);
  *size = align_up(sizeof(rvdnav_context)) + count.used();
  return RVDNAV_OK;
}

rvdnav_status rvdnav_context_init(void* memory, size_t size, const rvdnav_config* config, const rvdnav_rig* rig,
                                  const rvdnav_target* target, rvdnav_context** context) {
  if (memory == nullptr || context == nullptr) return RVDNAV_ERROR_NULL;
  *context = nullptr;
  size_t needed = 0;
  RVDNAV_TRY(rvdnav_context_size(config, rig, &needed));
  if (target != nullptr) RVDNAV_TRY(validate(*target));
  if (size < needed || reinterpret_cast<uintptr_t>(memory) % kAlignment != 0) return RVDNAV_ERROR_MEMORY;

  auto* made = new (memory) rvdnav_context{};
  const size_t head = align_up(sizeof(rvdnav_context));
  Arena arena(static_cast<unsigned char*>(memory) + head, size - head);
  lay_out(*config, *rig, arena, &made->context);
  RVDNAV_TRY(build(&made->context));
  set_target(target, &made->context);
  made->self = made;
  made->magic = kContextMagic;
  *context = made;
  return RVDNAV_OK;
}

rvdnav_status rvdnav_context_set_target(rvdnav_context* context, const rvdnav_target* target) {
  RVDNAV_TRY(check_context(context));
  if (target != nullptr) RVDNAV_TRY(validate(*target));
  set_target(target, &context->context);
  return RVDNAV_OK;
}

rvdnav_status rvdnav_context_config(const rvdnav_context* context, rvdnav_config* config) {
  RVDNAV_TRY(check_context(context));
  if (config == nullptr) return RVDNAV_ERROR_NULL;
  if (config->struct_size != sizeof(*config)) return RVDNAV_ERROR_STRUCT_SIZE;
  *config = context->context.config;
  return RVDNAV_OK;
}

int32_t rvdnav_context_isa(const rvdnav_context* context) {
  const rvdnav_status status = check_context(context);
  return status == RVDNAV_OK ? context->context.kernels->isa : status;
}
