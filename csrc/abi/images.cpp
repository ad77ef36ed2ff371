// What is asked of images before any stage.
#include "abi/abi.hpp"
#include "digest.hpp"
#include "interlace.hpp"
#include "noise.hpp"

using namespace rvdnav;

namespace {

constexpr int32_t kMaxLength = 4096;

rvdnav_status check_any_image(const rvdnav_image* image) {
  if (image == nullptr || image->data == nullptr) return RVDNAV_ERROR_NULL;
  const bool fits = image->width >= 1 && image->width <= kMaxLength && image->height >= 1 &&
                    image->height <= kMaxLength && image->stride >= image->width;
  return fits ? RVDNAV_OK : RVDNAV_ERROR_IMAGE;
}

}  // namespace

rvdnav_status rvdnav_image_digest(const rvdnav_image* image, uint64_t* digest) {
  RVDNAV_TRY(check_any_image(image));
  if (digest == nullptr) return RVDNAV_ERROR_NULL;
  *digest = image_digest(grey_view(*image));
  return RVDNAV_OK;
}

rvdnav_status rvdnav_noise_median(const rvdnav_image* image, uint32_t* median_q1) {
  RVDNAV_TRY(check_any_image(image));
  if (median_q1 == nullptr) return RVDNAV_ERROR_NULL;
  *median_q1 = noise_median_q1(grey_view(*image));
  return RVDNAV_OK;
}

rvdnav_status rvdnav_find_fields(const rvdnav_image* image, rvdnav_fields* fields) {
  RVDNAV_TRY(check_any_image(image));
  if (fields == nullptr) return RVDNAV_ERROR_NULL;
  if (fields->struct_size != sizeof(rvdnav_fields)) return RVDNAV_ERROR_STRUCT_SIZE;
  find_fields(grey_view(*image), fields);
  return RVDNAV_OK;
}
