// The frame: one camera's view, and both together.
#include "abi/abi.hpp"
#include "join.hpp"
#include "view.hpp"

using namespace rvdnav;

namespace {

// An image and its view's result are there together or not at all.
rvdnav_status check_view_result(const rvdnav_context* context, const rvdnav_image* image,
                                const rvdnav_view_result* view) {
  if (image == nullptr && view == nullptr) return RVDNAV_OK;
  if (view == nullptr) return RVDNAV_ERROR_NULL;
  if (view->struct_size != sizeof(*view)) return RVDNAV_ERROR_STRUCT_SIZE;
  return check_image(context, image);
}

}  // namespace

rvdnav_status rvdnav_view(rvdnav_context* context, int32_t camera, const rvdnav_image* image,
                          const rvdnav_window* windows, uint32_t window_count, rvdnav_view_result* result) {
  RVDNAV_TRY(check_camera(context, camera));
  RVDNAV_TRY(check_image(context, image));
  RVDNAV_TRY(check_windows(windows, window_count));
  if (window_count > RVDNAV_EDGES) return RVDNAV_ERROR_ARGUMENT;
  if (result == nullptr) return RVDNAV_ERROR_NULL;
  if (result->struct_size != sizeof(*result)) return RVDNAV_ERROR_STRUCT_SIZE;
  return process_view(context->context, camera, grey_view(*image), windows, window_count, result);
}

rvdnav_status rvdnav_join(rvdnav_context* context, const rvdnav_image* left, const rvdnav_image* right,
                          const rvdnav_view_result* left_view, const rvdnav_view_result* right_view, int32_t acquire,
                          rvdnav_frame_result* result) {
  RVDNAV_TRY(check_context(context));
  if (result == nullptr || (left == nullptr && right == nullptr)) return RVDNAV_ERROR_NULL;
  if (result->struct_size != sizeof(*result)) return RVDNAV_ERROR_STRUCT_SIZE;
  Context& c = context->context;
  if (right != nullptr && c.rig.camera_count < RVDNAV_CAMERAS) return RVDNAV_ERROR_ARGUMENT;
  RVDNAV_TRY(check_view_result(context, left, left_view));
  RVDNAV_TRY(check_view_result(context, right, right_view));
  const GreyView left_grey = left != nullptr ? grey_view(*left) : GreyView{};
  const GreyView right_grey = right != nullptr ? grey_view(*right) : GreyView{};
  return join_views(c, left != nullptr ? &left_grey : nullptr, right != nullptr ? &right_grey : nullptr, left_view,
                    right_view, acquire != 0, result);
}
