// The surface: reconstruction in memory that the caller lends for the call.
#include "surface.hpp"
#include "abi/abi.hpp"

using namespace rvdnav;

namespace {

rvdnav_status check_stereo(const rvdnav_context* context) {
  RVDNAV_TRY(check_context(context));
  return context->context.rig.camera_count == RVDNAV_CAMERAS ? RVDNAV_OK : RVDNAV_ERROR_ARGUMENT;
}

}  // namespace

rvdnav_status rvdnav_surface_size(const rvdnav_context* context, size_t* size) {
  RVDNAV_TRY(check_stereo(context));
  if (size == nullptr) return RVDNAV_ERROR_NULL;
  Arena count;
  SurfaceMemory unused = {};
  lay_out(context->context.rig, count, &unused);
  *size = count.used();
  return RVDNAV_OK;
}

rvdnav_status rvdnav_surface(const rvdnav_context* context, const rvdnav_image* left, const rvdnav_image* right,
                             void* memory, size_t size, rvdnav_surface_point* points, uint32_t capacity,
                             uint32_t* count, uint32_t* crossings) {
  RVDNAV_TRY(check_stereo(context));
  RVDNAV_TRY(check_image(context, left));
  RVDNAV_TRY(check_image(context, right));
  if (memory == nullptr || count == nullptr || crossings == nullptr) return RVDNAV_ERROR_NULL;
  if (points == nullptr && capacity > 0) return RVDNAV_ERROR_NULL;
  size_t needed = 0;
  RVDNAV_TRY(rvdnav_surface_size(context, &needed));
  if (size < needed || reinterpret_cast<uintptr_t>(memory) % kAlignment != 0) return RVDNAV_ERROR_MEMORY;
  const Context& c = context->context;
  Arena arena(memory, size);
  SurfaceMemory work = {};
  lay_out(c.rig, arena, &work);
  const SurfaceCounts counts =
      reconstruct_surface(c.config, c.rig, grey_view(*left), grey_view(*right), work, points, capacity);
  *crossings = counts.crossings;
  return finish_list(counts.written, counts.points, count);
}
