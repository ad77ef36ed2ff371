/* Prints the memory that a pair of cameras takes, which is all that the core ever uses. */
#include <rvdnav/rvdnav.h>
#include <stdio.h>

int main(void) {
  const rvdnav_camera camera = {670.0, 670.0, 351.5, 287.5, -0.2, 0.06, 0.0, 0.0, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  const rvdnav_rig rig = {sizeof(rig), 704, 576, 2, 670.0, 0.12, {camera, camera}};
  rvdnav_config config = {sizeof(config)};
  size_t bytes = 0;
  rvdnav_status status = rvdnav_config_default(&config);
  if (status == RVDNAV_OK) status = rvdnav_context_size(&config, &rig, &bytes);
  if (status != RVDNAV_OK) {
    fprintf(stderr, "rvdnav: %s\n", rvdnav_status_text(status));
    return 1;
  }
  printf("ABI %u: %zu bytes for two cameras of %d x %d pixels\n", (unsigned)rvdnav_abi_version(), bytes, rig.width,
         rig.height);
  return 0;
}
