// Stages 1 to 3 and the way into rectified coordinates, each by itself.
#include "abi/abi.hpp"
#include "edge.hpp"
#include "rectify.hpp"
#include "smooth.hpp"
#include "thin.hpp"

using namespace rvdnav;

rvdnav_status rvdnav_smooth(rvdnav_context* context, int32_t camera, const rvdnav_image* image, uint8_t* smoothed) {
  RVDNAV_TRY(check_camera(context, camera));
  RVDNAV_TRY(check_image(context, image));
  if (smoothed == nullptr) return RVDNAV_ERROR_NULL;
  Context& c = context->context;
  smooth(grey_view(*image), *c.kernels, c.work[camera].smooth_row, smoothed);
  return RVDNAV_OK;
}

uint32_t rvdnav_edge_row_words(int32_t width) { return width > 0 ? static_cast<uint32_t>(edge_row_words(width)) : 0; }

rvdnav_status rvdnav_detect_edges(rvdnav_context* context, int32_t camera, const uint8_t* smoothed, uint32_t* edge_bits,
                                  uint8_t* direction) {
  RVDNAV_TRY(check_camera(context, camera));
  if (smoothed == nullptr || edge_bits == nullptr || direction == nullptr) return RVDNAV_ERROR_NULL;
  Context& c = context->context;
  const int32_t w = c.rig.width, h = c.rig.height;
  detect_edges(smoothed, w, h, c.threshold, *c.kernels, c.work[camera].edge, edge_bits);
  for (ptrdiff_t i = 0; i < static_cast<ptrdiff_t>(w) * h; ++i) direction[i] = 0;
  edge_directions(smoothed, w, h, *c.kernels, edge_bits, direction);
  return RVDNAV_OK;
}

rvdnav_status rvdnav_filter_edges(rvdnav_context* context, int32_t camera, uint32_t* edge_bits) {
  RVDNAV_TRY(check_camera(context, camera));
  RVDNAV_TRY(check_edge_bits(context, edge_bits));
  Context& c = context->context;
  filter_edges(edge_bits, c.rig.width, c.rig.height, c.config.edge_min_run, *c.kernels, c.work[camera].bit_scratch);
  return RVDNAV_OK;
}

rvdnav_status rvdnav_thin(rvdnav_context* context, int32_t camera, uint32_t* edge_bits) {
  RVDNAV_TRY(check_camera(context, camera));
  RVDNAV_TRY(check_edge_bits(context, edge_bits));
  Context& c = context->context;
  thin(edge_bits, c.rig.width, c.rig.height, *c.kernels, c.work[camera].thin);
  return RVDNAV_OK;
}

rvdnav_status rvdnav_rectify_edges(rvdnav_context* context, int32_t camera, const uint32_t* edge_bits,
                                   const uint8_t* direction, rvdnav_edgel* edgels, uint32_t capacity, uint32_t* count) {
  RVDNAV_TRY(check_camera(context, camera));
  RVDNAV_TRY(check_edge_bits(context, edge_bits));
  if (direction == nullptr || count == nullptr) return RVDNAV_ERROR_NULL;
  if (edgels == nullptr && capacity > 0) return RVDNAV_ERROR_NULL;
  const Context& c = context->context;
  uint32_t total = 0;
  const uint32_t written = rectify_edges(edge_bits, direction, c.rig.width, c.rig.height, c.lens[camera], *c.kernels,
                                         edgels, capacity, &total);
  return finish_list(written, total, count);
}
